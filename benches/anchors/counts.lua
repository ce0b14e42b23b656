local start = os.clock()
local counts, x = {}, 1
for _ = 1, 100000 do
  x = x * 16807 % 2147483647
  local name = string.format("room-%d", x % 500)
  counts[name] = (counts[name] or 0) + 1
end
local known, most = 0, 0
for _, count in pairs(counts) do
  known, most = known + 1, math.max(most, count)
end
assert(known * 1000 + most == 500239)
print((os.clock() - start) * 1e3)
