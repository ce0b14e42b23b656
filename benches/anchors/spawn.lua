local start = os.clock()
local done, ready = 0, {}
for i = 1, 100000 do ready[i] = coroutine.create(function() done = done + 1 end) end
for i = 1, #ready do coroutine.resume(ready[i]) end
assert(done == 100000)
print((os.clock() - start) * 1e3)
