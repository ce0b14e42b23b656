local function put(agenda, errand)
  local heap, at = agenda.heap, agenda.count + 1
  local above = math.floor(at / 2)
  agenda.count = at
  while above > 0 and errand.urgency > heap[above].urgency do
    heap[at] = heap[above]
    at = above
    above = math.floor(at / 2)
  end
  heap[at] = errand
end
local function take(agenda)
  local heap, count = agenda.heap, agenda.count
  local first, last, at, child = heap[1], heap[count], 1, 2
  agenda.count = count - 1
  while child < count do
    if child + 1 < count and heap[child + 1].urgency > heap[child].urgency then child = child + 1 end
    if heap[child].urgency <= last.urgency then break end
    heap[at] = heap[child]
    at = child
    child = 2 * at
  end
  heap[at] = last
  return first
end
local errands = {heap = {}, count = 0}
local start = os.clock()
local x, sum = 1, 0
for i = 0, 19999 do
  x = x * 16807 % 2147483647
  put(errands, {urgency = x, name = i})
end
for _ = 1, 20000 do sum = (31 * sum + take(errands).name) % 1000003 end
assert(sum == 905991)
print((os.clock() - start) * 1e3)
