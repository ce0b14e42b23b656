local function map(f, l) local r = {} for i = 1, #l do r[i] = f(l[i]) end return r end
local function filter(p, l) local r = {} for i = 1, #l do local e = l[i] if p(e) then r[#r + 1] = e end end return r end
local numbers = {}
for i = 999999, 0, -1 do numbers[#numbers + 1] = i end
local start = os.clock()
local found = filter(function(n) return n < 1500000 end, map(function(n) return n * 3 end, numbers))
assert(#found == 500000)
print((os.clock() - start) * 1e3)
