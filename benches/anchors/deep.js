function depth(n) { return n === 0 ? 0 : 1 + depth(n - 1); }
const start = process.cpuUsage().user / 1e3;
let sum = 0;
for (let turn = 0; turn < 100; turn++) sum += depth(10000);
if (sum !== 1000000) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
