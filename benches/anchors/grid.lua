local width = 200
local floor = math.floor
local function is_wall(cell)
  local column, row = cell % width, floor(cell / width)
  return column % 4 == 2 and row * 7 % 40 ~= column % 40
end
local function search(start, goal)
  local steps, queue, first, last = {}, {}, 0, 1
  for cell = 0, width * width - 1 do steps[cell] = -1 end
  queue[0], steps[start] = start, 0
  while first < last and steps[goal] < 0 do
    local cell = queue[first]
    local column, step = cell % width, steps[cell] + 1
    first = first + 1
    local function visit(next)
      if next >= 0 and next < width * width and steps[next] < 0 and not is_wall(next) then
        steps[next], queue[last] = step, next
        last = last + 1
      end
    end
    if column > 0 then visit(cell - 1) end
    if column < width - 1 then visit(cell + 1) end
    visit(cell - width)
    visit(cell + width)
  end
  return steps[goal]
end
local start = os.clock()
assert(search(0, 39999) == 958)
print((os.clock() - start) * 1e3)
