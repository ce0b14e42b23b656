// A run as the page has it: the lines of its series, and what they leave at any instant.
// A copy of the state is kept now and then, so that any instant is near one. What `after` gives is shown at once: it goes on
// with the next line that is asked for.

import { isWithin, Nodes } from "rpl/nodes";

/** As far back a failure is looked for that is handled, or raised again. */
const FAR_BACK = 500;

/** Lines between two kept states, at least; with many tasks more, so that keeping them costs no more than the lines do. */
const LINES_BETWEEN = 1500;

/** What there is to see at an instant. */
class State {
  constructor() {
    this.time = 0;
    this.tasks = new Map();
    this.valves = new Map();
    this.fluents = new Map();
    this.robot = null;
    this.robotAt = 0;
    this.ranges = null;
    this.targets = [];
    this.obstacles = [];
    this.belief = null;
    this.closed = null;
    this.things = null;
    this.people = [];
    this.isFull = false;
  }

  copy() {
    const copy = Object.assign(new State(), this);
    copy.tasks = new Map(this.tasks);
    copy.valves = new Map(this.valves);
    copy.fluents = new Map(this.fluents);
    return copy;
  }

  get size() {
    return this.tasks.size + this.valves.size + this.fluents.size;
  }

  /** Takes a line in. */
  take([time, seen]) {
    this.time = time;
    for (const what in seen) {
      const value = seen[what];
      switch (what) {
        case "task": this.tasks.set(value.id, value); break;
        case "ended": this.tasks.delete(value.id); break;
        case "valve": this.valves.set(value.name, value); break;
        case "fluent": this.fluents.set(value.name, { ...value, time }); break;
        case "robot": this.robot = value; this.robotAt = time; break;
        case "ranges": this.ranges = value; break;
        case "targets": this.targets = value; break;
        case "obstacles": this.obstacles = value; break;
        case "belief": this.belief = value; break;
        case "closed": this.closed = value; break;
        case "things": this.things = value; break;
        case "people": this.people = value; break;
        case "full": this.isFull = true; break;
      }
    }
  }
}

/** Kinds of line that tell of the robot going on, and of no event. */
const GOING_ON = ["robot", "ranges", "obstacles", "belief", "people", "targets", "closed", "things"];

/** Whether something happened in a line besides the robot going on. */
export function isEvent([, seen]) {
  return !GOING_ON.some((what) => what in seen);
}

/** How a value of a fluent is drawn: a number, or 0 and 1 for nil and all else. */
function numberOf(text) {
  if (text === null || text === undefined) return null;
  const number = Number(text);
  if (text !== "" && Number.isFinite(number)) return number;
  return text === "nil" ? 0 : 1;
}

/** The robot's quantities: name, unit, and how each is read off a line. */
const ROBOT_CURVES = [
  ["battery", "%", (robot) => robot.battery === undefined ? null : robot.battery / 10],
  ["position certainty", "%", (robot) => robot.certainty / 10],
  ["speed", "m/s", (robot) => robot.speed ? robot.speed[0] / 1000 : null],
];

export class Run {
  constructor(head) {
    this.head = head;
    this.lines = [];
    this.times = [];
    this.kept = [{ at: 0, state: new State() }];
    this.latest = new State();
    this.sinceKept = 0;
    /** Where the robot believed to be: line number, time, x, y, certainty. */
    this.track = [];
    /** What was told: line number, time, and what. */
    this.told = [];
    /** Tasks and plan calls, as far as they have come. */
    this.nodes = new Nodes(head.texts);
    /** Curves of numbers by name. */
    this.curves = new Map();
    this.isOver = false;
  }

  /** Adds lines as text. */
  add(text) {
    let from = 0;
    while (from < text.length) {
      let to = text.indexOf("\n", from);
      if (to < 0) to = text.length;
      if (to > from) this.addLine(JSON.parse(text.slice(from, to)));
      from = to + 1;
    }
  }

  addLine(line) {
    const [time, seen] = line;
    const at = this.lines.push(line);
    this.times.push(time);
    if (seen.valve) this.nameHolders(seen.valve);
    this.latest.take(line);
    if (seen.robot) this.noteRobot(at, time, seen.robot);
    if (seen.told) this.noteTold({ at, time, ...seen.told });
    if (seen.fluent) this.curve(seen.fluent.name, "").add(time, numberOf(seen.fluent.value), seen.fluent.value);
    if (seen.task) this.nodes.take(seen.task, time, at);
    if (seen.ended) this.noteEnded(seen.ended, time, at);
    if (++this.sinceKept >= Math.max(LINES_BETWEEN, this.latest.size)) {
      this.kept.push({ at, state: this.latest.copy() });
      this.sinceKept = 0;
    }
  }

