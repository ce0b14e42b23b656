// Valves with their holders and lines, and fluents with what they were.

import { drawn, element, rows, say, set } from "rpl/elements";
import { seconds } from "rpl/run";

const MOST = 200;
const WIDTH = 120;
const HEIGHT = 22;

export class ValvesView {
  constructor() {
    this.list = element("ul", { class: "valves", "aria-label": "Valves" });
    this.nothing = element("p", { class: "nothing" }, "Nobody has asked for a valve.");
    this.node = element("div", {}, this.list, this.nothing);
  }

  show(state) {
    const line = new Map();
    for (const task of state.tasks.values()) {
      const name = task.on?.startsWith("valve ") ? task.on.slice(6) : null;
      if (name) line.set(name, [...(line.get(name) ?? []), task]);
    }
    const named = (id) => {
      const task = state.tasks.get(id);
      return task ? [last(task.path), task.calls && last(task.calls)].filter(Boolean).join(" ") : "?";
    };
    const valves = [...state.valves.values()].slice(0, MOST);
    this.nothing.hidden = valves.length > 0;
    rows(this.list, valves, (valve) => valve.name, ({ name }) => element("li", { "data-valve": name },
      element("b", {}, name), element("span", { class: "holder" }), element("span", { class: "queue" })), (row, valve) => {
      const isFree = valve.holders.length === 0;
      const waiting = line.get(valve.name) ?? [];
      say(row.children[1], isFree ? "free" : valve.holders.map(named).join(", "));
      set(row, "class", isFree ? "free" : "held");
      const parts = [...valve.taken.map((id) => `taken from ${named(id)}`), ...waiting.slice(0, 5).map((task) => `${named(task.id)} waits`)];
      if (waiting.length > 5) parts.push(`and ${waiting.length - 5} more`);
      say(row.children[2], parts.join(", "));
    });
  }
}

function last(path) {
  return path.slice(path.lastIndexOf("/") + 1);
}

export class FluentsView {
  constructor(run) {
    this.run = run;
    this.filter = element("input", { type: "search", placeholder: "filter", "aria-label": "Filter fluents", oninput: () => this.again() });
    this.list = element("ul", { class: "fluents", "aria-label": "Fluents" });
    this.nothing = element("p", { class: "nothing" }, "No fluent has changed.");
    this.node = element("div", {}, this.filter, this.list, this.nothing);
  }

  again() {
    if (this.state) this.show(this.state, this.time, this.end);
  }

  show(state, time, end) {
    Object.assign(this, { state, time, end });
    const wanted = this.filter.value.toLowerCase();
    const all = [...state.fluents.values()].filter(({ name }) => !name.startsWith("%") && name.includes(wanted));
    all.sort((one, other) => (one.name < other.name ? -1 : 1));
    this.filter.hidden = state.fluents.size < 8;
    this.nothing.hidden = state.fluents.size > 0;
    rows(this.list, all.slice(0, MOST), (fluent) => fluent.name, ({ name }) => element("li", { "data-fluent": name },
      element("b", {}, name), drawn("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", "aria-hidden": "true" },
        drawn("path", { class: "spark" }), drawn("path", { class: "here" })),
      element("span", { class: "value" })), (row, fluent) => this.update(row, fluent, time, end));
  }

  update(row, fluent, time, end) {
    say(row.children[2], fluent.value ?? "pulsed");
    set(row, "title", `${fluent.name} = ${fluent.value ?? "pulsed"}\nsince ${seconds(fluent.time)}, by ${fluent.by}`);
    row.classList.toggle("fresh", time - fluent.time < 2e6);
    const history = this.run.history.get(fluent.name) ?? [];
    const [spark, here] = row.children[1].children;
    const key = `${history.length} ${Math.round(end / 1e6)}`;
    if (row.sparked !== key) {
      row.sparked = key;
      set(spark, "d", sparkline(history, end));
    }
    const x = ((time / Math.max(1, end)) * WIDTH).toFixed(1);
    set(here, "d", `M${x} 0V${HEIGHT}`);
  }
}

/** Steps of a value over the whole run, no more than there are pixels. */
function sparkline(history, end) {
  if (!history.length) return "";
  let [low, high] = [Infinity, -Infinity];
  for (const [, number] of history) [low, high] = [Math.min(low, number), Math.max(high, number)];
  const x = (time) => Math.round((time / Math.max(1, end)) * WIDTH * 2) / 2;
  const y = (number) => (high === low ? HEIGHT / 2 : HEIGHT - 3 - ((number - low) / (high - low)) * (HEIGHT - 6)).toFixed(1);
  let d = "";
  let [column, top, bottom, now] = [null, 0, 0, 0];
  const flush = () => { if (column !== null) d += `${d ? "L" : "M"}${column} ${top}V${bottom}V${now}`; };
  for (const [time, number] of history) {
    const at = x(time);
    const height = Number(y(number));
    if (at === column) {
      [top, bottom, now] = [Math.min(top, height), Math.max(bottom, height), height];
      continue;
    }
    flush();
    if (column !== null) d += `H${at}`;
    [top, bottom, now] = column === null ? [height, height, height] : [Math.min(now, height), Math.max(now, height), height];
    column = at;
  }
  flush();
  return `${d}H${WIDTH}`;
}
