local function evaluate(words)
  local at, sum = 1, nil
  local function atom()
    local word = words[at]
    at = at + 1
    if word == "open" then
      local value = sum()
      at = at + 1
      return value
    end
    return word
  end
  local function product()
    local value = atom()
    while words[at] == "*" do
      at = at + 1
      value = value * atom()
    end
    return value
  end
  function sum()
    local value = product()
    while words[at] == "+" do
      at = at + 1
      value = value + product()
    end
    return value
  end
  return sum()
end
local expression = {
  1, "+", 2, "*", "open", 3, "+", 4, "*", 5, "+", "open", 6, "+", 7, "close", "*", 8, "close", "+", 9, "*",
  "open", 1, "+", 1, "close",
}
local start = os.clock()
local found = 0
for _ = 1, 10000 do found = found + evaluate(expression) end
assert(found == 2730000)
print((os.clock() - start) * 1e3)
