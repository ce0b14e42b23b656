// The differences between two runs, and the first event that differs.

import { element, say } from "rpl/elements";
import { isEvent, seconds } from "rpl/run";

/** Notes of the page itself in lines. */
const OF_PAGE = ["line", "names"];

/** A line in a few words. */
function words(run, line) {
  if (!line) return `${seconds(run.end)}: the run is over`;
  const [time, seen] = line;
  const { nodes } = run;
  const task = (id) => { const node = nodes.ofTask.get(id); return node ? nodes.label(node) : "a task"; };
  const what = seen.task ? `${task(seen.task.id)} ${seen.task.state === "waits" ? `waits for ${seen.task.on}` : seen.task.state}`
    : seen.ended ? `${task(seen.ended.id)} ${seen.ended.state}`
    : seen.valve ? `valve ${seen.valve.name}: ${seen.valve.holders.map(task).join(", ") || "free"}`
    : seen.fluent ? `${seen.fluent.name} = ${seen.fluent.value ?? "pulsed"}`
    : seen.told ? seen.told.text || seen.told.kind : "the rest was not kept";
  return `${seconds(time)}: ${what}`;
}

/** Facts of a run by name. */
function facts(run) {
  const { head, nodes } = run;
  const main = nodes.roots[0];
  const outcome = main?.endedAt === null || !main ? "goes on" : [main.state, main.result].filter(Boolean).join(": ");
  return { plan: head.plan || "a session", seed: String(head.seed), world: head.map?.name ?? "none", robot: head.robot?.name ?? "none",
    scenario: head.scenario ?? "none", outcome, duration: seconds(run.end) };
}

export class Comparison {
  constructor(runs, goTo) {
    this.runs = runs;
    this.at = runs.map(() => 0);
    this.found = null;
    this.rows = element("tbody");
    this.same = element("p", { class: "same" });
    this.first = element("button", { type: "button", class: "first-difference", onclick: () => this.found && goTo(Math.min(...this.found.map(({ time }) => time))) });
    const body = element("table", {}, element("thead", {}, element("tr", {}, element("th", {}, "differs"), ...runs.map((_, at) => element("th", {}, `run ${at + 1}`)))), this.rows);
    this.node = element("section", { class: "comparison", "aria-label": "Differences between the runs" }, body, element("div", {}, this.same, this.first));
  }

  /** The runs may be longer now. Lines that were alike are not looked at again. */
  show() {
    const told = this.runs.map(facts);
    const names = Object.keys(told[0]);
    const differs = names.filter((name) => told.some((one) => one[name] !== told[0][name]));
    const key = JSON.stringify(told);
    if (key !== this.told) {
      this.told = key;
      this.rows.replaceChildren(...differs.map((name) => element("tr", { "data-fact": name }, element("th", { scope: "row" }, name), ...told.map((one) => element("td", {}, one[name])))));
      const same = names.filter((name) => !differs.includes(name)).map((name) => `${name} ${told[0][name]}`);
      say(this.same, same.length ? `The same: ${same.join(", ")}.` : "Nothing is the same.");
    }
    this.look();
    say(this.first, this.found ? `First difference: ${this.found.map(({ words }) => words).join(" | ")}` : "No event differs so far.");
  }

  look() {
    while (!this.found) {
      const next = this.runs.map((run, which) => {
        while (this.at[which] < run.lines.length && !isEvent(run.lines[this.at[which]])) this.at[which]++;
        return run.lines[this.at[which]];
      });
      if (next.every((line) => !line)) return;
      // A run that goes on may still come to it.
      if (next.some((line, which) => !line && !isOver(this.runs[which]))) return;
      const [one, ...others] = next.map((line) => JSON.stringify(line, (name, value) => (OF_PAGE.includes(name) ? undefined : value)));
      if (others.every((other) => other === one)) this.at = this.at.map((at) => at + 1);
      else this.found = next.map((line, which) => ({ time: line ? line[0] : this.runs[which].end, words: words(this.runs[which], line) }));
    }
  }
}

function isOver(run) {
  return run.isOver || (run.nodes.roots[0]?.endedAt ?? null) !== null;
}
