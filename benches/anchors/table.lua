local start = os.clock()
local entries, sum = {}, 0
for i = 0, 299999 do entries[i * 7] = i end
for i = 0, 299999 do sum = sum + entries[i * 7] end
assert(sum == 44999850000)
print((os.clock() - start) * 1e3)
