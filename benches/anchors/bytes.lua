-- Bytes a suspended coroutine.
local waiters = {}
for i = 1, 200000 do waiters[i] = false end
collectgarbage()
local before = collectgarbage("count")
for i = 1, 200000 do
  waiters[i] = coroutine.create(function() coroutine.yield(i) end)
  coroutine.resume(waiters[i])
end
collectgarbage()
print((collectgarbage("count") - before) * 1024 / 200000)
