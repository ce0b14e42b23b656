// Tasks and plan calls over the whole run as one tree, and their names: a plan call is called by its plan and arguments, a
// task by its tag or by the plan that it calls. Names of constructs with a position, as `with-policy[1]`, say nothing to a
// reader; they stay in the paths.

/** A form or condition that names a task is no longer than this. */
const LONGEST_FORM = 40;

/** Whether a path is another one, or lies below it. */
export function isWithin(path, above) {
  return path === above || path.startsWith(`${above}/`);
}

/** A plan call as one writes it. */
export function callName([segment, given]) {
  // A named argument that is nil is as good as none.
  return `${segment.replace(/\.\d+$/, "")} ${given.replace(/(^| ):\S+ nil(?= |$)/g, "")}`.trim();
}

export class Nodes {
  constructor(texts) {
    this.texts = new Map(texts.map(({ name, text }) => [name, text.split("\n")]));
    /** All of them in the order of beginning. */
    this.all = [];
    this.roots = [];
    this.ofTask = new Map();
    this.byPath = new Map();
    /** The calls that each living task is in. */
    this.calls = new Map();
  }

  /** A task stands as told in a line. */
  take(task, time, at) {
    // A state keeps the last line about each task: so it can be asked which of them changed last.
    task.line = at;
    const own = this.ofTask.get(task.id) ?? this.begin(task, time, at);
    const calls = this.calls.get(task.id);
    const told = task.calls ?? [];
    let same = 0;
    while (same < calls.length && calls[same].segment === told[same]?.[0]) same++;
    while (calls.length > same) this.close(calls.pop(), task.returned ?? "left", "", time, at);
    for (const call of told.slice(same)) {
      const above = calls[calls.length - 1] ?? own;
      const node = this.add(above, { task: task.id, name: callName(call), path: `${above.path}/${call[0]}`, segment: call[0] }, time, at);
      calls.push(node);
      own.call ??= node.name;
    }
    if (!own.name && !own.words) {
      own.words = this.words(task);
      own.isOfPlan = !!own.words && this.form(task.at) !== null;
    }
  }

  begin(task, time, at) {
    const parent = this.ofTask.get(task.parent);
    const segment = task.path.slice(task.path.lastIndexOf("/") + 1);
    const place = task.path.slice(0, -segment.length - 1);
    const around = parent && (this.calls.get(parent.task)?.find((call) => call.path === place) ?? parent);
    const name = /\[\d+\]$/.test(segment) ? null : segment;
    const node = this.add(around ?? null, { task: task.id, name, path: task.path, segment, isTask: true }, time, at);
    this.ofTask.set(task.id, node);
    this.calls.set(task.id, []);
    return node;
  }

  add(parent, what, time, at) {
    const node = { ...what, number: this.all.length, parent, children: [], from: time, at, to: null, endedAt: null, state: null, result: "" };
    this.all.push(node);
    (parent ? parent.children : this.roots).push(node);
    this.byPath.set(node.path, node);
    return node;
  }

  close(node, state, result, time, at) {
    Object.assign(node, { state, result, to: time, endedAt: at });
  }

  /** A task is no more. */
  end({ id, state, result }, time, at) {
    const node = this.ofTask.get(id);
    if (!node || node.endedAt !== null) return null;
    for (const call of this.calls.get(id).reverse()) this.close(call, state, result ?? "", time, at);
    this.calls.delete(id);
    this.close(node, state, result ?? "", time, at);
    return node;
  }

  /** The form of the plan at a place, as far as a line has it. */
  form(place) {
    const [, name, line, column] = place?.match(/^(.*):(\d+):(\d+)$/) ?? [];
    return this.texts.get(name)?.[line - 1]?.slice(column - 1).trim() ?? null;
  }

  words(task) {
    const form = task.on === "children" ? null : this.form(task.at) ?? task.on;
    return form && (form.length > LONGEST_FORM ? `${form.slice(0, LONGEST_FORM)}…` : form);
  }

  /** How a node has ended: a failure that is not handled goes up to the task at the top. */
  howEnded(node) {
    if (node.endedAt === null) return "alive";
    if (node.state !== "failed") return node.state;
    let top = node;
    while (top.parent && top.state === "failed") top = top.parent;
    return top.state === "failed" ? "failed" : "handled";
  }

  /** The name of a node. */
  label(node) {
    return node.name ?? node.call ?? node.words ?? node.segment.replace(/(?:\.\d+)?\[(\d+)\]$/, (_, position) => `, part ${Number(position) + 1}`);
  }

  /** The name of a living task now: its tag, and the innermost plan that it calls. */
  taskName(task) {
    const own = this.ofTask.get(task.id);
    const calls = task.calls ?? [];
    const call = calls.length ? callName(calls[calls.length - 1]) : null;
    if (!call) return own.name ?? this.words(task) ?? this.label(own);
    return own.name && own.parent ? `${own.name}: ${call}` : call;
  }

  /** The name of a living task as the holder of a valve. One without a name goes by the call that it is a part of. */
  holderName(task) {
    if (!this.isNameless(task)) return this.taskName(task);
    let node = this.ofTask.get(task.id);
    while (node.parent && !node.name) node = node.parent;
    return this.label(node);
  }

  /** Whether a living task has neither a tag nor a plan that it calls. */
  isNameless(task) {
    return !this.ofTask.get(task.id).name && !task.calls?.length;
  }

  /** The name of the task or call at a path; the path itself if there is none. */
  nameOf(path) {
    const node = this.byPath.get(path);
    return node ? this.label(node) : path;
  }
}
