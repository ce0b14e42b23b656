// Where runs come from: this page itself, a file beside it, or the server of a run that goes on.

import { Run } from "rpl/run";

/** The layout of head and lines that this page knows. */
const LAYOUT = 2;

/** How long to wait before a server that is gone is asked again. */
const AGAIN_MS = 700;

/** A run that was put into a page: deflated, in base64. */
export async function inflated(text) {
  const bytes = Uint8Array.from(atob(text.trim()), (sign) => sign.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const whole = await new Response(stream).text();
  const end = whole.indexOf("\n");
  const head = JSON.parse(whole.slice(0, end));
  if (head.series !== LAYOUT) throw new Error(`this report was written by rpl ${head.rpl}; it can only be opened by itself`);
  const run = new Run(head);
  run.add(whole.slice(end + 1));
  run.isOver = true;
  return run;
}

/** The runs in this page. */
export function embedded() {
  return Promise.all([...document.querySelectorAll('script[type="application/x-rpl-run"]')].map((node) => inflated(node.textContent)));
}

/** The first run in the text of a report. */
export async function fromReport(text) {
  const found = text.match(/<script type="application\/x-rpl-run">([^<]*)<\/script>/);
  if (!found) throw new Error("there is no run in this file; `rpl run FILE --report FILE.html` writes one");
  return inflated(found[1]);
}

/** Follows a run through its server; tells of the run once it has its head, then of each news, and whether it is heard. */
export class Follower {
  constructor(begun, news, heard) {
    Object.assign(this, { begun, news, heard, from: 0, revision: -1, run: null });
    this.token = new URLSearchParams(location.search).get("token");
  }

  address(path, more = "") {
    return `${path}?${more}${this.token ? `&token=${encodeURIComponent(this.token)}` : ""}`;
  }

  async follow() {
    for (;;) {
      try {
        await this.ask();
      } catch {
        this.heard(false);
        await new Promise((wake) => setTimeout(wake, AGAIN_MS));
      }
    }
  }

  async ask() {
    const answer = await fetch(this.address("lines", `from=${this.from}&revision=${this.revision}`), { cache: "no-store" });
    if (!answer.ok) throw new Error(await answer.text());
    const text = await answer.text();
    const end = text.indexOf("\n");
    const { next, revision, standing, more, head } = JSON.parse(text.slice(0, end));
    let rest = text.slice(end + 1);
    if (head) {
      const headEnd = rest.indexOf("\n");
      const isFirst = !this.run;
      if (isFirst) this.run = new Run(JSON.parse(rest.slice(0, headEnd)));
      rest = rest.slice(headEnd + 1);
      this.run.add(rest);
      Object.assign(this, { from: next, revision });
      this.heard(true);
      if (isFirst) this.begun(this.run, standing);
      return this.news(standing, more);
    }
    this.run.add(rest);
    Object.assign(this, { from: next, revision });
    this.heard(true);
    this.news(standing, more);
  }

  async say(asked) {
    const answer = await fetch(this.address("ask"), { method: "POST", body: JSON.stringify(asked) });
    return answer.ok ? null : answer.text();
  }
}
