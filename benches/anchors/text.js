const start = process.cpuUsage().user / 1e3;
const lines = [];
for (let i = 0; i < 50000; i++) lines.push(`${i}: ${i * i} of ${"things"}`);
if (lines.join(";").split(";").length !== 50000) process.exit(1);
console.log(process.cpuUsage().user / 1e3 - start);
