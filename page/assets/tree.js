// A picture of the plan: its plan calls and tasks as a tree, each with its state. Parts that have ended are folded up,
// so that the living ones can be read; a click on their number opens them.

import { drawn, element, rows, say, set } from "rpl/elements";
import { seconds, standing } from "rpl/run";

/** More nodes are not drawn. */
const MOST_NODES = 300;

/** Of the children of a node that have ended, or are not yet there, no more than this are drawn one by one. */
const MOST_ALIKE = 3;

/** Height of a row, and how much farther to the right children stand, in pixels. */
const ROW = 29;
const INDENT = 24;

/** Beyond this depth nodes are not moved farther to the right. */
const DEEPEST = 12;

/** The picture stays where a reader has turned it for this long, in milliseconds. */
const READER_MS = 8000;

const STATES = {
  running: ["▶", "running"], waits: ["◔", "waits"], suspended: ["‖", "suspended"], around: ["▷", "its parts run"],
  succeeded: ["✓", "done"], failed: ["✗", "failed"], handled: ["⚠", "failed, and was handled"], evaporated: ["⊘", "given up"],
  left: ["↩", "left"], later: ["○", "not yet"],
};

export class TreeView {
  constructor(run, choose) {
    this.run = run;
    this.choose = choose;
    /** Keys of the nodes and groups that a reader has opened. */
    this.opened = new Set();
    this.lines = drawn("svg", { class: "branches", "aria-hidden": "true" }, drawn("path"));
    this.list = element("ul", { class: "plan-nodes" });
    this.more = element("p", { class: "nothing", hidden: true });
    this.key = element("p", { class: "tree-key" }, ...Object.entries(STATES).map(([state, [sign, words]]) =>
      element("span", { class: `plan-node ${state}` }, `${sign} ${words}`)));
    this.turnedAt = -Infinity;
    this.paper = element("div", { class: "tree-paper" }, this.lines, this.list);
    this.node = element("div", { class: "plan-tree", role: "tabpanel", tabindex: 0, "aria-label": "The plan as a tree" }, this.key, this.paper, this.more);
    for (const turn of ["wheel", "touchmove", "pointerdown", "keydown"]) {
      this.node.addEventListener(turn, () => { this.turnedAt = performance.now(); }, { passive: true });
    }
  }

  /** How a node stands after the lines of a state. */
  stateOf(node, state, at) {
    if (node.at > at) return "later";
    if (node.endedAt !== null && node.endedAt <= at) return node.state === "failed" ? this.run.nodes.howEnded(node) : node.state;
    const task = state.tasks.get(node.task);
    if (!task || task.state === "created") return "later";
    if (task.state === "suspended") return "suspended";
    if (node.children.some((child) => child.at <= at && !(child.endedAt <= at && child.endedAt !== null))) return "around";
    return task.state === "waits" ? "waits" : "running";
  }

  /** The children that are drawn: parts of constructs that have no name give way to theirs. */
  children(node) {
    return node.children.flatMap((child) => (child.name || !child.children.length ? [child] : this.children(child)));
  }

  /** Gathers the items of a node and of those below it. */
  gather(node, depth, state, at, items) {
    const how = this.stateOf(node, state, at);
    const children = this.children(node);
    const isPast = how !== "running" && how !== "waits" && how !== "suspended" && how !== "around";
    const item = { key: `n${node.number}`, node, how, depth, folded: 0 };
    items.push(item);
    if (!children.length || items.length > MOST_NODES) return;
    if (isPast && node.parent && !this.opened.has(item.key)) {
      item.folded = children.length;
      return;
    }
    const alike = { past: [], later: [] };
    const isKept = new Set();
    for (const child of children) {
      const kind = child.at > at ? "later" : child.endedAt !== null && child.endedAt <= at ? "past" : null;
      if (kind) alike[kind].push(child);
      else isKept.add(child);
    }
    // The last that are over and the first that are to come are nearest to the present.
    const nearest = { past: alike.past.slice(-MOST_ALIKE), later: alike.later.slice(0, MOST_ALIKE) };
    for (const kind of ["past", "later"]) {
      const key = `${kind}${node.number}`;
      (this.opened.has(key) ? alike[kind] : nearest[kind]).forEach((child) => isKept.add(child));
    }
    const rest = (kind, how, words) => {
      const left = alike[kind].filter((child) => !isKept.has(child)).length;
      if (left) items.push({ key: `${kind}${node.number}`, group: `${left} ${words}`, node, how, depth: depth + 1, folded: left });
    };
    rest("past", "succeeded", "over");
    for (const child of children) if (isKept.has(child)) this.gather(child, depth + 1, state, at, items);
    rest("later", "later", "not yet");
  }

