-- 100,000 coroutines that wait for a time each, in a binary heap.
local heap, size = {}, 0
local function push(time, task)
  size = size + 1
  local at = size
  while at > 1 do
    local up = math.floor(at / 2)
    if heap[up][1] <= time then break end
    heap[at] = heap[up]
    at = up
  end
  heap[at] = {time, task}
end
local function pop()
  local top, last = heap[1], heap[size]
  heap[size] = nil
  size = size - 1
  if size > 0 then
    local at = 1
    while true do
      local down = at * 2
      if down > size then break end
      if down < size and heap[down + 1][1] < heap[down][1] then down = down + 1 end
      if heap[down][1] >= last[1] then break end
      heap[at] = heap[down]
      at = down
    end
    heap[at] = last
  end
  return top
end
local start = os.clock()
local done = 0
for i = 99999, 0, -1 do
  local task = coroutine.create(function() coroutine.yield(); done = done + 1 end)
  coroutine.resume(task)
  push(i * 0.001, task)
end
while size > 0 do coroutine.resume(pop()[2]) end
assert(done == 100000)
print((os.clock() - start) * 1e3)
