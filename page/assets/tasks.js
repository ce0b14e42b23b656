// The tree of living tasks: how each stands, and what it waits for; and why, for the one that is chosen.

import { element, rows, say, set } from "rpl/elements";
import { callName, isWithin } from "rpl/nodes";
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
    this.node = element("div", { class: "tasks" }, element("div", { class: "task-list" }, this.tree, this.more), this.reason);
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
      const below = children.get(task.id) ?? [];
      // A part of a construct that only waits for its own parts has nothing to tell.
      const isShown = !(task.on === "children" && below.length && this.run.nodes.isNameless(task));
      if (isShown && list.length < MOST_ROWS) list.push({ task, depth });
      else if (isShown) left++;
      for (const child of [...below].reverse()) stack.push([child, isShown ? depth + 1 : depth]);
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
    const words = standing(task, state.time);
    set(row, "class", task.state);
    set(row, "aria-level", depth + 1);
    set(row, "aria-selected", task.id === this.chosen);
    row.style.setProperty("--depth", Math.min(depth, 12));
    say(row.children[0], SIGNS[task.state]);
    const name = this.run.nodes.taskName(task);
    say(row.children[1], name);
    const around = task.calls?.at(-2);
    const does = task.on === name && task.state === "waits" ? "waits" : words;
    say(row.children[2], around ? `in ${callName(around)}, ${does}` : does);
    set(row, "title", [pathOf(task), words, task.at && `at ${task.at}`].filter(Boolean).join("\n"));
  }

  pick(id) {
    this.chosen = this.chosen === id ? null : id;
    this.choose();
  }

  showReason(state) {
    this.reason.hidden = this.chosen === null;
    if (this.chosen === null) return;
    const close = element("button", { type: "button", class: "close", "aria-label": "Close", onclick: () => this.pick(this.chosen) }, "×");
    const lines = state.tasks.has(this.chosen) ? why(this.run, state, this.chosen) : this.howItEnded(state);
    const words = JSON.stringify(lines);
    if (words === this.said) return;
    this.said = words;
    this.reason.replaceChildren(close, element("h3", {}, "Why?"), element("ol", {}, ...lines.map(({ depth, text, of, path }) => {
      const line = element("li", { class: of === undefined ? "" : "task", title: path, "data-path": path }, text);
      line.style.setProperty("--depth", depth);
      return line;
    })));
  }

  howItEnded(state) {
    const { nodes } = this.run;
    const node = nodes.ofTask.get(this.chosen);
    if (!node) return [];
    const name = nodes.label(node);
    if (node.from > state.time) return [{ depth: 0, text: `${name} begins at ${seconds(node.from)}`, path: node.path }];
    const lines = [{ depth: 0, text: `${name} ${node.state} at ${seconds(node.to ?? state.time)}`, of: node.task, path: node.path }];
    if (node.result) lines.push({ depth: 1, text: node.result });
    if (node.state === "failed") {
      const failed = this.run.told.findLast((one) => one.kind === "failure" && one.time <= node.to && isWithin(one.task, node.path));
      if (failed) lines.push({ depth: 1, text: `raised in ${nodes.nameOf(failed.task)} at ${seconds(failed.time)}: ${failed.text}`, path: failed.task });
    }
    return lines;
  }
}

/** Where a task is: its path with the plan calls it is in. */
function pathOf(task) {
  return [task.path, ...(task.calls ?? []).map(([segment]) => segment)].join("/");
}
