local function matrix(n, of)
  local rows = {}
  for i = 0, n - 1 do
    local row = {}
    for j = 0, n - 1 do row[j] = of(i, j) end
    rows[i] = row
  end
  return rows
end
local function product(a, b, n)
  local result = {}
  for i = 0, n - 1 do
    local row, left = {}, a[i]
    for j = 0, n - 1 do
      local sum = 0.0
      for k = 0, n - 1 do sum = sum + left[k] * b[k][j] end
      row[j] = sum
    end
    result[i] = row
  end
  return result
end
local a = matrix(80, function(i, j) return (i + j) * 1.0 end)
local b = matrix(80, function(i, j) return (i - j) * 1.0 end)
local start = os.clock()
local c
for _ = 1, 3 do c = product(a, b, 80) end
assert(c[10][20] == 119880)
print((os.clock() - start) * 1e3)
