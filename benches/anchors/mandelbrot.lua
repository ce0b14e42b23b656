local function stays(cx, cy)
  local x, y, turn = 0.0, 0.0, 0
  while turn < 50 and x * x + y * y <= 4.0 do
    x, y = x * x - y * y + cx, 2.0 * x * y + cy
    turn = turn + 1
  end
  return turn == 50
end
local start, found = os.clock(), 0
for i = 0, 199 do
  for j = 0, 199 do
    if stays(i / 80.0 - 2.0, j / 80.0 - 1.25) then found = found + 1 end
  end
end
assert(found == 10249)
print((os.clock() - start) * 1e3)
