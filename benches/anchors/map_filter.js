const numbers = [];
for (let i = 999999; i >= 0; i--) numbers.push(i);
const start = process.cpuUsage().user / 1e3;
if (numbers.map(n => n * 3).filter(n => n < 1500000).length !== 500000) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
