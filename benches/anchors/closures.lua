local function counter(start)
  return function() start = start + 1 return start end
end
local start, sum = os.clock(), 0
for i = 0, 999999 do
  local next = counter(i)
  next()
  sum = sum + next()
end
assert(sum == 500001500000)
print((os.clock() - start) * 1e3)
