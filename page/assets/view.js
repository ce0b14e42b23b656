// One run: its map, its plan, its tasks, valves and fluents, and what was told.

import { element, say } from "rpl/elements";
import { MapView } from "rpl/map";
import { LogView, PlanView } from "rpl/plan";
import { CurvesView, FluentsView, ValvesView } from "rpl/quantities";
import { TasksView } from "rpl/tasks";

/** What is read need not change more often than this, in milliseconds. */
const READING_MS = 90;

function panel(name, title, ...nodes) {
  return element("section", { class: `panel ${name}`, "aria-label": title }, element("h2", {}, title), ...nodes);
}

export class RunView {
  constructor(run, { goTo, again, steers, isAlone }) {
    this.run = run;
    const { head } = run;
    this.map = head.map && new MapView(run, isAlone);
    this.plan = new PlanView(run, { steers, again, choose: (task) => this.choose(task) });
    this.tasks = new TasksView(run, again);
    this.valves = new ValvesView(run);
    this.curves = new CurvesView(run);
    this.fluents = new FluentsView(run);
    this.log = new LogView(run, goTo);
    this.title = element("h2", { class: "run-title" }, name(head));
    const quantities = element("div", { class: "quantities" }, panel("valves-panel", "Valves", this.valves.node), panel("curves-panel", "Curves", this.curves.node), panel("fluents-panel", "Fluents", this.fluents.node));
    this.node = element("article", { class: head.map ? "run" : "run without-robot", "aria-label": name(head) }, this.title,
      ...(this.map ? [panel("map-panel", "Map", this.map.node)] : []),
      panel("plan-panel", "Plan", this.plan.node), panel("tasks-panel", "Tasks", this.tasks.node), quantities,
      panel("log-panel", "Told", this.log.node));
    this.read = 0;
  }

  /** Shows an instant: after so many lines, at a time. */
  show(count, time, before, isAsked) {
    const state = this.run.after(count);
    this.map?.show(state, time);
    const now = performance.now();
    if (!isAsked && now - this.read < READING_MS) return false;
    this.read = now;
    const shown = { ...state, time, count };
    this.map?.velocity?.show(state);
    this.plan.show(shown, before);
    this.tasks.show(shown);
    this.valves.show(shown);
    this.curves.show(time, this.run.end);
    this.fluents.show(shown, time, this.run.end);
    this.log.show(count);
    this.plan.follow();
    say(this.title, name(this.run.head) + (state.isFull ? " (the rest was not kept)" : ""));
    return true;
  }

  choose(id) {
    this.tasks.chosen = id;
    this.tasks.choose();
  }

  repaint() {
    this.map?.repaint();
  }
}

/** What a run is called. */
export function name({ plan, map, seed }) {
  return [plan || "a session", map?.name, `seed ${seed}`].filter(Boolean).join(" · ");
}
