-- What a person does in Neovim, written down as JSON for tests/cli/test_editors.py.
-- Started as: nvim --headless -u CONFIGURATION -l neovim.lua PROGRAM WITHOUT_SETUP OUTPUT
local program, bare, output = unpack(_G.arg)
local seen = {}
local patience = 60000 -- ms, on a loaded machine; nothing waits for it when the server answers

local function await(what, is_there)
  assert(vim.wait(patience, is_there, 20), "not seen in time: " .. what)
end

local function read_line(number)
  return vim.api.nvim_buf_get_lines(0, number - 1, number, false)[1]
end

local function list_lenses()
  return vim.tbl_map(function(lens) return lens.command.title end, vim.lsp.codelens.get(0))
end

local function show_hover()
  vim.lsp.buf.hover()
  local text
  await("hover", function()
    for _, window in ipairs(vim.api.nvim_list_wins()) do
      if vim.api.nvim_win_get_config(window).relative ~= "" then
        text = table.concat(vim.api.nvim_buf_get_lines(vim.api.nvim_win_get_buf(window), 0, -1, false), "\n")
        vim.api.nvim_win_close(window, true)
        return true
      end
    end
  end)
  return text
end

vim.cmd.edit(program)
seen.filetype = vim.bo.filetype
await("diagnostics", function() return #vim.diagnostic.get(0) > 0 end)
seen.diagnostics = vim.tbl_map(function(one)
  return { code = one.code, line = one.lnum + 1, word = read_line(one.lnum + 1):sub(one.col + 1, one.end_col) }
end, vim.diagnostic.get(0))
await("lens of the refused program", function() return #list_lenses() > 0 end)
seen.refused = list_lenses()

-- the quick fix under the cursor, as the key for code actions applies it
vim.api.nvim_win_set_cursor(0, { seen.diagnostics[1].line, 4 })
vim.lsp.buf.code_action({ apply = true })
await("no diagnostics after the quick fix", function() return #vim.diagnostic.get(0) == 0 end)
seen.mended = table.concat(vim.api.nvim_buf_get_lines(0, 0, -1, false), "\n") .. "\n"
await("lens of the mended program", function() return vim.startswith(list_lenses()[1] or "", "can run") end)
seen.hover = show_hover()

vim.lsp.buf.document_symbol({ on_list = function(list)
  seen.symbols = vim.tbl_map(function(item) return item.text end, list.items)
end })
await("symbols", function() return seen.symbols end)

vim.fn.search("P100")
vim.lsp.buf.definition({ on_list = function(list) seen.definition = list.items[1].lnum end })
await("definition", function() return seen.definition end)
vim.cmd.write()

-- a program without a set-up: the quick fix writes the file
vim.cmd.edit(bare)
await("diagnostics of the program without a set-up", function() return #vim.diagnostic.get(0) > 0 end)
vim.api.nvim_win_set_cursor(0, { vim.diagnostic.get(0)[1].lnum + 1, 0 })
vim.lsp.buf.code_action({
  apply = true,
  filter = function(action) return vim.startswith(action.title, "Write bare.nc.toml") end,
})
await("set-up", function() return vim.fn.bufexists(bare .. ".toml") == 1 end)
seen.setup = table.concat(vim.api.nvim_buf_get_lines(vim.fn.bufnr(bare .. ".toml"), 0, -1, false), "\n")

vim.fn.writefile({ vim.json.encode(seen) }, output)
vim.cmd("qa!")
