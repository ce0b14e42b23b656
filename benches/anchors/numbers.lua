local lines = {}
for i = 0, 19999 do lines[#lines + 1] = string.format("%d %d %.1f", i, 3 * i, i + 0.5) end
local start = os.clock()
local sum = 0
for _, line in ipairs(lines) do
  for word in string.gmatch(line, "[^ ]+") do sum = sum + tonumber(word) end
end
assert(sum == 999960000)
print((os.clock() - start) * 1e3)
