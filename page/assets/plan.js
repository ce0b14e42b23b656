// The texts of the plan, with the forms marked that tasks are in.

import { element } from "rpl/elements";
import { standing } from "rpl/run";

/** The end of the form or name that begins at a place: strings, comments and characters are gone over. */
function endOfForm(text, from) {
  let depth = 0;
  for (let at = from; at < text.length; at++) {
    const sign = text[at];
    if (sign === ";") at = lineEnd(text, at);
    else if (sign === '"') at = stringEnd(text, at);
    else if (sign === "\\") at++;
    else if (sign === "(") depth++;
    else if (sign === ")" && --depth <= 0) return depth === 0 ? at + 1 : at;
    else if (depth === 0 && /\s/.test(sign)) return at;
  }
  return text.length;
}

function lineEnd(text, at) {
  const end = text.indexOf("\n", at);
  return end < 0 ? text.length : end;
}

function stringEnd(text, at) {
  for (at++; at < text.length && text[at] !== '"'; at++) if (text[at] === "\\") at++;
  return at;
}

export class PlanView {
  constructor(run, steers) {
    this.texts = new Map();
    this.shown = new Map();
    const tabs = element("div", { class: "tabs", role: "tablist", "aria-label": "Texts" });
    this.node = element("div", { class: "plan" }, tabs);
    run.head.texts.forEach(({ name, text }, at) => {
      const starts = [0];
      const lines = text.split("\n").map((line, number) => {
        starts.push(starts[number] + line.length + 1);
        const code = element("code", {}, line);
        const place = `${name}:${number + 1}`;
        const gutter = element("button", { type: "button", tabindex: -1, class: "number", title: `Break at ${place}`,
          "aria-label": `Break at line ${number + 1}`, onclick: () => steers(place) }, String(number + 1));
        return { node: element("div", { class: "row" }, gutter, code), code, line };
      });
      const list = element("div", { class: "text", role: "tabpanel", tabindex: 0, "aria-label": name }, ...lines.map((line) => line.node));
      const tab = element("button", { type: "button", role: "tab", onclick: () => this.turnTo(name) }, name);
      this.texts.set(name, { text, starts, lines, list, tab });
      tabs.append(tab);
      this.node.append(list);
      if (at === 0) this.turnTo(name);
    });
    tabs.hidden = run.head.texts.length < 2;
    if (!run.head.texts.length) this.node.append(element("p", { class: "nothing" }, "The text of the plan is not at hand."));
  }

  turnTo(name) {
    for (const [known, { list, tab }] of this.texts) {
      list.hidden = known !== name;
      tab.setAttribute("aria-selected", known === name);
    }
  }

  /** Marks of each line: from, to, how the task stands, and a title. */
  marks(state, before) {
    const marks = new Map();
    const places = new Map();
    for (const task of state.tasks.values()) {
      if (!task.at) continue;
      if (!places.has(task.at)) places.set(task.at, []);
      places.get(task.at).push(task);
    }
    if (before) places.set(before, [{ path: "the run", state: "before" }]);
    for (const [place, tasks] of places) {
      const [, name, line, column] = place.match(/^(.*):(\d+):(\d+)$/) ?? [];
      const text = this.texts.get(name);
      const number = Number(line) - 1;
      if (!text?.lines[number]) continue;
      const from = text.starts[number] + Number(column) - 1;
      const to = endOfForm(text.text, from);
      // Who waits for its children only stands around them.
      const kind = (task) => (task.on === "children" ? "around" : task.state);
      const how = ["before", "ready", "waits", "suspended", "around", "created"].find((how) => tasks.some((task) => kind(task) === how));
      const title = tasks.slice(0, 8).map((task) => how === "before" ? "the run stands here" : `${task.path}: ${standing(task, state.time)}`).join("\n");
      for (let at = number; at < text.lines.length && text.starts[at] < to; at++) {
        const mark = [Math.max(0, from - text.starts[at]), Math.min(text.lines[at].line.length, to - text.starts[at]), how, title];
        const key = `${name}:${at}`;
        if (!marks.has(key)) marks.set(key, []);
        marks.get(key).push(mark);
      }
    }
    return marks;
  }

  show(state, before) {
    const marks = this.marks(state, before);
    for (const key of this.shown.keys()) if (!marks.has(key)) this.mark(key, []);
    for (const [key, list] of marks) this.mark(key, list);
    this.shown = marks;
    if (before && before !== this.stood) this.showPlace(before);
    if (!this.isPlaced && marks.size) {
      // What is at work comes first; from then on the reader turns the text.
      this.isPlaced = true;
      const [key] = [...marks].find(([, list]) => list.some(([, , how]) => how !== "around")) ?? [...marks][0];
      const [, name, line] = key.match(/^(.*):(\d+)$/);
      this.showPlace(`${name}:${Number(line) + 1}:1`);
    }
    this.stood = before;
  }

  showPlace(place) {
    const [, name, line] = place.match(/^(.*):(\d+):(\d+)$/) ?? [];
    const text = this.texts.get(name);
    if (!text) return;
    this.turnTo(name);
    const row = text.lines[Number(line) - 1]?.node;
    if (row) text.list.scrollTop = row.offsetTop - text.list.offsetTop - text.list.clientHeight / 2;
  }

  mark(key, list) {
    const split = key.lastIndexOf(":");
    const row = this.texts.get(key.slice(0, split))?.lines[Number(key.slice(split + 1))];
    if (!row) return;
    const wanted = JSON.stringify(list);
    if (row.marked === wanted) return;
    row.marked = wanted;
    if (!list.length) {
      row.code.replaceChildren(row.line);
      row.node.className = "row";
      return;
    }
    // What is done there counts before what is around it, and of several the innermost.
    const inner = list.filter(([, , how]) => how !== "around");
    const [from, to, how, title] = (inner.length ? inner : list).reduce((one, other) => (other[1] - other[0] < one[1] - one[0] ? other : one));
    const indent = row.line.length - row.line.trimStart().length;
    const start = Math.max(from, Math.min(indent, to));
    row.code.replaceChildren(row.line.slice(0, start), element("mark", { class: how, title }, row.line.slice(start, to)), row.line.slice(to));
    row.node.className = `row marked ${how}`;
  }
}

/** What was printed, logged and told, up to an instant. */
export class LogView {
  constructor(run, goTo) {
    this.run = run;
    this.goTo = goTo;
    this.node = element("ol", { class: "log", tabindex: 0, "aria-label": "What was told" });
    this.count = -1;
  }

  show(at) {
    const { told } = this.run;
    let low = 0;
    let high = told.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (told[middle].at <= at) low = middle + 1;
      else high = middle;
    }
    if (low === this.count) return;
    const rows = told.slice(Math.max(0, low - 200), low).map((one) => {
      const time = element("button", { type: "button", class: "when", onclick: () => this.goTo(one.time) }, (one.time / 1e6).toFixed(1));
      return element("li", { class: one.kind }, time, element("span", {}, one.text));
    });
    this.node.replaceChildren(...(rows.length ? rows : [element("li", { class: "nothing" }, "Nothing so far.")]));
    this.node.scrollTop = this.node.scrollHeight;
    this.count = low;
  }
}

