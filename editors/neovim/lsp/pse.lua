-- How Neovim 0.11 and later starts the language server.
return {
  cmd = { "pse", "lsp" },
  filetypes = { "pse" },
  root_markers = { ".git" },
}
