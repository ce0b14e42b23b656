function build(n) {
  let words = null;
  for (let i = 0; i < n; i++) words = [("n" + i), words];
  const reversed = [];
  while (words) { reversed.push(words[0]); words = words[1]; }
  return reversed.join(",").length;
}
const start = process.cpuUsage().user / 1e3;
if (build(200000) !== 1488889) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