  show(state) {
    this.state = state;
    const at = state.count;
    const items = [];
    for (const root of this.run.nodes.roots) if (root.at <= at || root === this.run.nodes.roots[0]) this.gather(root, 0, state, at, items);
    const shown = items.slice(0, MOST_NODES);
    this.layOut(shown);
    this.more.hidden = items.length <= MOST_NODES;
    say(this.more, "More is not drawn; it is in the list of tasks.");
    rows(this.list, shown, (item) => item.key, (item) => this.make(item), (row, item) => this.update(row, item, state));
    this.shown = shown;
  }

  /** A node stands below the one before, and to the right of the one it belongs to. */
  layOut(shown) {
    let d = "";
    const above = [];
    shown.forEach((item, row) => {
      const depth = Math.min(item.depth, DEEPEST);
      Object.assign(item, { x: 4 + INDENT * depth, y: 4 + ROW * row });
      above.length = Math.min(above.length, item.depth);
      const parent = above[item.depth - 1];
      if (parent) d += `M${parent.x + 10} ${parent.y + ROW - 5}V${item.y + 12}H${item.x}`;
      above[item.depth] = item;
    });
    set(this.lines.firstChild, "d", d);
    const height = 8 + ROW * shown.length;
    set(this.lines, "height", height);
    this.paper.style.height = `${height}px`;
  }

  /** Scrolls the node that changed last into view, unless a reader has turned the picture lately. */
  follow() {
    if (performance.now() - this.turnedAt < READER_MS) return;
    let [last, line] = [null, -1];
    for (const item of this.shown) {
      const task = this.state.tasks.get(item.node.task);
      if ((item.how === "waits" || item.how === "running") && task.line >= line) [last, line] = [item, task.line];
    }
    if (!last || last.key === this.followed) return;
    this.followed = last.key;
    const top = this.paper.offsetTop - this.node.offsetTop + last.y;
    if (top < this.node.scrollTop || top + ROW > this.node.scrollTop + this.node.clientHeight) this.node.scrollTop = top - this.node.clientHeight / 2;
  }

  make({ key }) {
    const open = () => {
      if (!this.opened.delete(key)) this.opened.add(key);
      this.show(this.state);
    };
    const name = element("button", { type: "button", class: "name", onclick: (event) => {
      const { item } = event.currentTarget;
      if (item.group) return open();
      this.choose(item.node.task);
    } });
    return element("li", { class: "plan-node" }, name, element("button", { type: "button", class: "folded", onclick: open }));
  }

  update(row, item, state) {
    const { node, how, group, folded } = item;
    const [name, fold] = row.children;
    name.item = item;
    const label = group ?? this.run.nodes.label(node);
    const [sign, words] = STATES[how] ?? STATES.succeeded;
    set(row, "class", `plan-node ${how}${group ? " group" : ""}`);
    set(row, "data-state", how);
    set(row, "data-path", group ? "" : node.path);
    row.style.left = `${item.x}px`;
    row.style.top = `${item.y}px`;
    say(name, `${sign} ${label}`);
    const task = state.tasks.get(node.task);
    const does = how === "waits" && task ? standing(task, state.time) : words;
    const since = node.at <= state.count ? `, since ${seconds(node.from)}` : "";
    set(row, "title", group ?? `${label}: ${does}${since}${node.result && node.endedAt <= state.count ? `\n${node.result}` : ""}\n${node.path}`);
    set(name, "aria-label", group ? `${group}: open` : `${label}, ${words}`);
    fold.hidden = !folded || !!group;
    say(fold, `+${folded}`);
    set(fold, "aria-label", `Open ${label}`);
  }
}
