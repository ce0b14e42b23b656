// The map: what stands there, and what the robot believes, sees and wants. Lengths in millimetres, y upwards in the run and
// downwards in the drawing.

import { drawn, element, say, set } from "rpl/elements";
import { search } from "rpl/run";

/** So much of the past is drawn as a trail. */
const TRAIL = 90e6;

/** Certainty below which the trail has each of its colours. */
const CERTAINTIES = [250, 500, 800, 1001];
const CERTAIN = ["lost", "doubtful", "likely", "certain"];

/** Steps of the belief's scale. */
const STEPS = 9;

const LAYERS = [
  ["belief", "belief"], ["rays", "sensor rays"], ["obstacles", "remembered obstacles"],
  ["targets", "way and targets"], ["trail", "trail"], ["names", "rooms and places"],
];

/** A press that moves less than this, in pixels, is a click. */
const CLICK = 4;

/** Size of names, and about how wide a letter of them is, in pixels. */
const NAME = 11;
const LETTER = 6.4;

/** More names are not laid out. */
const MOST_NAMES = 400;

/** How a person is drawn, in millimetres. */
const PERSON = 250;

export class MapView {
  constructor(run, isAlone) {
    this.run = run;
    this.drawnClosed = this.drawnThings = this.drawnPeople = undefined;
    const { map, robot } = run.head;
    this.map = map;
    this.robot = robot;
    this.look = null;
    this.follows = false;
    this.svg = drawn("svg", { class: "map", role: "img", tabindex: 0, "aria-label": `Map of ${map.name}` });
    this.legend = this.makeLegend();
    this.legend.open = isAlone && matchMedia("(min-width: 62rem)").matches;
    this.scale = element("div", { class: "scale", "aria-label": "Scale" }, element("span"));
    this.words = element("p", { class: "whereabouts", role: "status" });
    this.measured = element("div", { class: "measured", role: "status", "aria-label": "Measured", hidden: true });
    this.velocity = robot && new VelocityView(robot);
    this.node = element("div", { class: "map-view" },
      element("figure", { class: "map-figure" }, this.svg),
      element("div", { class: "map-side" },
        element("div", { class: "map-tools", role: "toolbar", "aria-label": "Map" },
          this.tool("+", "Nearer (+)", () => this.zoom(0.7)), this.tool("−", "Farther (−)", () => this.zoom(1 / 0.7)),
          this.tool("⤢", "All of it (0)", () => this.all()), this.followTool = this.tool("◎", "Follow the robot (f)", () => this.follow())),
        this.measured, this.legend, ...(this.velocity ? [this.velocity.node] : [])),
      element("div", { class: "map-foot" }, this.scale, this.words));
    this.makeLayers();
    this.listen();
    new ResizeObserver(() => this.frame()).observe(this.svg);
    this.all();
  }

  tool(sign, title, act) {
    return element("button", { type: "button", title, "aria-label": title, onclick: act }, sign);
  }

  makeLegend() {
    const key = (kind) => drawn("svg", { class: `key key-${kind}`, viewBox: "0 0 24 12", "aria-hidden": "true" },
      ...(kind === "trail" ? CERTAIN.map((name, at) => drawn("path", { class: `trail ${name}`, d: `M${at * 6} 6h6` })) : [drawn("path", { d: "M2 6h20" })]));
    const boxes = LAYERS.map(([name, words]) => element("label", {},
      element("input", { type: "checkbox", checked: true, onchange: (event) => this.svg.classList.toggle(`without-${name}`, !event.target.checked) }),
      name === "belief" ? this.beliefKey() : key(name), words));
    const others = [
      ...(this.map.doors.length ? [["open", "open door"], ["closed", "closed door"]] : []),
      ...(this.run.head.truth ? [["truth", "real position"], ["things", "not in its map"], ["people", "people"]] : []),
    ].map(([kind, words]) => element("span", {}, key(kind), words));
    return element("details", { class: "legend" }, element("summary", {}, "Legend"),
      element("span", {}, key("estimate"), "believed position"), ...others, ...boxes);
  }

