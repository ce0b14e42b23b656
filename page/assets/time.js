// The line of time: what was told, tasks as bars, and where one looks. Drag, or use the keys of a slider.

import { drawn, element, set } from "rpl/elements";
import { clock, seconds } from "rpl/run";

/** No more tasks and plan calls have a bar than this: those that took longest. */
const MOST_BARS = 18;

/** Height of a bar with its gap, in pixels. */
const BAR = 16;

/** Room that a time on the ruler takes at most, in pixels. */
const MARK = 52;

/** Room that a letter of a bar takes at most, in pixels. */
const LETTER = 7;

/** Which of the three lines of marks each kind of message is in. */
const LANES = { print: 0, log: 0, notice: 1, robot: 1, failure: 2, end: 2 };

export class TimeLine {
  constructor(runs, goTo, choose) {
    this.runs = runs;
    this.goTo = goTo;
    this.choose = choose;
    this.end = 1;
    this.ruler = element("div", { class: "ruler", "aria-hidden": "true" });
    this.slider = element("div", { class: "cursor", role: "slider", tabindex: 0, "aria-label": "Instant that is shown", "aria-valuemin": 0 });
    this.tracks = runs.map((run) => new Track(run, runs.length > 1, choose));
    this.paper = element("div", { class: "paper" }, this.ruler, ...this.tracks.map((track) => track.node), this.slider);
    this.node = this.paper;
    this.listen();
    new ResizeObserver(() => this.layOut()).observe(this.paper);
  }

  listen() {
    let isHeld = false;
    const seek = (event) => {
      const box = this.paper.getBoundingClientRect();
      this.goTo(Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)) * this.end);
    };
    this.paper.addEventListener("pointerdown", (event) => {
      if (event.target.closest(".bar")) return;
      isHeld = true;
      this.paper.setPointerCapture(event.pointerId);
      this.slider.focus({ preventScroll: true });
      seek(event);
    });
    this.paper.addEventListener("pointermove", (event) => isHeld && seek(event));
    for (const end of ["pointerup", "pointercancel"]) this.paper.addEventListener(end, () => { isHeld = false; });
  }

  /** The run is longer now, or the window wider. */
  layOut() {
    this.end = Math.max(1, ...this.runs.map((run) => run.end));
    const width = this.paper.clientWidth;
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300, 600, 1200, 3600, 7200, 14400, 36000]
      .find((step) => (step * 1e6 / this.end) * width >= 70) ?? 86400;
    const marks = [];
    for (let at = 0; at * 1e6 <= this.end && marks.length < 100; at += step) {
      const mark = element("span", {}, (1 - (at * 1e6) / this.end) * width > MARK ? clock(at * 1e6 + 0.5).replace(/\.0$/, "") : "");
      mark.style.left = `${(at * 1e8) / this.end}%`;
      marks.push(mark);
    }
    this.ruler.replaceChildren(...marks);
    this.tracks.forEach((track) => track.layOut(this.end, width));
    set(this.slider, "aria-valuemax", (this.end / 1e6).toFixed(1));
  }

  show(time) {
    this.slider.style.left = `${Math.min(100, (time / this.end) * 100).toFixed(3)}%`;
    set(this.slider, "aria-valuenow", (time / 1e6).toFixed(1));
    set(this.slider, "aria-valuetext", seconds(time));
  }
}

/** What happened in one run. */
class Track {
  constructor(run, isNamed, choose) {
    this.run = run;
    this.choose = choose;
    this.told = element("canvas", { class: "told", "aria-hidden": "true" });
    this.bars = drawn("svg", { class: "bars", role: "list", "aria-label": "Tasks over time" });
    this.name = element("span", { class: "track-name" }, `${run.head.plan}, seed ${run.head.seed}`);
    this.name.hidden = !isNamed;
    this.node = element("div", { class: "track" }, this.name, this.told, this.bars);
  }

  layOut(end, width) {
    this.drawTold(end, width);
    this.drawBars(end, width);
  }

  drawTold(end, width) {
    const scale = devicePixelRatio || 1;
    Object.assign(this.told, { width: width * scale, height: 21 * scale });
    const paper = this.told.getContext("2d");
    paper.scale(scale, scale);
    const colours = Object.fromEntries(Object.keys(LANES).map((kind) => {
      this.name.className = `track-name told-${kind}`;
      return [kind, getComputedStyle(this.name).color];
    }));
    this.name.className = "track-name";
    const drawn = new Set();
    for (const one of this.run.told) {
      const { time } = one;
      const kind = one.endsAt ? "end" : one.kind;
      const x = Math.round((time / end) * (width - 2));
      const key = x * 8 + LANES[kind];
      if (drawn.has(key)) continue;
      drawn.add(key);
      paper.fillStyle = colours[kind];
      paper.fillRect(x, LANES[kind] * 7, 2, 6);
    }
  }

  drawBars(end, width) {
    const now = this.run.end;
    const length = (bar) => (bar.to ?? now) - bar.from;
    const { nodes } = this.run;
    const shown = longest(nodes.all, (node) => node.name || (node.isOfPlan && !node.children.length), length, MOST_BARS);
    shown.sort((one, other) => one.number - other.number);
    const rows = [];
    const drawnBars = shown.map((bar) => {
      // A row is taken again when the task in it has ended.
      let row = rows.findIndex((until) => until <= bar.from);
      if (row < 0) row = rows.length;
      rows[row] = bar.to ?? now;
      const x = (bar.from / end) * width;
      const wide = Math.max(2, (length(bar) / end) * width);
      const name = nodes.label(bar);
      const words = `${name}: ${bar.to === null ? "goes on" : bar.state}, ${seconds(bar.from)} to ${seconds(bar.to ?? now)}`;
      const node = drawn("g", { class: `bar ${nodes.howEnded(bar)}`, role: "listitem", "aria-label": words, "data-path": bar.path, onclick: () => this.choose(this.run, bar) },
        drawn("rect", { x: x.toFixed(1), y: row * BAR + 1, width: wide.toFixed(1), height: BAR - 2, rx: 1.5 }), drawn("title", {}, `${words}\n${bar.path}`));
      const fits = Math.floor((wide - 8) / LETTER);
      if (fits > 3) node.append(drawn("text", { x: (x + 4).toFixed(1), y: row * BAR + 12 }, name.length > fits ? `${name.slice(0, fits - 1)}…` : name));
      return node;
    });
    this.bars.replaceChildren(...drawnBars);
    const height = Math.max(1, rows.length) * BAR + 2;
    set(this.bars, "viewBox", `0 0 ${Math.max(1, width)} ${height}`);
    set(this.bars, "height", height);
  }
}

/** The longest of those that are meant, in one pass: a run may have very many. */
function longest(nodes, isMeant, length, count) {
  const kept = [];
  for (const node of nodes) {
    if (!isMeant(node) || (kept.length === count && length(node) <= length(kept[count - 1]))) continue;
    kept.splice(kept.length === count ? count - 1 : kept.length, 1, node);
    kept.sort((one, other) => length(other) - length(one));
  }
  return kept;
}
