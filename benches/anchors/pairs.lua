local rooms, names = nil, {}
for i = 29, 0, -1 do
  names[i] = "room-" .. i
  rooms = {key = names[i], value = i, rest = rooms}
end
local function find(key, list)
  while list do
    if list.key == key then return list end
    list = list.rest
  end
end
local start = os.clock()
local sum, x = 0, 1
for _ = 1, 200000 do
  x = x * 16807 % 2147483647
  sum = sum + find(names[x % 30], rooms).value
end
assert(sum == 2906600)
print((os.clock() - start) * 1e3)
