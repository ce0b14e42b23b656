-- A session of Neovim with the settings of docs/editors.md, over a copy of the project beside this file:
--   nvim --headless --clean -c "luafile editors/tests/neovim.lua"
-- It needs `rpl` in the path, and ends with the number of answers that were not as expected.

local here = vim.fn.fnamemodify(debug.getinfo(1, "S").source:sub(2), ":p:h")
local read = function(file) return table.concat(vim.fn.readfile(file), "\n") end

-- The block of the page behind a line.
local page = read(here .. "/../../docs/editors.md")
local function block(after)
  local from = select(2, page:find(after, 1, true))
  return assert(page:match("```text\n(.-)\n```", from))
end

local is_new = vim.fn.has("nvim-0.11") == 1
assert(loadstring(block(is_new and "From 0.11 on" or "From 0.8 on:")))()
assert(loadstring(block("In both, for the lenses")))()
vim.cmd("filetype plugin on")

local project = vim.fn.tempname()
vim.fn.mkdir(project, "p")
for _, file in ipairs(vim.fn.readdir(here .. "/project")) do
  vim.fn.writefile(vim.fn.readfile(here .. "/project/" .. file), project .. "/" .. file)
end
-- A folder below a link has another name for the server.
project = vim.loop.fs_realpath(project)

local failed, asked = 0, 0
local function check(name, ok, got)
  asked = asked + 1
  if not ok then
    failed = failed + 1
    io.write(name, ": ", vim.inspect(got), "\n")
  end
end

local function open(file)
  vim.cmd("edit " .. project .. "/" .. file)
  local buffer = vim.api.nvim_get_current_buf()
  local clients = vim.lsp.get_clients or vim.lsp.get_active_clients
  vim.wait(20000, function()
    local client = clients({ bufnr = buffer })[1]
    return client and client.initialized and client.server_capabilities and vim.lsp.buf_is_attached(buffer, client.id)
  end, 20)
  return buffer
end

local function at(value, path)
  for key in path:gmatch("[^.]+") do
    if type(value) ~= "table" then return nil end
    value = value[tonumber(key) and tonumber(key) + 1 or key]
  end
  return value
end

local function is(want, got, op)
  if want == vim.NIL then return got == nil or got == vim.NIL end
  local list = type(got) == "table" and got or {}
  if op == "is" then return got == want end
  if op == "has" then return type(got) == "string" and got:find(want, 1, true) ~= nil end
  if op == "count" then return #list == want end
  if op == "more" then return #list > want end
  return vim.tbl_contains(vim.tbl_map(function(one) return one[want[1]] == want[2] end, list), true)
end

local function ask(buffer, method, params)
  local answers = vim.lsp.buf_request_sync(buffer, method, params, 20000)
  local _, answer = next(answers or {})
  if answer and (answer.error or answer.err) then return { error = (answer.error or answer.err).message } end
  return answer and answer.result
end

for _, request in ipairs(vim.json.decode(read(here .. "/requests.json"))) do
  local buffer = open(request.file)
  local uri = vim.uri_from_bufnr(buffer)
  local params = request.params or vim.empty_dict()
  if params.data then params.data = uri end
  if vim.startswith(request.method, "textDocument") then params.textDocument = { uri = uri } end
  if request.line then
    local text = vim.api.nvim_buf_get_lines(buffer, request.line, request.line + 1, true)[1]
    local column = assert(text:find(request.word, 1, true)) - 1 + (request.offset or 1)
    params.position = { line = request.line, character = column }
  end
  local answer = ask(buffer, request.method, params)
  for _, want in ipairs(request.want) do
    local path, op, value = want[1], want[2], want[3]
    local got = path == "changes.$uri" and at(answer, "changes") and answer.changes[uri] or at(answer, path)
    check(request.name, is(value, got, op), got)
  end
end

-- What a user does: by the commands of the editor.
local function until_true(name, condition)
  check(name, vim.wait(20000, condition, 20), "it took too long")
end
local main = open("main.rpl")
local function line(number) return vim.api.nvim_buf_get_lines(main, number, number + 1, true)[1] end

check("the word for comments", vim.bo.commentstring == "; %s" and vim.bo.lisp, vim.bo.commentstring)
vim.api.nvim_win_set_cursor(0, { 8, 4 })
vim.lsp.buf.definition()
until_true("a definition of the library is opened", function() return vim.fn.expand("%:t") == "robot.rpl" end)
check("it is there", vim.api.nvim_get_current_line():find("(def-plan go-to ", 1, true) == 1, vim.api.nvim_get_current_line())
check("it is only read", vim.bo.readonly, vim.bo.readonly)
vim.wait(1000)
check("it has no findings", #vim.diagnostic.get(0) == 0, vim.diagnostic.get(0))

vim.cmd("buffer " .. main)
vim.api.nvim_buf_set_lines(main, 19, 20, true, { "(print   (keep-cont 3))" })
until_true("findings after an edit", function() return #vim.diagnostic.get(main) == 1 end)
vim.api.nvim_win_set_cursor(0, { 20, 12 })
vim.lsp.buf.code_action({ apply = true, filter = function(action) return action.isPreferred end })
until_true("a finding is mended", function() return (line(19) or ""):find("keep-count", 1, true) ~= nil end)
until_true("no findings after it", function() return #vim.diagnostic.get(main) == 0 end)
vim.lsp.buf.format({ timeout_ms = 20000 })
check("the text is laid out", line(19) == "(print (keep-count 3))", line(19))
vim.api.nvim_win_set_cursor(0, { 13, 10 })
vim.lsp.buf.rename("number")
until_true("a variable is renamed", function() return line(14) == "      (incf number))" end)
vim.cmd("silent write")

if vim.lsp.inlay_hint then
  vim.lsp.inlay_hint.enable(true, { bufnr = main })
  until_true("names of parameters are shown", function() return #vim.lsp.inlay_hint.get({ bufnr = main }) == 2 end)
end
vim.lsp.codelens.refresh()
until_true("a lens is shown", function() return #vim.lsp.codelens.get(main) == 1 end)
vim.api.nvim_win_set_cursor(0, { 1, 0 })
vim.lsp.codelens.run()
until_true("a lens runs the plan", function()
  return vim.bo.buftype == "terminal" and table.concat(vim.api.nvim_buf_get_lines(0, 0, -1, false), "\n"):find("\n1\n", 1, true)
end)

io.write(string.format("%s: %d of %d as expected\n", tostring(vim.version()), asked - failed, asked))
vim.cmd(failed == 0 and "qall!" or "cquit!")