  /** A holder goes by the plan call in which it was given the valve, although it may be in another one by now. */
  nameHolders(valve) {
    const before = this.latest.valves.get(valve.name)?.names ?? new Map();
    const name = (id) => before.get(id) ?? (this.latest.tasks.has(id) ? this.nodes.holderName(this.latest.tasks.get(id)) : "?");
    valve.names = new Map([...valve.holders, ...valve.taken].map((id) => [id, name(id)]));
  }

  noteRobot(at, time, robot) {
    this.track.push([at, time, robot.estimate[0], robot.estimate[1], robot.certainty]);
    for (const [name, unit, read] of ROBOT_CURVES) {
      const number = read(robot);
      if (number !== null) this.curve(name, unit, true).add(time, number);
    }
  }

  curve(name, unit, isOfRobot = false) {
    const key = isOfRobot ? `robot ${name}` : name;
    if (!this.curves.has(key)) this.curves.set(key, new Curve(name, unit, isOfRobot));
    return this.curves.get(key);
  }

  noteTold(one) {
    const last = this.told[this.told.length - 1];
    if (one.kind === "handled") {
      const failure = this.lastFailure((told) => !told.handledAt && isWithin(told.task, one.task));
      if (failure) failure.handledAt = one.at;
      return;
    }
    if (one.kind === "robot" && last?.kind === "failure" && last.time === one.time && one.text.endsWith(`gives up: ${last.text}`)) return;
    const failure = one.kind === "failure" && this.lastFailure(() => true);
    // It goes up through tasks, or a handler has raised it again.
    const isSame = failure && failure.text === one.text && isWithin(failure.task, one.task) && (failure.time === one.time || !failure.handledAt);
    if (isSame) failure.handledAt = undefined;
    else this.told.push(one);
  }

  /** The last failure of those that are meant, among the last few things that were told. */
  lastFailure(isMeant) {
    for (let at = this.told.length - 1; at >= Math.max(0, this.told.length - FAR_BACK); at--) {
      if (this.told[at].kind === "failure" && isMeant(this.told[at])) return this.told[at];
    }
    return null;
  }

  noteEnded(ended, time, at) {
    const node = this.nodes.end(ended, time, at);
    if (!node || node.parent || ended.state !== "failed") return;
    const failure = this.lastFailure((told) => told.text === ended.result && isWithin(told.task, node.path))
      ?? this.lastFailure((told) => isWithin(told.task, node.path));
    // Nothing is above it that could handle it.
    if (failure) failure.endsAt = at;
  }

  /** The time of the last line. */
  get end() {
    return this.times.length ? this.times[this.times.length - 1] : 0;
  }

