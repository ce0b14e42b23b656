local function advance(one, other, dt)
  local dx, dy = one.x - other.x, one.y - other.y
  local square = dx * dx + dy * dy
  local pull = dt / (square * math.sqrt(square))
  one.vx = one.vx - dx * other.mass * pull
  one.vy = one.vy - dy * other.mass * pull
  other.vx = other.vx + dx * one.mass * pull
  other.vy = other.vy + dy * one.mass * pull
  one.x = one.x + dt * one.vx
  one.y = one.y + dt * one.vy
  other.x = other.x + dt * other.vx
  other.y = other.y + dt * other.vy
end
local sun = {x = 0.0, y = 0.0, vx = 0.0, vy = 0.0, mass = 1.0}
local earth = {x = 1.0, y = 0.0, vx = 0.0, vy = 1.0, mass = 0.001}
local start = os.clock()
for _ = 1, 100000 do advance(sun, earth, 0.001) end
local dx, dy = earth.x - sun.x, earth.y - sun.y
local distance = math.sqrt(dx * dx + dy * dy)
assert(0.9 < distance and distance < 1.1)
print((os.clock() - start) * 1e3)
