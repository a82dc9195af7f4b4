// Starts `pse lsp` and lets it answer for programs of pse.

const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const settings = workspace.getConfiguration("pse");
  const folders = settings.get("path").flatMap((folder) => ["--path", folder]);
  const server = { command: settings.get("command"), args: ["lsp", ...folders] };
  client = new LanguageClient("pse", "pse", server, {
    documentSelector: [
      { scheme: "file", language: "pse" },
      { scheme: "untitled", language: "pse" },
    ],
    // Imports that change on disk.
    synchronize: { fileEvents: workspace.createFileSystemWatcher("**/*.pse") },
  });
  return client.start();
};

exports.deactivate = () => client?.stop();
