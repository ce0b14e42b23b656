-- A cell that takes 1,000 values; 1,000 coroutines wait for conditions over it, which are looked at after each assignment.
local level, woken, waiters, ready = 0, 0, {}, {}
for bound = 0, 999 do
  local task = coroutine.create(function() coroutine.yield() woken = woken + 1 end)
  coroutine.resume(task)
  waiters[#waiters + 1] = {holds = function() return level > bound end, task = task}
end
local function set(value)
  level = value
  local kept = 0
  for i = 1, #waiters do
    local waiter = waiters[i]
    if waiter.holds() then
      ready[#ready + 1] = waiter.task
    else
      kept = kept + 1
      waiters[kept] = waiter
    end
  end
  for i = kept + 1, #waiters do waiters[i] = nil end
end
local start = os.clock()
for i = 1, 1000 do
  set(i)
  for k = 1, #ready do
    coroutine.resume(ready[k])
    ready[k] = nil
  end
end
assert(woken == 1000)
print((os.clock() - start) * 1e3)
