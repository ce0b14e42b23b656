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
  ["belief", "belief"], ["rays", "sensor rays"], ["obstacles", "obstacles it remembers"],
  ["targets", "way and targets"], ["trail", "trail"], ["names", "names"],
];

export class MapView {
  constructor(run) {
    this.run = run;
    const { map, robot } = run.head;
    this.map = map;
    this.robot = robot;
    this.look = null;
    this.follows = false;
    this.svg = drawn("svg", { class: "map", role: "img", tabindex: 0, "aria-label": `Map of ${map.name}` });
    this.legend = this.makeLegend();
    this.scale = element("div", { class: "scale", "aria-label": "Scale" }, element("span"));
    this.words = element("p", { class: "whereabouts", role: "status" });
    this.node = element("figure", { class: "map-figure" }, this.svg, this.scale, this.words,
      element("div", { class: "map-tools", role: "toolbar", "aria-label": "Map" },
        this.tool("+", "Nearer (+)", () => this.zoom(0.7)), this.tool("−", "Farther (−)", () => this.zoom(1 / 0.7)),
        this.tool("⤢", "All of it (0)", () => this.all()), this.followTool = this.tool("◎", "Follow the robot (f)", () => this.follow())),
      this.legend);
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
    const truth = this.run.head.truth ? [element("span", {}, key("truth"), "where it really is")] : [];
    const legend = element("details", { class: "legend" }, element("summary", {}, "Legend"),
      element("span", {}, key("estimate"), "where it believes to be"), ...truth, ...boxes);
    legend.open = matchMedia("(min-width: 110rem)").matches;
    return legend;
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
    for (const { kind, outline, radius } of map.solids) {
      const [[x, y]] = outline;
      const path = radius
        ? `M${x - radius} ${-y}a${radius} ${radius} 0 1 0 ${2 * radius} 0a${radius} ${radius} 0 1 0 ${-2 * radius} 0z`
        : `M${outline.map(([x, y]) => `${x} ${-y}`).join("L")}z`;
      paths.set(kind, (paths.get(kind) ?? "") + path);
    }
    for (const [kind, d] of paths) this.solids.append(drawn("path", { class: kind, d }));
    this.belief = layer("belief", "image", { preserveAspectRatio: "none" });
    this.maxima = layer("maxima");
    this.trails = CERTAIN.map((name) => layer(`trail ${name}`, "path"));
    this.rays = layer("rays", "path");
    this.obstacles = layer("obstacles", "path");
    this.targets = layer("targets");
    this.names = layer("names");
    for (const [name, [x, y]] of map.rooms) this.names.append(drawn("text", { x, y: -y, class: "room" }, name));
    for (const [name, [x, y]] of map.places) {
      this.names.append(drawn("circle", { cx: x, cy: -y, r: 60, class: "place" }, drawn("title", {}, name)));
    }
    const radius = this.robot?.radius ?? 250;
    const disc = (kind) => drawn("g", { class: `robot ${kind}`, "data-kind": kind },
      drawn("circle", { r: radius }), drawn("path", { d: `M0 0H${radius * 1.35}` }));
    this.truth = disc("truth");
    this.estimate = disc("estimate");
    this.truth.setAttribute("display", "none");
    this.estimate.setAttribute("display", "none");
    const [x, y] = map.corner;
    this.svg.append(layer("floor", "rect", { x, y: -y - map.size[1], width: map.size[0], height: map.size[1] }),
      this.belief, this.solids, this.names, ...this.trails, this.rays, this.obstacles, this.targets, this.maxima, this.truth, this.estimate);
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
    }
    set(this.followTool, "aria-pressed", this.follows);
  }

  listen() {
    let held = null;
    this.svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? 1.15 : 1 / 1.15);
    }, { passive: false });
    this.svg.addEventListener("pointerdown", (event) => {
      held = [event.clientX, event.clientY];
      this.svg.setPointerCapture(event.pointerId);
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (!held) return;
      this.follows = false;
      this.look.x -= (event.clientX - held[0]) * this.perPixel;
      this.look.y -= (event.clientY - held[1]) * this.perPixel;
      held = [event.clientX, event.clientY];
      this.frame();
    });
    for (const end of ["pointerup", "pointercancel"]) this.svg.addEventListener(end, () => { held = null; });
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

