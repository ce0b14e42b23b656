function sumTo(n) { let i = 0, sum = 0; while (i < n) { sum = sum + i; i = i + 1; } return sum; }
const start = process.cpuUsage().user / 1e3;
if (sumTo(10000000) !== 49999995000000) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