  beliefKey() {
    const steps = Array.from({ length: STEPS }, (_, at) => element("i", { class: `step step-${at + 1}` }));
    return element("span", { class: "ramp", title: "as likely as the likeliest place: a thousandth … all" }, "1⁄1000", ...steps, "1");
  }

  makeLayers() {
    const { map } = this;
    const layer = (name, tag = "g", attributes = {}) => drawn(tag, { class: name, ...attributes });
    this.solids = layer("solids");
    const paths = new Map();
    for (const solid of map.solids) {
      if (solid.kind !== "unmapped") paths.set(solid.kind, (paths.get(solid.kind) ?? "") + outlinePath(solid));
    }
    for (const [kind, d] of paths) this.solids.append(drawn("path", { class: kind, d }));
    this.doors = layer("doors");
    map.doors.forEach(({ room }) => this.doors.append(drawn("path", {}, drawn("title", {}, `door of ${room}`))));
    this.things = layer("things");
    this.people = layer("people");
    this.belief = layer("belief", "image", { preserveAspectRatio: "none" });
    this.maxima = layer("maxima");
    this.trails = CERTAIN.map((name) => layer(`trail ${name}`, "path"));
    this.rays = layer("rays", "path");
    this.obstacles = layer("obstacles", "path");
    this.targets = layer("targets");
    this.names = layer("names");
    for (const [name, [x, y]] of map.places) this.names.append(drawn("circle", { cx: x, cy: -y, r: 60, class: "place" }, drawn("title", {}, name)));
    this.called = [...map.places.map((place) => [...place, "place"]), ...map.rooms.map((room) => [...room, "room"])].slice(0, MOST_NAMES)
      .map(([name, [x, y], kind]) => ({ name, x, y: -y, node: this.names.appendChild(drawn("text", { x, y: -y, class: kind }, name)), kind }));
    this.thingNames = [];
    this.clicks = layer("clicks");
    const radius = this.robot?.radius ?? 250;
    const disc = (kind) => drawn("g", { class: `robot ${kind}`, "data-kind": kind },
      drawn("circle", { r: radius }), drawn("path", { d: `M0 0H${radius * 1.35}` }));
    this.truth = disc("truth");
    this.estimate = disc("estimate");
    this.truth.setAttribute("display", "none");
    this.estimate.setAttribute("display", "none");
    const [x, y] = map.corner;
    this.svg.append(layer("floor", "rect", { x, y: -y - map.size[1], width: map.size[0], height: map.size[1] }),
      this.belief, this.solids, this.things, this.doors, ...this.trails, this.rays, this.obstacles, this.targets, this.names, this.people, this.maxima,
      this.truth, this.estimate, this.clicks);
    this.picture = document.createElement("canvas");
  }

  // What is looked at.

  all() {
    const { corner: [x, y], size: [width, height] } = this.map;
    this.follows = false;
    this.look = { x: x + width / 2, y: -(y + height / 2), width: width * 1.04, height: height * 1.04 };
    this.frame();
  }

  zoom(by) {
    this.look.width *= by;
    this.look.height *= by;
    this.frame();
  }

  follow() {
    this.follows = !this.follows;
    if (this.follows) Object.assign(this.look, { width: 9000, height: 9000 });
    this.shown = undefined;
    this.frame();
  }

