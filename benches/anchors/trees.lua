local function tree(depth)
  if depth == 0 then return {} end
  return {tree(depth - 1), tree(depth - 1)}
end
local function size(tree)
  if tree[1] then return 1 + size(tree[1]) + size(tree[2]) end
  return 1
end
local start, sum = os.clock(), 0
for _ = 1, 10 do sum = sum + size(tree(16)) end
assert(sum == 1310710)
print((os.clock() - start) * 1e3)
