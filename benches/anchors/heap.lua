local function sift_down(heap, start, last)
  local root = start
  while true do
    local child = 2 * root + 1
    if child >= last then return end
    if child + 1 < last and heap[child] < heap[child + 1] then child = child + 1 end
    if heap[root] >= heap[child] then return end
    heap[root], heap[child] = heap[child], heap[root]
    root = child
  end
end
local function heap_sort(heap, n)
  for start = math.floor(n / 2) - 1, 0, -1 do sift_down(heap, start, n) end
  for last = n - 1, 1, -1 do
    heap[0], heap[last] = heap[last], heap[0]
    sift_down(heap, 0, last)
  end
end
local numbers, x = {}, 42
for i = 0, 29999 do
  x = x * 16807 % 2147483647
  numbers[i] = x
end
local start = os.clock()
heap_sort(numbers, 30000)
assert(numbers[15000] == 1068064761)
print((os.clock() - start) * 1e3)
