// The tree of living tasks: how each stands, and what it waits for; and why, for the one that is chosen.

import { element, rows, say, set } from "rpl/elements";
import { childrenOf, seconds, standing, why } from "rpl/run";

/** More rows nobody reads. */
const MOST_ROWS = 250;

const SIGNS = { created: "○", ready: "▶", waits: "◔", suspended: "‖" };

export class TasksView {
  constructor(run, choose) {
    this.run = run;
    this.chosen = null;
    this.choose = choose;
    this.tree = element("ul", { class: "tree", role: "tree", "aria-label": "Tasks" });
    this.more = element("p", { class: "nothing", hidden: true });
    this.reason = element("div", { class: "why", role: "region", "aria-label": "Why", hidden: true });
    this.node = element("div", { class: "tasks" }, this.tree, this.more, this.reason);
    this.tree.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    const row = document.activeElement;
    if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      event.preventDefault();
      event.stopPropagation();
      (event.key === "ArrowDown" ? row.nextElementSibling : row.previousElementSibling)?.focus();
    } else if (event.key === "Enter") {
      row.click();
    }
  }

  show(state) {
    const children = childrenOf(state);
    const list = [];
    let left = 0;
    const stack = [...(children.get(undefined) ?? [])].reverse().map((task) => [task, 0]);
    while (stack.length) {
      const [task, depth] = stack.pop();
      if (list.length < MOST_ROWS) list.push({ task, depth });
      else left++;
      for (const child of [...(children.get(task.id) ?? [])].reverse()) stack.push([child, depth + 1]);
    }
    rows(this.tree, list, ({ task }) => task.id, (item) => this.makeRow(item), (row, item) => this.update(row, item, state));
    this.more.hidden = left === 0;
    say(this.more, `… and ${left} more`);
    this.showReason(state);
  }

  makeRow({ task }) {
    const row = element("li", { role: "treeitem", tabindex: 0, "data-path": task.path, onclick: () => this.pick(task.id) },
      element("span", { class: "sign", "aria-hidden": "true" }), element("span", { class: "name" }), element("span", { class: "does" }));
    return row;
  }

  update(row, { task, depth }, state) {
    const parent = state.tasks.get(task.parent);
    const own = parent ? task.path.slice(parent.path.length + (task.path.startsWith(parent.path) ? 1 : 0)) : task.path;
    const words = standing(task, state.time);
    set(row, "class", task.state);
    set(row, "aria-level", depth + 1);
    set(row, "aria-selected", task.id === this.chosen);
    row.style.setProperty("--depth", Math.min(depth, 12));
    say(row.children[0], SIGNS[task.state]);
    say(row.children[1], own + (task.calls ?? ""));
    say(row.children[2], words);
    set(row, "title", task.at ? `${words}\nat ${task.at}` : words);
  }

  pick(id) {
    this.chosen = this.chosen === id ? null : id;
    this.choose();
  }

  showReason(state) {
    this.reason.hidden = this.chosen === null;
    if (this.chosen === null) return;
    const close = element("button", { type: "button", class: "close", "aria-label": "Close", onclick: () => this.pick(this.chosen) }, "×");
    const lines = state.tasks.has(this.chosen) ? why(state, this.chosen) : this.howItEnded(state);
    const words = JSON.stringify(lines);
    if (words === this.said) return;
    this.said = words;
    this.reason.replaceChildren(close, element("h3", {}, "Why?"), element("ol", {}, ...lines.map(({ depth, text, of }) => {
      const line = element("li", { class: of === undefined ? "" : "task" }, text);
      line.style.setProperty("--depth", depth);
      return line;
    })));
  }

  howItEnded(state) {
    const bar = this.run.barOf.get(this.chosen);
    if (!bar) return [];
    if (bar.from > state.time) return [{ depth: 0, text: `${bar.path} begins at ${seconds(bar.from)}` }];
    const failed = this.run.told.findLast((one) => one.kind === "failure" && one.time <= bar.to && one.task.startsWith(bar.path));
    const lines = [{ depth: 0, text: `${bar.path} ${bar.state} at ${seconds(bar.to ?? state.time)}` }];
    if (bar.result) lines.push({ depth: 1, text: bar.result });
    if (bar.state === "failed" && failed) lines.push({ depth: 1, text: `raised in ${failed.task} at ${seconds(failed.time)}: ${failed.text}` });
    return lines;
  }
}
