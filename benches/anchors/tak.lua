local function tak(x, y, z)
  if x <= y then return z end
  return tak(tak(x - 1, y, z), tak(y - 1, z, x), tak(z - 1, x, y))
end
local start = os.clock()
local found
for _ = 1, 5 do found = tak(18, 12, 6) end
assert(found == 7)
print((os.clock() - start) * 1e3)
