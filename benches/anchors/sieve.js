function sieve(n) {
  const flags = new Array(n + 1).fill(true);
  let found = 0;
  for (let i = 2; i <= n; i++) {
    if (flags[i]) {
      found++;
      for (let k = i + i; k <= n; k += i) flags[k] = false;
    }
  }
  return found;
}
const start = process.cpuUsage().user / 1e3;
for (let turn = 0; turn < 5; turn++) if (sieve(200000) !== 17984) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
