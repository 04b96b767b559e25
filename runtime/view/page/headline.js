/** What is said of all in a line: how the robot stands, what it does, what is wrong, how old it is. */

import { byId, element, metres, remedy, replace, sentence, span, stateSaid, tell, usd } from "./words.js";

const LINK = { ok: "Connected", none: "Connecting", silent: "Silent", lost: "Not connected" };
const LASTS_MS = 700; // what holds the base for less is not worth a line that moves the map
const FOUND_FOR_MS = 60_000; // a result is told above the page for so long

export class Headline {
  constructor(model, stop) {
    Object.assign(this, { model, stop });
    this.resultId = undefined; // of the result that was there when the page opened: old news
    this.result_ms = -1e9;
    this.away = new Set(); // results that a person has put away
    [this.wanted, this.wanted_ms, this.told] = ["", 0, null]; // of the notice
    byId("notice-key").addEventListener("click", () => {
      this.away.add(this.model.state?.last?.id);
      this.draw();
    });
    model.on("state link stop-asked welcome", () => this.draw());
    setInterval(() => this.draw(), 1000); // ages grow by themselves
  }

  draw() {
    const { model } = this;
    const { link } = model;
    document.body.dataset.link = link;
    document.body.dataset.mode = model.live ? "live" : "replay";
    tell(byId("link-text"), model.live ? LINK[link] : `Recording ${model.welcome.file ?? ""}`);
    this.#stale(link);
    this.#notice();
    this.#now();
    const goal = model.state?.goal?.text;
    const state = model.state?.runtime?.state;
    const title = state === "stopped" ? "STOPPED" : goal ? `${goal}` : "";
    document.title = title ? `${title} · RF-NAV` : "RF-NAV";
  }

  #sentence(text) {
    return sentence(text, Object.keys(this.model.health?.streams ?? {}));
  }

  #stale(link) {
    const { welcome, sentAway } = this.model;
    const old = (link === "lost" || link === "silent") && (welcome || sentAway);
    byId("stale").hidden = !old;
    if (!old) return;
    const age_s = this.model.age_s;
    const since = age_s == null ? "" : ` What is shown is ${span(age_s)} old.`;
    const why = !this.model.open
      ? sentAway || "No connection to rfnav view."
      : this.model.state?.why || (link === "silent" ? "The robot says nothing." : "No service answers.");
    tell(byId("stale"), `${this.#sentence(why)}${since}`);
  }

  #now() {
    const { state } = this.model;
    const now = byId("now");
    now.toggleAttribute("data-any", Boolean(state));
    if (!state) return;
    const { goal, runtime } = state;
    tell(byId("now-goal"), goal ? goal.text : stateSaid(runtime?.state));
    const does = goal
      ? goal.paused ? `Paused: ${goal.paused}` : goal.reason || stateSaid(runtime?.state)
      : this.#sentence(state.last?.sentence ?? runtime?.cause ?? "");
    const twice = !goal && does === this.told?.text; // it is in the line above already
    tell(byId("now-does"), twice ? "" : does);
    const rows = [];
    if (goal) {
      rows.push(["time", span(goal.elapsed_s)], ["way", metres(goal.driven_m)]);
      if (goal.frontiers != null) rows.push(["frontiers", String(goal.frontiers)]);
      if (goal.usd) rows.push(["cost", usd(goal.usd)]);
    }
    if (goal || Math.abs(state.v_mps ?? 0) > 0.01) {
      const slow = state.caution?.reason ? `, slow: ${state.caution.reason}` : "";
      rows.push(["speed", `${(state.v_mps ?? 0).toFixed(2)} m/s${slow}`]);
    }
    if (state.queue?.length) rows.push(["then", state.queue.map((q) => q.goal).join(", ")]);
    replace(byId("now-figures"), JSON.stringify(rows), () =>
      rows.map(([name, told]) => element("div", {}, element("dt", {}, name), element("dd", {}, told))),
    );
  }

  /** The one line that matters most; none where all is well. */
  #notice() {
    const told = this.#steady(this.#gravest());
    const box = byId("notice");
    box.hidden = !told;
    if (!told) return;
    box.dataset.kind = told.kind;
    tell(byId("notice-title"), told.title);
    tell(byId("notice-text"), told.text ?? "");
    byId("notice-key").hidden = told.key == null;
    tell(byId("notice-key"), told.key ?? "");
  }

  /** What has been so for a while; what is grave at once. */
  #steady(told) {
    const kind = told ? told.title : "";
    const now_ms = performance.now();
    if (kind !== this.wanted) [this.wanted, this.wanted_ms] = [kind, now_ms];
    const same = this.told?.title === told?.title;
    if (same || told?.kind === "bad" || now_ms - this.wanted_ms >= LASTS_MS) this.told = told;
    return this.told;
  }

  #gravest() {
    const { state } = this.model;
    if (this.stop.unconfirmed) {
      return {
        kind: "bad",
        title: "The stop is not confirmed.",
        text: "Use the switch on the robot. It is asked again and again.",
      };
    }
    if (!state || !["ok", "silent"].includes(this.model.link)) return null;
    const { runtime } = state;
    const cause = runtime?.cause ?? "";
    switch (runtime?.state) {
      case "stopped":
        return { kind: "bad", title: "Stopped.", text: `${this.#sentence(cause.split(": ask rfnav")[0])} It stays so until it is released.` };
      case "fault":
        return { kind: "bad", title: "Fault.", text: cause };
      case "held":
        return { kind: "warn", title: "Held.", text: `${this.#sentence(cause.replace(/^\w+: /, ""))} ${remedy(cause)}` };
      case "paused":
        return { kind: "warn", title: "Paused.", text: this.#sentence(cause) };
      case "degraded":
        return { kind: "warn", title: "Searching with less than it was given.", text: this.#sentence(cause) };
    }
    if (state.refuses && !state.goal) {
      return { kind: "warn", title: "No goal is taken.", text: this.#sentence(state.refuses) };
    }
    return this.#result(state);
  }

  #result({ last, goal }) {
    const id = last?.id;
    if (this.resultId === undefined) this.resultId = id ?? null;
    if (id && id !== this.resultId) [this.resultId, this.result_ms] = [id, performance.now()];
    const fresh = performance.now() - this.result_ms < FOUND_FOR_MS;
    if (!last || goal || !fresh || this.away.has(id)) return null;
    const good = ["found", "arrived"].includes(last.result);
    const title = { found: "Found.", arrived: "Arrived.", not_found: "Not found." }[last.result] ?? "Ended.";
    return { kind: good ? "good" : "warn", title, text: this.#sentence(last.sentence), key: "OK" };
  }
}
