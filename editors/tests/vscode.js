// A session of VS Code with the installed extension, over a copy of the project beside this file. It is run by VS Code
// itself, as the tests of an extension are:
//   code --extensionDevelopmentPath=editors/vscode --extensionTestsPath=editors/tests/vscode.js FOLDER
// FOLDER is the copy. What is not as expected stands in FOLDER/session.txt, with the count in the last line.

const fs = require("fs");
const path = require("path");
const vscode = require("vscode");

const failures = [];
let asked = 0;

function check(name, ok, got) {
  asked += 1;
  if (!ok) {
    failures.push(`${name}: ${JSON.stringify(got)}`);
  }
}

async function until(name, condition) {
  let got;
  for (const end = Date.now() + 20000; Date.now() < end; await new Promise((done) => setTimeout(done, 50))) {
    got = await condition();
    if (got) {
      break;
    }
  }
  check(name, got, "it took too long");
  return got;
}

function at(value, keys) {
  return keys.split(".").filter(Boolean).reduce((found, key) => found?.[key], value);
}

function is(want, got, op) {
  const list = Array.isArray(got) ? got : [];
  switch (op) {
    case "is": return want === null ? got == null : got === want;
    case "has": return typeof got === "string" && got.includes(want);
    case "count": return list.length === want;
    case "more": return list.length > want;
    default: return list.some((one) => one[want[0]] === want[1]);
  }
}

async function requests(client, folder) {
  for (const request of JSON.parse(fs.readFileSync(path.join(__dirname, "requests.json"), "utf8"))) {
    const text = await vscode.workspace.openTextDocument(path.join(folder, request.file));
    const uri = client.code2ProtocolConverter.asUri(text.uri);
    const params = { ...request.params };
    if (params.data) {
      params.data = uri;
    }
    if (request.method.startsWith("textDocument")) {
      params.textDocument = { uri };
    }
    if (request.word) {
      const column = text.lineAt(request.line).text.indexOf(request.word) + (request.offset ?? 1);
      params.position = { line: request.line, character: column };
    }
    const refused = (error) => ({ error: error.message });
    const answer = await client.sendRequest(request.method, params).catch(refused);
    for (const [keys, op, want] of request.want) {
      const got = keys === "changes.$uri" ? answer?.changes?.[uri] : at(answer, keys);
      check(request.name, is(want, got, op), got);
    }
  }
}

/** What a user sees, by the providers that VS Code asks. */
async function seen(folder) {
  const text = await vscode.workspace.openTextDocument(path.join(folder, "main.rpl"));
  const editor = await vscode.window.showTextDocument(text);
  const place = (line, word) => new vscode.Position(line, text.lineAt(line).text.indexOf(word) + 1);
  const ask = (name, ...more) => vscode.commands.executeCommand(`vscode.execute${name}`, text.uri, ...more);
  const colours = () => vscode.commands.executeCommand("vscode.provideDocumentSemanticTokens", text.uri);
  const told = (hovers) => hovers.flatMap((hover) => hover.contents).map((content) => content.value).join("\n");
  const whole = () => new vscode.Range(0, 0, text.lineCount, 0);
  check("the language", text.languageId === "rpl", text.languageId);
  const hover = await ask("HoverProvider", place(17, "inspect"));
  check("hover", told(hover).includes("looks at it for some seconds"), hover);
  const library = await ask("DefinitionProvider", place(7, "go-to"));
  const target = library[0]?.targetUri ?? library[0]?.uri;
  check("a definition of the library", target?.toString() === "rpl:/robot.rpl", library);
  const read = await vscode.workspace.openTextDocument(target);
  const line = (library[0].targetSelectionRange ?? library[0].range).start.line;
  check("it is there", read.lineAt(line).text.startsWith("(def-plan go-to "), read.lineAt(line).text);
  check("it is of the language", read.languageId === "rpl", read.languageId);
  const hints = await ask("InlayHintProvider", whole());
  check("names of parameters", hints.map((hint) => hint.label).join(" ") === "seconds: limit:", hints);
  const lenses = await ask("CodeLensProvider");
  check("a lens", lenses[0]?.command?.command === "rpl.run", lenses);
  const symbols = await vscode.commands.executeCommand("vscode.executeWorkspaceSymbolProvider", "round");
  check("symbols of the project", symbols.some((one) => one.name === "round-trip"), symbols);
  check("the outline", (await ask("DocumentSymbolProvider")).length === 3, "other");
  check("folding", (await ask("FoldingRangeProvider")).length >= 2, "none");
  check("semantic colours", (await colours()).data.length > 100, "none");

  const findings = () => vscode.languages.getDiagnostics(text.uri);
  await editor.edit((change) => change.replace(text.lineAt(19).range, "(print   (keep-cont 3))"));
  await until("findings after an edit", () => findings().length === 1);
  const actions = await ask("CodeActionProvider", findings()[0].range);
  const mend = actions.find((action) => action.isPreferred);
  check("a finding can be mended", mend, actions);
  await vscode.workspace.applyEdit(mend.edit);
  await until("it is mended", () => findings().length === 0 && text.lineAt(19).text.includes("keep-count"));
  await vscode.commands.executeCommand("editor.action.formatDocument");
  check("the text is laid out", text.lineAt(19).text === "(print (keep-count 3))", text.lineAt(19).text);
  const renamed = await vscode.commands.executeCommand("vscode.executeDocumentRenameProvider", text.uri, place(12, "count"), "number");
  await vscode.workspace.applyEdit(renamed);
  check("a variable is renamed", text.lineAt(14).text === "      (incf number))", text.lineAt(14).text);

  const ended = (name) => new Promise((done) => {
    const listener = vscode.tasks.onDidEndTaskProcess((event) => {
      if (event.execution.task.name.startsWith(name)) {
        listener.dispose();
        done(event.exitCode);
      }
    });
  });
  const run = ended("run");
  await vscode.commands.executeCommand("rpl.run", text.uri.fsPath);
  check("a plan is run", (await run) === 0, await run);
  check("it was saved first", !text.isDirty, text.isDirty);
  const tested = ended("test");
  await vscode.commands.executeCommand("rpl.test", path.join(folder, "tests.rpl"), "nothing-is-added");
  check("a test is run", (await tested) === 0, await tested);
  await vscode.commands.executeCommand("rpl.restart");
  await until("the server answers after a restart", async () =>
    told(await ask("HoverProvider", place(17, "inspect"))).includes("looks at it"));
}

exports.run = async () => {
  const folder = vscode.workspace.workspaceFolders[0].uri.fsPath;
  try {
    const extension = await vscode.extensions.getExtension("rpl.rpl").activate();
    await requests(extension.client(), folder);
    await seen(folder);
  } catch (error) {
    failures.push(`${error.stack ?? error}`);
  }
  const count = `VS Code ${vscode.version}: ${asked - failures.length} of ${asked} as expected`;
  fs.writeFileSync(path.join(folder, "session.txt"), [...failures, count, ""].join("\n"));
};
