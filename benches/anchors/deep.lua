local function depth(n) if n == 0 then return 0 end return 1 + depth(n - 1) end
local start = os.clock()
local sum = 0
for _ = 1, 100 do sum = sum + depth(10000) end
assert(sum == 1000000)
print((os.clock() - start) * 1e3)
