let done = 0;
async function work() { await null; done++; }
const start = process.cpuUsage().user / 1e3;
const all = [];
for (let i = 0; i < 100000; i++) all.push(work());
Promise.all(all).then(() => {
  if (done !== 100000) process.exit(1);
  console.log(process.cpuUsage().user / 1e3 - start);
});
