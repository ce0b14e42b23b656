// The page: runs side by side, one instant of all of them, and playing.

import { Comparison } from "rpl/compare";
import { element, say, set } from "rpl/elements";
import { clock, isEvent } from "rpl/run";
import { embedded, Follower, fromReport } from "rpl/sources";
import { TimeLine } from "rpl/time";
import { name, RunView } from "rpl/view";

const find = (id) => document.getElementById(id);
const player = { views: [], time: 0, count: null, isPlaying: false, follows: false, line: null, comparison: null, isDue: true, laidOut: 0, layOutTimer: null, standing: null };

/** The time line of a run that goes on is laid out no more often than this, in milliseconds. */
const LAY_OUT_MS = 250;

function goTo(time, count = null) {
  player.follows = false;
  place(time, count);
}

function place(time, count = null) {
  player.time = Math.min(Math.max(0, time), end());
  player.count = count;
  player.isDue = true;
}

function end() {
  return Math.max(0, ...player.views.map((view) => view.run.end));
}

function again() {
  player.isDue = true;
}

/** To the next or the last line in which something happened besides the robot going on. */
function stepBy(by) {
  const { run } = player.views[0];
  player.isPlaying = false;
  let at = player.count ?? run.upTo(player.time);
  do at += by; while (at > 0 && at < run.lines.length && !isEvent(run.lines[at - 1]));
  at = Math.min(run.lines.length, Math.max(0, at));
  goTo(at ? run.times[at - 1] : 0, at);
}

function setViews(runs) {
  const steers = (text) => player.standing?.control && steer({ break: text });
  player.views = runs.map((run) => new RunView(run, { goTo, again, steers, isAlone: runs.length === 1 }));
  find("runs").replaceChildren(...player.views.map((view) => view.node));
  find("runs").className = runs.length > 1 ? "side-by-side" : "";
  player.line = new TimeLine(runs, goTo, (run, bar) => {
    player.views.find((view) => view.run === run)?.choose(bar.task);
    goTo(bar.from, bar.at);
  });
  find("line").replaceChildren(player.line.node);
  player.comparison = runs.length > 1 ? new Comparison(runs, goTo) : null;
  find("differences").replaceChildren(...(player.comparison ? [player.comparison.node] : []));
  const { head } = runs[0];
  const title = runs.length > 1 ? `${runs.length} runs` : head.plan || "a session";
  say(find("title"), title);
  document.title = `${runs.map((run) => name(run.head)).join(" | ")} – RPL`;
  say(find("facts"), runs.length > 1 ? "" : [head.map?.name, `seed ${head.seed}`, `rpl ${head.rpl}`].filter(Boolean).join(" · "));
  player.line.layOut();
  player.comparison?.show();
  again();
}

// Playing.

let before = null;

function frame(now) {
  const passed = before === null ? 0 : (now - before) * 1000;
  before = now;
  if (player.isPlaying && player.views.length) {
    const next = player.time + passed * Number(find("playback").value);
    place(next);
    if (player.time >= end()) player.isPlaying = false;
  }
  if (player.follows) {
    // A run that comes in bursts is shown evenly: a little behind, and never far.
    const lag = end() - player.time;
    if (lag > 0) place(player.time + Math.max(passed, lag * Math.min(1, passed / 150000)));
  }
  if (player.isDue && player.views.length) show();
  requestAnimationFrame(frame);
}

function show() {
  player.isDue = false;
  layOutLine();
  const isStill = !player.isPlaying && !player.follows;
  for (const view of player.views) {
    const count = player.count !== null && view === player.views[0] ? player.count : view.run.upTo(player.time);
    const at = player.follows || isAtEnd() ? player.standing?.at : null;
    if (!view.show(count, player.time, at, isStill)) player.isDue = true;
  }
  player.line.show(player.time);
  say(find("clock"), clock(player.time));
  set(find("clock"), "data-time", Math.round(player.time));
  say(find("play"), player.isPlaying ? "❚❚" : "▶");
  set(find("play"), "aria-label", player.isPlaying ? "Hold" : "Play");
  set(find("end"), "aria-pressed", player.follows);
}

/** Lays the time line out once the run is longer, and again after the last line if that came too soon. */
function layOutLine() {
  if (player.line.end === Math.max(1, end())) return;
  const left = player.laidOut + LAY_OUT_MS - performance.now();
  if (left > 0) {
    player.layOutTimer ??= setTimeout(() => {
      player.layOutTimer = null;
      again();
    }, left);
    return;
  }
  player.line.layOut();
  player.comparison?.show();
  player.laidOut = performance.now();
}

