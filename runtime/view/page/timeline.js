/** This search's decisions on a line, to look back at; of a recording, its time. */

import { byId, span, tell, toast } from "./words.js";

const SEEK_MS = 120; // between two wishes while the knob is dragged

export class Timeline {
  constructor(model, link, colours) {
    Object.assign(this, { model, link, colours });
    this.slider = byId("scrub");
    this.ticks = byId("ticks");
    this.asked = 0;
    this.sought_ms = 0;
    this.slider.addEventListener("input", () => (model.live ? this.#look() : this.#seek()));
    byId("live").addEventListener("click", () => model.look(null));
    byId("play").addEventListener("click", () => {
      link.send({ kind: "play", speed: model.at?.speed ? 0 : 1 });
    });
    model.on("timeline decision welcome past", () => model.live && this.#live());
    model.on("span at welcome", () => model.live || this.#replay());
    new ResizeObserver(() => this.draw()).observe(this.ticks);
  }

  // -- live: a step is a decision -----------------------------------------------------------------

  #live() {
    const { decisions } = this.model.timeline;
    const { past } = this.model;
    if (past && past.id !== this.model.timeline.id) {
      this.model.look(null); // another search began
      return;
    }
    document.body.toggleAttribute("data-past", Boolean(past));
    byId("live").disabled = !past;
    this.slider.disabled = decisions.length < 2;
    this.slider.max = String(Math.max(0, decisions.length - 1));
    this.slider.step = "1";
    const at = past ? decisions.findIndex((d) => d.number === past.number) : decisions.length - 1;
    this.slider.value = String(Math.max(0, at));
    const told = past
      ? `Decision ${past.number} of ${decisions.at(-1)?.number ?? past.number}, then`
      : decisions.length
        ? `Decision ${decisions.at(-1).number}, now`
        : "No decision yet";
    tell(byId("scrub-told"), told);
    this.slider.setAttribute("aria-valuetext", told);
    this.draw();
  }

  async #look() {
    const { decisions } = this.model.timeline;
    const index = Number(this.slider.value);
    const turn = ++this.asked;
    if (index >= decisions.length - 1) {
      this.model.look(null);
      return;
    }
    try {
      const told = await this.link.ask("decision", { number: decisions[index].number });
      if (turn === this.asked) this.model.look(told); // an older wish is forgotten
    } catch (error) {
      toast(error.message, "bad");
      this.model.look(null);
    }
  }

  // -- a recording: a step is a tenth of a second -------------------------------------------------

  #replay() {
    const { span: all, at } = this.model;
    if (!all) return;
    const long_s = all.to_s - all.from_s;
    byId("play").hidden = false;
    byId("live").hidden = true;
    tell(byId("play"), at?.speed ? "Halt" : "Play");
    this.slider.disabled = false;
    this.slider.max = String(Math.round(10 * long_s));
    const now_s = (at?.t_s ?? all.from_s) - all.from_s;
    if (performance.now() - this.sought_ms > 500) this.slider.value = String(Math.round(10 * now_s));
    tell(byId("scrub-told"), `${span(now_s)} of ${span(long_s)}${all.cut ? ", cut off" : ""}`);
    this.slider.setAttribute("aria-valuetext", `${span(now_s)} of ${span(long_s)}`);
    this.draw();
  }

  #seek() {
    this.sought_ms = performance.now();
    if (this.waiting) return;
    this.waiting = setTimeout(() => {
      this.waiting = null;
      const t_s = this.model.span.from_s + Number(this.slider.value) / 10;
      this.link.send({ kind: "seek", t_s });
    }, SEEK_MS);
  }

  // -- both ---------------------------------------------------------------------------------------

  draw() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const { width, height } = this.ticks.getBoundingClientRect();
    if (!width) return;
    [this.ticks.width, this.ticks.height] = [width * ratio, height * ratio];
    const context = this.ticks.getContext("2d");
    context.scale(ratio, ratio);
    const knob = 8; // half of the slider's knob, which never leaves its ends
    const x = (share) => knob + share * (width - 2 * knob);
    const mark = (share, colour, high) => {
      context.fillStyle = colour;
      context.fillRect(Math.round(x(share)) - 1, height / 2 - high, 2, high - 5);
    };
    const [decisions, stops] = this.model.live ? this.#indexed() : this.#timed();
    for (const share of decisions) mark(share, this.colours.frontier, 14);
    for (const share of stops) mark(share, this.colours.zone, 18);
  }

  #indexed() {
    const { decisions, stops } = this.model.timeline;
    const last = Math.max(1, decisions.length - 1);
    const after = (t_s) => {
      const next = decisions.findIndex((d) => d.t_s > t_s);
      if (next === -1) return 1;
      if (next === 0) return 0;
      const [a, b] = [decisions[next - 1].t_s ?? t_s, decisions[next].t_s];
      return (next - 1 + (t_s - a) / Math.max(1e-6, b - a)) / last;
    };
    return [decisions.map((_, i) => i / last), stops.map((s) => after(s.t_s))];
  }

  #timed() {
    const all = this.model.span;
    if (!all) return [[], []];
    const share = ({ t_s }) => (t_s - all.from_s) / Math.max(1e-6, all.to_s - all.from_s);
    return [all.decisions.map(share), all.stops.map(share)];
  }
}
