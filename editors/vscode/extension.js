// Starts `rpl lsp` for the texts and `rpl dap` for the debugger, and runs plans and tests in a terminal. All it knows of
// the language is in the command; the texts of the library (`rpl:/…`) are asked of the server by the client itself.

const path = require("path");
const vscode = require("vscode");
const { LanguageClient, State } = require("vscode-languageclient/node");

let client;

function command() {
  return vscode.workspace.getConfiguration("rpl").get("command", "rpl");
}

function newClient() {
  const server = { command: command(), args: ["lsp"] };
  const options = {
    documentSelector: [{ language: "rpl" }],
    // The lenses that this extension has commands for.
    initializationOptions: { commands: ["rpl.run", "rpl.test"] },
  };
  return new LanguageClient("rpl", "RPL", server, options);
}

/** Runs the command on a file in a terminal, once what is typed is saved. */
async function runInTerminal(name, file, args) {
  const open = vscode.workspace.textDocuments.find((text) => text.uri.scheme === "file" && text.uri.fsPath === file);
  if (open?.isDirty && !(await open.save())) {
    return;
  }
  const folder = vscode.workspace.getWorkspaceFolder(vscode.Uri.file(file));
  const cwd = folder?.uri.fsPath ?? path.dirname(file);
  // Without a shell there is nothing to quote.
  const execution = new vscode.ProcessExecution(command(), args, { cwd });
  const task = new vscode.Task({ type: "rpl", file }, folder ?? vscode.TaskScope.Workspace, name, "rpl", execution, "$rpl");
  task.presentationOptions = { clear: true, focus: false, panel: vscode.TaskPanelKind.Shared };
  await vscode.tasks.executeTask(task);
}

/** The file of a command: the one it is called with, or the one that is looked at. */
function fileOf(argument) {
  const uri = vscode.window.activeTextEditor?.document.uri;
  const given = argument instanceof vscode.Uri ? argument.fsPath : argument;
  const file = given ?? (uri?.scheme === "file" ? uri.fsPath : undefined);
  if (!file) {
    vscode.window.showErrorMessage("RPL: no plan is open that has a file.");
  }
  return file;
}

function run(argument) {
  const file = fileOf(argument);
  return file && runInTerminal(`run ${path.basename(file)}`, file, ["run", file]);
}

function test(argument, name) {
  const file = fileOf(argument);
  const filter = typeof name === "string" ? ["--filter", name] : [];
  return file && runInTerminal(`test ${path.basename(file)}`, file, ["test", file, ...filter]);
}

/** Shows in the status bar whether the server runs. */
function newStatus() {
  const status = vscode.languages.createLanguageStatusItem("rpl.server", { language: "rpl" });
  status.name = "RPL";
  status.command = { command: "rpl.restart", title: "Restart" };
  const show = (state) => {
    status.busy = state === State.Starting;
    status.text = { [State.Starting]: "RPL starts", [State.Running]: "RPL", [State.Stopped]: "RPL has stopped" }[state];
    const severity = vscode.LanguageStatusSeverity;
    status.severity = state === State.Stopped ? severity.Error : severity.Information;
    status.detail = client?.initializeResult?.serverInfo?.version ?? command();
  };
  return { status, show };
}

/** Says that the server does not start, and where its command is set. */
async function tell(error) {
  const settings = "Settings";
  const message = `RPL: the server "${command()} lsp" does not start: ${error.message ?? error}`;
  if ((await vscode.window.showErrorMessage(message, settings)) === settings) {
    await vscode.commands.executeCommand("workbench.action.openSettings", "rpl.command");
  }
}

async function activate(context) {
  const { status, show } = newStatus();
  const begin = () => {
    client = newClient();
    client.onDidChangeState(({ newState }) => show(newState));
    // Nobody waits for a message to be read: the commands are there without a server, too.
    return client.start().catch((error) => void tell(error));
  };
  const restart = async () => {
    // One that has failed to start has nothing to stop.
    await client.dispose().catch(() => {});
    await begin();
  };
  const factory = {
    createDebugAdapterDescriptor: () => new vscode.DebugAdapterExecutable(command(), ["dap"]),
  };
  context.subscriptions.push(
    status,
    vscode.commands.registerCommand("rpl.run", run),
    vscode.commands.registerCommand("rpl.test", test),
    vscode.commands.registerCommand("rpl.restart", restart),
    vscode.workspace.onDidChangeConfiguration((change) => change.affectsConfiguration("rpl.command") && restart()),
    vscode.debug.registerDebugAdapterDescriptorFactory("rpl", factory),
  );
  await begin();
  // For other extensions: the client that is in use, which a restart replaces.
  return { client: () => client };
}

function deactivate() {
  return client?.dispose();
}

module.exports = { activate, deactivate };