  /** How many lines there are up to a time. */
  upTo(time) {
    let low = 0;
    let high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The state after so many lines. From the last one asked for it is not far, if that was just before. */
  after(count) {
    count = Math.min(count, this.lines.length);
    if (count === this.lines.length) return this.latest;
    let low = 0;
    let high = this.kept.length;
    while (low + 1 < high) {
      const middle = (low + high) >> 1;
      if (this.kept[middle].at <= count) low = middle;
      else high = middle;
    }
    let from = this.kept[low];
    if (this.asked && this.asked.at <= count && this.asked.at >= from.at) from = this.asked;
    const state = from === this.asked ? from.state : from.state.copy();
    for (let at = from.at; at < count; at++) state.take(this.lines[at]);
    this.asked = { at: count, state };
    return state;
  }

  /** Where the robot believed to be between two lines, so that it moves evenly. */
  poseAt(time) {
    const next = search(this.track, time);
    const before = this.track[next - 1];
    const after = this.track[next];
    if (!before) return null;
    const one = this.lines[before[0] - 1][1].robot;
    if (!after) return one;
    const other = this.lines[after[0] - 1][1].robot;
    const share = (time - before[1]) / Math.max(1, after[1] - before[1]);
    const is_jump = Math.hypot(other.estimate[0] - one.estimate[0], other.estimate[1] - one.estimate[1]) > 1000;
    if (is_jump || after[1] - before[1] > 2e6) return one;
    return { ...one, estimate: between(one.estimate, other.estimate, share),
      truth: one.truth && other.truth ? between(one.truth, other.truth, share) : one.truth };
  }
}

function between(one, other, share) {
  let turn = other[2] - one[2];
  turn -= Math.round(turn / (2000 * Math.PI)) * 2000 * Math.PI;
  return [one[0] + share * (other[0] - one[0]), one[1] + share * (other[1] - one[1]), one[2] + share * turn];
}

/** How many entries of the track are not later than a time. */
export function search(track, time) {
  let low = 0;
  let high = track.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (track[middle][1] <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** A number over the time of the run, and its least and greatest. */
class Curve {
  constructor(name, unit, isOfRobot) {
    Object.assign(this, { name, unit, isOfRobot, points: [], low: Infinity, high: -Infinity, isOfNumbers: true });
  }

  add(time, number, text) {
    if (number === null) return;
    this.points.push([time, number]);
    this.low = Math.min(this.low, number);
    this.high = Math.max(this.high, number);
    if (text !== undefined && !Number.isFinite(Number(text))) this.isOfNumbers = false;
  }

  /** Its number at a time; none before the first. */
  at(time) {
    let low = 0;
    let high = this.points.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.points[middle][0] <= time) low = middle + 1;
      else high = middle;
    }
    return low ? this.points[low - 1][1] : null;
  }
}

/** The children of each task, in the order of beginning; under `undefined` those without a living parent. */
export function childrenOf(state) {
  const children = new Map();
  for (const task of state.tasks.values()) {
    const parent = state.tasks.has(task.parent) ? task.parent : undefined;
    if (!children.has(parent)) children.set(parent, []);
    children.get(parent).push(task);
  }
  for (const list of children.values()) list.sort((one, other) => one.id - other.id);
  return children;
}

/** What a task does, in words. */
export function standing(task, time) {
  const until = task.until === undefined ? ""
    : ` until ${seconds(task.until)}${task.until > time ? `, in ${seconds(task.until - time)}` : ""}`;
  const on = task.on === "time" ? `time${until}` : `${task.on ?? ""}${until && `, at most${until}`}`;
  switch (task.state) {
    case "created": return "created";
    case "ready": return "runs";
    case "waits": return `waits for ${on}`;
    default: return task.on ? `suspended (was waiting for ${on})` : "suspended";
  }
}

/** Why a task stands as it does: lines with a depth, down to what nobody waits behind. */
export function why(run, state, id, depth = 0, said = new Set(), lines = []) {
  const task = state.tasks.get(id);
  if (!task || depth > 8 || lines.length > 60) return lines;
  const say = (text, more = 0, of = undefined) => lines.push({ depth: depth + more, text, of: of?.id, path: of?.path });
  say(`${run.nodes.taskName(task)} ${standing(task, state.time)}`, 0, task);
  if (said.has(id)) return lines;
  said.add(id);
  if (task.at) say(`at ${task.at}`, 1);
  const read = (reading, more) => {
    const now = state.fluents.get(reading.fluent);
    const since = now ? `, since ${seconds(now.time)}, by ${run.nodes.nameOf(now.by)}` : "";
    say(`${reading.fluent} = ${now?.value ?? reading.value}${since}`, more);
    (reading.from ?? []).forEach((inner) => read(inner, more + 1));
  };
  (task.reads ?? []).filter((reading) => !reading.fluent.startsWith("%")).forEach((reading) => read(reading, 1));
  const follow = (other, words) => {
    say(words, 1);
    why(run, state, other, depth + 2, said, lines);
  };
  if (task.state === "suspended") {
    for (const by of task.by ?? []) if (state.tasks.has(by)) follow(by, "it is suspended by");
    for (const valve of state.valves.values()) {
      if (!valve.taken.some((root) => isBelow(state, id, root))) continue;
      for (const holder of valve.holders) {
        if (!isBelow(state, holder, id)) follow(holder, valve.holders.length > 1 ? `${valve.name} was taken from it, and held now by` : `${valve.name} was taken from it by`);
      }
    }
  }
  const valve = task.on?.startsWith("valve ") && state.valves.get(task.on.slice(6));
  for (const holder of valve ? valve.holders : []) if (holder !== id) follow(holder, "the valve is held by");
  if (task.on === "children") {
    for (const child of state.tasks.values()) {
      if (child.parent === id && lines.length < 40) why(run, state, child.id, depth + 1, said, lines);
    }
  }
  return lines;
}

function isBelow(state, id, root) {
  for (let at = id, steps = 0; at !== undefined && steps < 1000; steps++) {
    if (at === root) return true;
    at = state.tasks.get(at)?.parent;
  }
  return false;
}

/** A time in microseconds, as a person reads it. */
export function seconds(time) {
  return `${(time / 1e6).toFixed(time < 1e9 ? 1 : 0)} s`;
}

/** The same on a clock. */
export function clock(time) {
  const whole = Math.floor(time / 1e6);
  const two = (number) => String(number).padStart(2, "0");
  const hours = Math.floor(whole / 3600);
  const rest = `${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}.${Math.floor((time % 1e6) / 1e5)}`;
  return hours ? `${hours}:${rest}` : rest;
}
