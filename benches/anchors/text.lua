local start = os.clock()
local lines = {}
for i = 0, 49999 do lines[#lines + 1] = string.format("%d: %d of %s", i, i * i, "things") end
local parts = {}
for part in string.gmatch(table.concat(lines, ";"), "[^;]+") do parts[#parts + 1] = part end
assert(#parts == 50000)
print((os.clock() - start) * 1e3)
