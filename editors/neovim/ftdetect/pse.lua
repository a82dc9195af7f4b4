vim.filetype.add({ extension = { pse = "pse" } })
