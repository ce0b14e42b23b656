-- Two coroutines that hand a token to and fro through two cells with a waiter each.
local ready, first, last = {}, 1, 0
local function fluent() return {value = nil, waiter = nil} end
local function set(f, v)
  f.value = v
  if v and f.waiter then last = last + 1; ready[last] = f.waiter; f.waiter = nil end
end
local function wait(f) while not f.value do f.waiter = coroutine.running(); coroutine.yield() end end
local ping, pong, rounds = fluent(), fluent(), 0
local a = coroutine.create(function() for _ = 1, 200000 do wait(ping); set(ping, nil); set(pong, true) end end)
local b = coroutine.create(function()
  for _ = 1, 200000 do set(ping, true); wait(pong); set(pong, nil); rounds = rounds + 1 end
end)
local start = os.clock()
ready[1], ready[2], last = a, b, 2
while first <= last do
  local task = ready[first]; ready[first] = nil; first = first + 1
  coroutine.resume(task)
end
assert(rounds == 200000)
print((os.clock() - start) * 1e3)