  frame() {
    const box = this.svg.getBoundingClientRect();
    if (!box.width || !box.height) return;
    if (this.follows && this.pose) Object.assign(this.look, { x: this.pose[0], y: -this.pose[1] });
    const perPixel = Math.max(this.look.width / box.width, this.look.height / box.height);
    const [width, height] = [box.width * perPixel, box.height * perPixel];
    set(this.svg, "viewBox", [this.look.x - width / 2, this.look.y - height / 2, width, height].map((number) => number.toFixed(1)).join(" "));
    if (this.perPixel !== perPixel) {
      this.perPixel = perPixel;
      this.svg.style.setProperty("--pixel", `${perPixel.toFixed(3)}px`);
      const lengths = [100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000, 100000];
      const length = lengths.find((length) => length / perPixel >= 60) ?? 200000;
      this.scale.style.width = `${length / perPixel}px`;
      say(this.scale.firstChild, length < 1000 ? `${length / 10} cm` : `${length / 1000} m`);
      this.layOutNames();
      this.showClicks();
    }
    set(this.followTool, "aria-pressed", this.follows);
  }

  /** Of names that would lie on one another those of places are shown before those of rooms, and these before those of things. */
  layOutNames() {
    const taken = [];
    for (const { name, x, y, node, kind } of [...this.called, ...this.thingNames]) {
      const half = (name.length * LETTER * this.perPixel) / 2;
      const height = NAME * 1.2 * this.perPixel;
      const at = kind === "place" ? y - 8 * this.perPixel : y;
      const box = [x - half, at - height, x + half, at];
      const isFree = taken.every((other) => box[2] < other[0] || box[0] > other[2] || box[3] < other[1] || box[1] > other[3]);
      if (isFree) taken.push(box);
      set(node, "y", at.toFixed(0));
      set(node, "display", isFree ? "inline" : "none");
    }
  }

