local function sieve(n)
  local flags, found = {}, 0
  for i = 0, n do flags[i] = true end
  local i = 2
  while i <= n do
    if flags[i] then
      found = found + 1
      local k = i + i
      while k <= n do flags[k] = false; k = k + i end
    end
    i = i + 1
  end
  return found
end
local start, found = os.clock(), 0
for _ = 1, 5 do found = sieve(200000) end
assert(found == 17984)
print((os.clock() - start) * 1e3)
