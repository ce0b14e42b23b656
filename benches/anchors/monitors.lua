-- A cell that takes 1,000 values; 1,000 coroutines react to conditions over it, which are looked at after each assignment.
local level, reactions, monitors, ready = 0, 0, {}, {}
for bound = 0, 999 do
  local task = coroutine.create(function() while true do coroutine.yield() reactions = reactions + 1 end end)
  coroutine.resume(task)
  monitors[#monitors + 1] = {holds = function() return level > bound end, was = false, rises = 0, task = task}
end
local function set(value)
  level = value
  for i = 1, #monitors do
    local monitor = monitors[i]
    local is = monitor.holds()
    if is and not monitor.was then
      if monitor.rises == 0 then ready[#ready + 1] = monitor end
      monitor.rises = monitor.rises + 1
    end
    monitor.was = is
  end
end
local start = os.clock()
for i = 1, 1000 do set(i) end
for i = 1, #ready do
  for _ = 1, ready[i].rises do coroutine.resume(ready[i].task) end
end
assert(reactions == 1000)
print((os.clock() - start) * 1e3)
