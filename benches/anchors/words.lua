local words = {}
for i = 0, 999 do words[i] = "word-" .. i end
local start = os.clock()
local counts, x = {}, 1
for _ = 1, 300000 do
  x = x * 16807 % 2147483647
  local word = words[x % 1000]
  counts[word] = (counts[word] or 0) + 1
end
local sum = 0
for _, count in pairs(counts) do sum = sum + count end
assert(sum == 300000)
print((os.clock() - start) * 1e3)
