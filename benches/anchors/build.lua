local function build(n)
  local words = nil
  for i = 0, n - 1 do words = {"n" .. tostring(i), words} end
  local reversed = {}
  while words do reversed[#reversed + 1] = words[1]; words = words[2] end
  return #table.concat(reversed, ",")
end
local start = os.clock()
assert(build(200000) == 1488889)
print((os.clock() - start) * 1e3)
