local start = os.clock()
local sum = 0
for _ = 1, 20 do
  local report = ""
  for i = 0, 299 do
    report = report .. "room " .. i .. " is " .. (i % 3 == 0 and "open" or "closed") .. "\n"
  end
  sum = sum + #report
end
assert(sum == 107800)
print((os.clock() - start) * 1e3)
