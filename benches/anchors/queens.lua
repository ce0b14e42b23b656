local function safe(row, dist, placed)
  return placed == nil
    or (placed[1] ~= row and placed[1] ~= row + dist and placed[1] ~= row - dist and safe(row, dist + 1, placed[2]))
end
local function place(column, placed, n)
  if column == n then return 1 end
  local found, row = 0, 0
  while row < n do
    if safe(row, 1, placed) then found = found + place(column + 1, {row, placed}, n) end
    row = row + 1
  end
  return found
end
local start, found = os.clock(), 0
for _ = 1, 10 do found = place(0, nil, 8) end
assert(found == 92)
print((os.clock() - start) * 1e3)
