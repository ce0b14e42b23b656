// The texts of the plan, with the forms marked that tasks are in.

import { element } from "rpl/elements";
import { standing } from "rpl/run";
import { TreeView } from "rpl/tree";

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

/** The text stays where a reader has turned it for this long, in milliseconds. */
const READER_MS = 8000;

export class PlanView {
  constructor(run, { steers, choose, again }) {
    Object.assign(this, { run, again });
    this.texts = new Map();
    this.shown = new Map();
    this.turnedAt = -Infinity;
    this.tree = new TreeView(run, choose);
    this.pages = [];
    this.tabs = element("div", { class: "tabs", role: "tablist", "aria-label": "The plan" });
    this.node = element("div", { class: "plan" }, this.tabs);
    run.head.texts.forEach(({ name, text }) => {
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
      for (const turn of ["wheel", "touchmove", "pointerdown", "keydown"]) {
        list.addEventListener(turn, () => { this.turnedAt = performance.now(); }, { passive: true });
      }
      this.texts.set(name, { text, starts, lines, list });
      this.addPage(name, list);
    });
    this.addPage("Tree", this.tree.node);
    this.turnTo(this.pages[0].name);
  }

  addPage(name, node) {
    const tab = element("button", { type: "button", role: "tab", onclick: () => {
      this.turnedAt = performance.now();
      this.turnTo(name);
      this.again();
    } }, name);
    this.pages.push({ name, node, tab });
    this.tabs.append(tab);
    this.node.append(node);
  }

  turnTo(name) {
    this.page = name;
    for (const { name: known, node, tab } of this.pages) {
      node.hidden = known !== name;
      tab.setAttribute("aria-selected", known === name);
    }
  }

  /** The place in the texts of the task that changed last, or of the next one above it. */
  innermost(state) {
    let last = null;
    for (const task of state.tasks.values()) {
      if (task.state === "suspended" || task.state === "created" || (last && task.line < last.line)) continue;
      if (this.placeAbove(state, task)) last = task;
    }
    return last && this.placeAbove(state, last);
  }

  placeAbove(state, task) {
    for (let at = task; at; at = state.tasks.get(at.parent)) if (this.placeIn(at.at)) return at.at;
    return null;
  }

  /** A place as text, line and column, if the page has the text. */
  placeIn(place) {
    const [, name, line, column] = place?.match(/^(.*):(\d+):(\d+)$/) ?? [];
    const text = this.texts.get(name);
    return text?.lines[line - 1] ? { text, name, line: Number(line) - 1, column: Number(column) - 1 } : null;
  }

  /** Marks of each line: from, to, how the task stands, a title, and whether it is the innermost form. */
  marks(state, before, innermost) {
    const marks = new Map();
    const places = new Map();
    for (const task of state.tasks.values()) {
      if (!task.at) continue;
      if (!places.has(task.at)) places.set(task.at, []);
      places.get(task.at).push(task);
    }
    if (before) places.set(before, [{ state: "before" }]);
    for (const [place, tasks] of places) {
      const found = this.placeIn(place);
      if (!found) continue;
      const { text, name, line: number } = found;
      const from = text.starts[number] + found.column;
      const to = endOfForm(text.text, from);
      // Who waits for its children only stands around them.
      const kind = (task) => (task.on === "children" ? "around" : task.state);
      const how = ["before", "ready", "waits", "suspended", "around", "created"].find((how) => tasks.some((task) => kind(task) === how));
      const title = tasks.slice(0, 8).map((task) => how === "before" ? "the run stands here" : `${this.run.nodes.taskName(task)}: ${standing(task, state.time)}\n${task.path}`).join("\n");
      for (let at = number; at < text.lines.length && text.starts[at] < to; at++) {
        const mark = [Math.max(0, from - text.starts[at]), Math.min(text.lines[at].line.length, to - text.starts[at]), how, title, place === innermost];
        const key = `${name}:${at}`;
        if (!marks.has(key)) marks.set(key, []);
        marks.get(key).push(mark);
      }
    }
    return marks;
  }

  show(state, before) {
    if (this.page === "Tree") return this.tree.show(state);
    const innermost = before ?? this.innermost(state);
    const marks = this.marks(state, before, innermost);
    for (const key of this.shown.keys()) if (!marks.has(key)) this.mark(key, []);
    for (const [key, list] of marks) this.mark(key, list);
    this.shown = marks;
    // A place where the run was stopped is shown in any case.
    const isAsked = before && before !== this.stood;
    this.stood = before;
    if (innermost && innermost !== this.followed && (isAsked || performance.now() - this.turnedAt > READER_MS)) {
      this.followed = this.due = innermost;
    }
  }

  /** Scrolls to the form or node that goes on. It asks for the layout, so it comes after all changes of the page. */
  follow() {
    if (this.page === "Tree") return this.tree.follow();
    if (this.due) this.showPlace(this.due);
    this.due = null;
  }

  showPlace(place) {
    const found = this.placeIn(place);
    if (!found) return;
    const { text: { list, lines }, name, line } = found;
    if (this.page !== name) this.turnTo(name);
    const { node } = lines[line];
    const top = node.offsetTop - list.offsetTop;
    if (top < list.scrollTop || top + 2 * node.offsetHeight > list.scrollTop + list.clientHeight) list.scrollTop = top - list.clientHeight / 2;
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
    const [from, to, how, title, isInnermost] = list.find((mark) => mark[4])
      ?? (inner.length ? inner : list).reduce((one, other) => (other[1] - other[0] < one[1] - one[0] ? other : one));
    const name = isInnermost ? `${how} innermost` : how;
    const indent = row.line.length - row.line.trimStart().length;
    const start = Math.max(from, Math.min(indent, to));
    row.code.replaceChildren(row.line.slice(0, start), element("mark", { class: name, title }, row.line.slice(start, to)), row.line.slice(to));
    row.node.className = `row marked ${name}`;
  }
}

/** No more messages are shown at a time. */
const MOST_TOLD = 200;

/** The kind of a message, as far as it is known after a number of lines. */
function kindOf(one, at) {
  if (one.kind !== "failure") return one.kind;
  if (one.endsAt <= at) return "failure end";
  return one.handledAt <= at ? "failure handled" : "failure";
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
    // A failure is known to have been handled, or to have ended the run, only later.
    const key = told.slice(Math.max(0, low - MOST_TOLD), low).map((one) => kindOf(one, at)).join();
    if (low === this.count && key === this.kinds) return;
    this.kinds = key;
    const rows = told.slice(Math.max(0, low - MOST_TOLD), low).map((one) => {
      const time = element("button", { type: "button", class: "when", onclick: () => this.goTo(one.time) }, (one.time / 1e6).toFixed(1));
      return element("li", { class: kindOf(one, at), title: one.task }, time, element("span", {}, this.text(one, at)));
    });
    this.node.replaceChildren(...(rows.length ? rows : [element("li", { class: "nothing" }, "Nothing so far.")]));
    this.node.scrollTop = this.node.scrollHeight;
    this.count = low;
  }
  text(one, at) {
    if (one.kind !== "failure") return one.text;
    const what = { "failure end": "ended the run", "failure handled": "handled", failure: "raised" }[kindOf(one, at)];
    return `${this.run.nodes.nameOf(one.task)}: ${one.text} (${what})`;
  }
}
