local start = os.clock()
local known = {}
local function ways(n, most)
  if n == 0 then return 1 end
  if n < 0 or most == 0 then return 0 end
  local key = n * 1000 + most
  local found = known[key]
  if found then return found end
  found = ways(n, most - 1) + ways(n - most, most)
  known[key] = found
  return found
end
local found
for _ = 1, 6 do
  known = {}
  found = ways(150, 150)
end
assert(found == 40853235313)
print((os.clock() - start) * 1e3)
