autocmd BufRead,BufNewFile *.pse setfiletype pse
