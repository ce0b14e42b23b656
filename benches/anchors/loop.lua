local function sum_to(n)
  local i, sum = 0, 0
  while i < n do sum = sum + i; i = i + 1 end
  return sum
end
local start = os.clock()
assert(sum_to(10000000) == 49999995000000)
print((os.clock() - start) * 1e3)