  listen() {
    let held = null;
    let pressed = null;
    this.svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? 1.15 : 1 / 1.15);
    }, { passive: false });
    this.svg.addEventListener("pointerdown", (event) => {
      held = pressed = [event.clientX, event.clientY];
      this.svg.setPointerCapture(event.pointerId);
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (!held) return;
      if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < CLICK) return;
      pressed = null;
      this.follows = false;
      this.look.x -= (event.clientX - held[0]) * this.perPixel;
      this.look.y -= (event.clientY - held[1]) * this.perPixel;
      held = [event.clientX, event.clientY];
      this.frame();
    });
    this.svg.addEventListener("pointerup", (event) => {
      if (pressed) this.measure(event);
      held = pressed = null;
    });
    this.svg.addEventListener("pointercancel", () => { held = pressed = null; });
  }

  /** Measures from a click to the robot, to the click before and to the nearest place. */
  measure({ clientX, clientY }) {
    const box = this.svg.getBoundingClientRect();
    const x = this.look.x + (clientX - box.left - box.width / 2) * this.perPixel;
    const y = -(this.look.y + (clientY - box.top - box.height / 2) * this.perPixel);
    this.clicked = [...(this.clicked ?? []).slice(-1), [x, y]];
    this.showMeasured();
    this.showClicks();
  }

  showMeasured() {
    if (!this.clicked?.length) return;
    const [x, y] = this.clicked[this.clicked.length - 1];
    const metres = (point) => `${(Math.hypot(point[0] - x, point[1] - y) / 1000).toFixed(2)} m`;
    const [nearest] = this.map.places.map(([name, at]) => ({ name, at, far: Math.hypot(at[0] - x, at[1] - y) })).sort((one, other) => one.far - other.far);
    const facts = [["x", `${(x / 1000).toFixed(2)} m`], ["y", `${(y / 1000).toFixed(2)} m`],
      ...(this.pose ? [["from the robot", metres(this.pose)]] : []), ...(this.clicked.length > 1 ? [["from the last click", metres(this.clicked[0])]] : []),
      ...(nearest ? [["nearest place", `${nearest.name}, ${metres(nearest.at)}`]] : [])];
    const key = facts.join();
    if (key === this.saidMeasured) return;
    this.saidMeasured = key;
    this.measured.hidden = false;
    this.measured.replaceChildren(
      element("p", {}, "Measured", element("button", { type: "button", "aria-label": "Measure no more", onclick: () => this.forgetClicks() }, "×")),
      element("dl", {}, ...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", { "data-measure": name }, value)])));
  }

  forgetClicks() {
    this.clicked = [];
    this.saidMeasured = null;
    this.measured.hidden = true;
    this.showClicks();
  }

  showClicks() {
    const reach = 7 * this.perPixel;
    const crosses = (this.clicked ?? []).map(([x, y]) => `M${x - reach} ${-y}h${2 * reach}M${x} ${-y - reach}v${2 * reach}`).join("");
    const line = this.clicked?.length > 1 ? `M${this.clicked.map(([x, y]) => `${x} ${-y}`).join("L")}` : "";
    this.clicks.replaceChildren(drawn("path", { d: crosses }), drawn("path", { class: "between", d: line }));
  }

  key(name) {
    const act = { "+": () => this.zoom(0.7), "=": () => this.zoom(0.7), "-": () => this.zoom(1 / 0.7), "−": () => this.zoom(1 / 0.7),
      0: () => this.all(), f: () => this.follow() }[name];
    if (act) act();
    return !!act;
  }

  // What is shown.

  show(state, time) {
    const robot = this.run.poseAt(time);
    this.showRobot(robot, state);
    if (state.belief !== this.drawnBelief) this.showBelief(state.belief);
    if (state.obstacles !== this.drawnObstacles) {
      this.drawnObstacles = state.obstacles;
      let d = "";
      for (let at = 0; at + 1 < state.obstacles.length; at += 2) d += `M${state.obstacles[at] * 10} ${-state.obstacles[at + 1] * 10}h0`;
      set(this.obstacles, "d", d);
    }
    this.showTrail(time);
    if (state.closed !== this.drawnClosed) this.showDoors(state.closed);
    if (state.things !== this.drawnThings) this.showThings(state.things);
    if (state.people !== this.drawnPeople) this.showPeople(state.people);
    this.showMeasured();
    if (this.follows) this.frame();
  }

  showRobot(robot, state) {
    this.pose = robot?.estimate ?? null;
    const place = (node, pose) => {
      set(node, "display", pose ? "inline" : "none");
      if (pose) set(node, "transform", `translate(${pose[0].toFixed(0)} ${(-pose[1]).toFixed(0)}) rotate(${(-pose[2] * 0.18 / Math.PI).toFixed(1)})`);
    };
    place(this.estimate, robot?.estimate);
    place(this.truth, robot?.truth);
    if (!robot) return;
    const [x, y, heading] = robot.estimate;
    const [sin, cos] = [Math.sin(heading / 1000), Math.cos(heading / 1000)];
    let rays = "";
    (state.ranges ?? []).forEach((range, at) => {
      const ray = this.robot.rays[at];
      if (!range || !ray) return;
      const from = [x + cos * ray[0] - sin * ray[1], y + sin * ray[0] + cos * ray[1]];
      const to = (heading + ray[2]) / 1000;
      rays += `M${from[0].toFixed(0)} ${(-from[1]).toFixed(0)}L${(from[0] + range * 10 * Math.cos(to)).toFixed(0)} ${(-from[1] - range * 10 * Math.sin(to)).toFixed(0)}`;
    });
    set(this.rays, "d", rays);
    const targets = state.targets;
    const way = targets.length ? `M${x.toFixed(0)} ${(-y).toFixed(0)}${targets.map(([x, y]) => `L${x} ${-y}`).join("")}` : "";
    if (way !== this.drawnWay) {
      this.drawnWay = way;
      this.targets.replaceChildren(drawn("path", { d: way }), ...targets.map(([x, y], at) => {
        const r = at + 1 === targets.length ? 160 : 90;
        return drawn("circle", { cx: x, cy: -y, r });
      }));
    }
    const share = (robot.certainty / 10).toFixed(0);
    const degrees = ((heading * 0.18 / Math.PI % 360) + 360) % 360;
    say(this.words, `${(x / 1000).toFixed(2)} ${(y / 1000).toFixed(2)} m, ${degrees.toFixed(0)}°, certainty ${share} %`);
  }

  /** The leaf of an open door is drawn as it stands in a plan of a house: turned into the room. */
  showDoors(closed) {
    this.drawnClosed = closed;
    this.map.doors.forEach(({ jambs: [[x, y], [otherX, otherY]], open }, number) => {
      const isOpen = closed ? !closed.includes(number) : open;
      const node = this.doors.children[number];
      const [along, across] = [otherX - x, otherY - y];
      const width = Math.hypot(along, across);
      set(node, "class", isOpen ? "open" : "closed");
      set(node, "data-door", isOpen ? "open" : "closed");
      set(node, "d", isOpen ? `M${x} ${-y}L${x - across} ${-(y + along)}A${width} ${width} 0 0 1 ${otherX} ${-otherY}` : `M${x} ${-y}L${otherX} ${-otherY}`);
      say(node.firstChild, `door of ${this.map.doors[number].room}: ${isOpen ? "open" : "closed"}`);
    });
  }

  showThings(things) {
    this.drawnThings = things;
    const there = things ?? this.map.solids.filter(({ kind }) => kind === "unmapped");
    this.thingNames = there.slice(0, MOST_NAMES).map(({ name, outline }) => {
      const middle = (axis) => outline.reduce((sum, point) => sum + point[axis], 0) / outline.length;
      return { name, x: middle(0), y: -middle(1), kind: "thing", node: drawn("text", { x: middle(0).toFixed(0) }, name) };
    });
    this.things.replaceChildren(...there.map((thing) => drawn("path", { d: outlinePath(thing), "data-thing": thing.name },
      drawn("title", {}, `${thing.name}, not in the map`))), ...this.thingNames.map(({ node }) => node));
    if (this.perPixel) this.layOutNames();
  }

  showPeople(people) {
    this.drawnPeople = people;
    const nodes = [];
    for (let at = 0; at + 1 < people.length; at += 2) {
      nodes.push(drawn("circle", { cx: people[at] * 10, cy: -people[at + 1] * 10, r: PERSON }, drawn("title", {}, "a person")));
    }
    this.people.replaceChildren(...nodes);
  }

  showTrail(time) {
    const { track } = this.run;
    const to = search(track, time);
    if (this.drawnTrail === to) return;
    this.drawnTrail = to;
    const paths = CERTAIN.map(() => "");
    let kind = -1;
    for (let at = Math.max(1, search(track, time - TRAIL)); at < to; at++) {
      const [, , x, y, certainty] = track[at];
      const [, , beforeX, beforeY] = track[at - 1];
      const next = CERTAINTIES.findIndex((limit) => certainty < limit);
      if (Math.hypot(x - beforeX, y - beforeY) > 1000) { kind = -1; continue; }
      if (next !== kind) paths[next] += `M${beforeX} ${-beforeY}`;
      paths[next] += `L${x} ${-y}`;
      kind = next;
    }
    this.trails.forEach((node, at) => set(node, "d", paths[at]));
  }

  showBelief(belief) {
    this.drawnBelief = belief;
    this.maxima.replaceChildren();
    if (!belief) return this.belief.removeAttribute("href");
    const runs = [...belief.steps.matchAll(/([a-j])(\d*)/g)];
    const cells = runs.reduce((sum, [, , count]) => sum + (count ? Number(count) : 1), 0);
    const rows = Math.ceil(cells / belief.columns);
    if (!rows) return this.belief.removeAttribute("href");
    Object.assign(this.picture, { width: belief.columns, height: rows });
    const paper = this.picture.getContext("2d");
    const image = paper.createImageData(belief.columns, rows);
    const colours = this.colours();
    let at = 0;
    for (const [, letter, count] of runs) {
      const step = letter.charCodeAt(0) - 97;
      const end = at + (count ? Number(count) : 1);
      if (!step) { at = end; continue; }
      for (; at < end; at++) {
        // Rows go upwards in the run.
        const pixel = ((rows - 1 - Math.floor(at / belief.columns)) * belief.columns + at % belief.columns) * 4;
        image.data.set(colours[step], pixel);
      }
    }
    paper.putImageData(image, 0, 0);
    const [x, y] = belief.corner;
    const [width, height] = [belief.columns * belief.cell, rows * belief.cell];
    for (const [name, value] of Object.entries({ x, y: -y - height, width, height, href: this.picture.toDataURL() })) set(this.belief, name, value);
    if (belief.maxima.length < 2 && belief.maxima[0]?.[2] > 900) return;
    for (const [x, y, share] of belief.maxima) {
      this.maxima.append(drawn("circle", { cx: x, cy: -y, r: 400 }), drawn("text", { x, y: -y - 480 }, `${(share / 10).toFixed(0)} %`));
    }
  }

  /** Red, green, blue and opacity of each step, as the style has them. */
  colours() {
    const probe = element("i", { class: "step" });
    this.node.append(probe);
    const colours = Array.from({ length: STEPS + 1 }, (_, step) => {
      probe.className = `step step-${step}`;
      const numbers = getComputedStyle(probe).backgroundColor.match(/[\d.]+/g)?.map(Number) ?? [0, 0, 0, 0];
      return [numbers[0], numbers[1], numbers[2], step ? 255 * (numbers[3] ?? 1) : 0];
    });
    probe.remove();
    return colours;
  }

  /** Light or dark is another one now. */
  repaint() {
    const belief = this.drawnBelief;
    this.drawnBelief = undefined;
    if (belief) this.showBelief(belief);
  }
}

function outlinePath({ outline, radius }) {
  const [[x, y]] = outline;
  return radius
    ? `M${x - radius} ${-y}a${radius} ${radius} 0 1 0 ${2 * radius} 0a${radius} ${radius} 0 1 0 ${-2 * radius} 0z`
    : `M${outline.map(([x, y]) => `${x} ${-y}`).join("L")}z`;
}

/** The velocity within what the robot can reach: translation upwards, rotation to the left and right. */
export class VelocityView {
  constructor(robot) {
    this.robot = robot;
    this.box = drawn("rect", { class: "window" });
    this.now = drawn("circle", { class: "now", r: 3.5 });
    this.words = element("figcaption");
    this.node = element("figure", { class: "velocity", title: "Velocity, and what can be reached from it" },
      drawn("svg", { viewBox: "-60 -60 120 80", role: "img", "aria-label": "Velocity window" },
        drawn("path", { class: "axes", d: "M-55 0H55M0 15V-55" }), this.box, this.now), this.words);
  }

  show(state) {
    const speed = state.robot?.speed ?? [0, 0];
    const [ahead, turning] = this.robot.fastest;
    const x = (rotation) => (-rotation / turning) * 50;
    const y = (translation) => (-translation / ahead) * 50;
    const [faster, quicker] = this.robot.window;
    const within = (value, low, high) => Math.min(high, Math.max(low, value));
    const left = x(within(speed[1] + quicker, -turning, turning));
    const right = x(within(speed[1] - quicker, -turning, turning));
    const top = y(within(speed[0] + faster, 0, ahead));
    const bottom = y(within(speed[0] - faster, 0, ahead));
    for (const [name, value] of Object.entries({ x: left, y: top, width: right - left, height: Math.max(1, bottom - top) })) set(this.box, name, value.toFixed(1));
    set(this.now, "cx", x(speed[1]).toFixed(1));
    set(this.now, "cy", y(speed[0]).toFixed(1));
    say(this.words, `${(speed[0] / 1000).toFixed(2)} m/s, ${(speed[1] / 1000).toFixed(2)} rad/s`);
  }
}