function isAtEnd() {
  return player.time >= end();
}

// A run that goes on.

let follower = null;

async function steer(asked) {
  if (!follower) return;
  const refused = await follower.say(asked).catch(() => "the run is not heard");
  if (refused) say(find("note"), refused);
}

function stand(standing) {
  const was = player.standing;
  player.standing = standing;
  find("steering").hidden = !standing.control || standing.state === "ended";
  say(find("run-pause"), standing.state === "paused" ? "Let run go on" : "Hold run");
  say(find("note"), standing.note ?? "");
  set(document.body, "data-state", standing.state);
  const words = { running: "live", paused: "the run stands still", ended: "the run has ended" }[standing.state];
  say(find("connection"), words);
  set(find("connection"), "class", standing.state);
  const pace = find("run-pace");
  if (document.activeElement !== pace) pace.value = standing.pace === null ? "" : String(standing.pace);
  find("breaks").replaceChildren(...standing.breakpoints.map((text) => element("button", { type: "button", class: "break",
    title: "Stop there no more", onclick: () => steer({ unbreak: text }) }, `${text} ×`)));
  if (was?.at !== standing.at) again();
}

function listen() {
  follower = new Follower((run, standing) => {
    setViews([run]);
    player.follows = true;
    place(run.end);
    stand(standing);
  }, (standing, more) => {
    if (player.standing) stand(standing);
    if (player.follows && more) place(end());
    again();
  }, (isHeard) => {
    if (player.standing?.state === "ended" && !isHeard) return;
    if (isHeard) return;
    say(find("connection"), "not heard; asking again …");
    set(find("connection"), "class", "lost");
    set(document.body, "data-state", "lost");
  });
  follower.follow();
}

// Buttons and keys.

const acts = {
  start: () => { player.isPlaying = false; goTo(0, 0); },
  back: () => stepBy(-1),
  on: () => stepBy(1),
  end: () => { player.isPlaying = false; player.follows = !!follower; place(end()); },
  play: () => {
    if (!player.isPlaying && isAtEnd()) goTo(0);
    player.follows = false;
    player.isPlaying = !player.isPlaying;
    again();
  },
  theme: () => {
    const root = document.documentElement;
    const isDark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = isDark ? "light" : "dark";
    repaint();
  },
  "help-button": () => find("help").showModal(),
  compare: () => find("compare-file").click(),
  "run-pause": () => steer(player.standing?.state === "paused" ? "go" : "pause"),
  "run-step": () => steer("step"),
  "run-over": () => steer("over"),
  "run-out": () => steer("out"),
  "run-stop": () => steer("stop"),
};
for (const [id, act] of Object.entries(acts)) find(id).addEventListener("click", act);

function repaint() {
  player.views.forEach((view) => view.repaint());
  player.line?.layOut();
  again();
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);

find("run-pace").addEventListener("change", ({ target }) => steer({ pace: target.value === "" ? null : Number(target.value) }));
find("break-form").addEventListener("submit", (event) => {
  event.preventDefault();
  const text = find("break").value.trim();
  if (text) steer({ break: text });
  find("break").value = "";
});
find("compare-file").addEventListener("change", async ({ target }) => {
  const [file] = target.files;
  if (!file) return;
  try {
    const run = await fromReport(await file.text());
    setViews([player.views[0].run, run]);
  } catch (error) {
    say(find("note"), error.message);
  }
  target.value = "";
});

const KEYS = { " ": "play", Home: "start", End: "end", t: "theme", "?": "help-button", p: "run-pause", s: "run-step", o: "run-over", u: "run-out" };
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, dialog")) return;
  const far = event.shiftKey && { ArrowLeft: -10e6, ArrowRight: 10e6 }[event.key];
  if (event.key === " " && event.target.closest("button")) return;
  if (far) goTo(player.time + far);
  else if (event.key === "ArrowLeft") stepBy(-1);
  else if (event.key === "ArrowRight") stepBy(1);
  else if (KEYS[event.key] && !(KEYS[event.key].startsWith("run-") && find("steering").hidden)) acts[KEYS[event.key]]();
  else if (!player.views.some((view) => view.map?.key(event.key))) return;
  event.preventDefault();
});

// The start: runs in the page, or one that goes on.

const runs = await embedded();
if (runs.length) {
  setViews(runs);
  const at = Number(new URLSearchParams(location.hash.slice(1)).get("t"));
  place(Number.isFinite(at) && at > 0 ? at * 1e6 : end());
  set(document.body, "data-state", "ended");
} else {
  listen();
}
requestAnimationFrame(frame);
