function fib(n) { return n < 2 ? n : fib(n - 1) + fib(n - 2); }
const start = process.cpuUsage().user / 1e3;
if (fib(30) !== 832040) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
