// Valves with their holders and lines, and fluents with what they were.

import { drawn, element, rows, say, set } from "rpl/elements";
import { seconds } from "rpl/run";

const MOST = 200;
const WIDTH = 120;
const HEIGHT = 22;

export class ValvesView {
  constructor(run) {
    this.run = run;
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
    const valves = [...state.valves.values()].slice(0, MOST);
    this.nothing.hidden = valves.length > 0;
    rows(this.list, valves, (valve) => valve.name, ({ name }) => element("li", { "data-valve": name },
      element("b", {}, name), element("span", { class: "holder" }), element("span", { class: "queue" })), (row, valve) => {
      const isFree = valve.holders.length === 0;
      const waiting = line.get(valve.name) ?? [];
      say(row.children[1], isFree ? "free" : valve.holders.map((id) => valve.names.get(id)).join(", "));
      set(row, "title", valve.holders.map((id) => state.tasks.get(id)?.path).filter(Boolean).join("\n"));
      set(row, "class", isFree ? "free" : "held");
      const parts = [...valve.taken.map((id) => `taken from ${valve.names.get(id)}`), ...waiting.slice(0, 5).map((task) => `${this.run.nodes.taskName(task)} waits`)];
      if (waiting.length > 5) parts.push(`and ${waiting.length - 5} more`);
      say(row.children[2], parts.join(", "));
    });
  }
}

/** Curves of the robot's quantities, then of the fluents that are numbers. */
export class CurvesView {
  constructor(run) {
    this.run = run;
    this.list = element("ul", { class: "curves", "aria-label": "Curves" });
    this.nothing = element("p", { class: "nothing" }, "No number has changed.");
    this.node = element("div", {}, this.list, this.nothing);
  }

  show(time, end) {
    const curves = [...this.run.curves].filter(([key, { isOfRobot, isOfNumbers, low, high }]) => isOfRobot || (isOfNumbers && low < high && !key.startsWith("%")));
    curves.sort(([, one], [, other]) => other.isOfRobot - one.isOfRobot);
    this.nothing.hidden = curves.length > 0;
    rows(this.list, curves.slice(0, MOST), ([key]) => key, ([, { name }]) => element("li", { "data-curve": name },
      element("b", {}, name), element("span", { class: "value" }), drawnCurve(),
      element("span", { class: "high" }), element("span", { class: "low" })), (row, [, curve]) => {
      say(row.children[1], figure(curve.at(time), curve.unit));
      drawCurve(row, row.children[2], curve, time, end);
      say(row.children[3], figure(curve.high));
      say(row.children[4], figure(curve.low));
      set(row, "title", `${curve.name}: ${figure(curve.low, curve.unit)} to ${figure(curve.high, curve.unit)}`);
    });
  }
}

/** A number as a person reads it. */
function figure(number, unit = "") {
  if (number === null) return "–";
  const digits = Math.abs(number) >= 100 || Number.isInteger(number) ? 0 : Math.abs(number) >= 10 ? 1 : 2;
  return `${number.toFixed(digits)}${unit && ` ${unit}`}`;
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
      element("b", {}, name), drawnCurve(), element("span", { class: "value" })), (row, fluent) => this.update(row, fluent, time, end));
  }

  update(row, fluent, time, end) {
    say(row.children[2], fluent.value ?? "pulsed");
    set(row, "title", `${fluent.name} = ${fluent.value ?? "pulsed"}\nsince ${seconds(fluent.time)}, by ${this.run.nodes.nameOf(fluent.by)}`);
    row.classList.toggle("fresh", time - fluent.time < 2e6);
    drawCurve(row, row.children[1], this.run.curve(fluent.name, ""), time, end);
  }
}

function drawnCurve() {
  return drawn("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", "aria-hidden": "true" },
    drawn("path", { class: "spark" }), drawn("path", { class: "here" }));
}

/** Draws a curve anew only when that moves it by half a step of the picture: so a long run costs no more than a short one. */
function drawCurve(row, svg, curve, time, end) {
  const [spark, here] = svg.children;
  const { low, high } = curve;
  const drawn = row.drawn;
  if (!drawn || drawn.low !== low || drawn.high !== high || Math.abs(end - drawn.end) * 2 * WIDTH > end) {
    row.drawn = { low, high, end };
    set(spark, "d", steps(curve, end));
  }
  const x = ((time / Math.max(1, end)) * WIDTH).toFixed(1);
  set(here, "d", `M${x} 0V${HEIGHT}`);
}

/** Steps of a value over the whole run, no more than there are pixels. */
function steps({ points, low, high }, end) {
  if (!points.length) return "";
  const x = (time) => Math.round((time / Math.max(1, end)) * WIDTH * 2) / 2;
  const y = (number) => (high === low ? HEIGHT / 2 : HEIGHT - 3 - ((number - low) / (high - low)) * (HEIGHT - 6)).toFixed(1);
  let d = "";
  let [column, top, bottom, now] = [null, 0, 0, 0];
  const flush = () => { if (column !== null) d += `${d ? "L" : "M"}${column} ${top}V${bottom}V${now}`; };
  for (const [time, number] of points) {
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
