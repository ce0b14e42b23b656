local start, caught = os.clock(), 0
for i = 0, 199999 do
  local ok = pcall(function() error("number " .. i) end)
  if not ok then caught = caught + 1 end
end
assert(caught == 200000)
print((os.clock() - start) * 1e3)
