-- In pieces of 15 bits, because LuaJIT's numbers are floats.
local function step(x)
  local high, low = math.floor(x / 32768), x % 32768
  return (((high * 1103515245) % 65536 * 32768) % 2147483648 + low * 1103515245 + 12345) % 2147483648
end
local numbers, x = {}, 42
for i = 1, 100000 do
  x = step(x)
  numbers[i] = x
end
local start = os.clock()
table.sort(numbers, function(a, b) return a < b end)
assert(numbers[50001] == 1072443146)
print((os.clock() - start) * 1e3)
