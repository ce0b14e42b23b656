let x = 42n;
const numbers = [];
for (let i = 0; i < 100000; i++) {
  x = (x * 1103515245n + 12345n) % 2147483648n;
  numbers.push(Number(x));
}
const start = process.cpuUsage().user / 1e3;
numbers.sort((a, b) => a - b);
if (numbers[50000] !== 1072443146) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
