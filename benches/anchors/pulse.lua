-- 100,000 coroutines that wait for an event, are resumed, count themselves and end.
local woken, waiters = 0, {}
for i = 1, 100000 do
  local task = coroutine.create(function() coroutine.yield(); woken = woken + 1 end)
  coroutine.resume(task)
  waiters[i] = task
end
local start = os.clock()
local ready = waiters
waiters = {}
for i = 1, #ready do coroutine.resume(ready[i]) end
assert(woken == 100000)
print((os.clock() - start) * 1e3)
