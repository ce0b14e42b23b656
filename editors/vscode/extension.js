// Starts `rpl lsp` for the texts and `rpl dap` for the debugger; all they know is in the command.

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function command() {
  return vscode.workspace.getConfiguration("rpl").get("command", "rpl");
}

function activate(context) {
  const server = { command: command(), args: ["lsp"] };
  const options = {
    documentSelector: [{ language: "rpl" }],
    synchronize: { fileEvents: vscode.workspace.createFileSystemWatcher("**/{*.rpl,*.toml}") },
  };
  client = new LanguageClient("rpl", "RPL", server, options);
  const factory = {
    createDebugAdapterDescriptor: () => new vscode.DebugAdapterExecutable(command(), ["dap"]),
  };
  context.subscriptions.push(client, vscode.debug.registerDebugAdapterDescriptorFactory("rpl", factory));
  return client.start();
}

function deactivate() {
  return client?.stop();
}

module.exports = { activate, deactivate };
