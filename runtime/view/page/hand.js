/** Driving by hand: keys, the stick on the page, a gamepad. While it is taken over something is sent
 * ten times a second; what is not sent any more has let go, and the search goes on. */

import { byId, tell } from "./words.js";

const EVERY_MS = 100;
const KEYS = {
  w: [1, 0], s: [-1, 0], a: [0, 1], d: [0, -1],
  ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1],
};
const SHOULDER = 5; // the right one, by the standard mapping
const DEAD = 0.12; // of a gamepad's stick
const BACK = 0.6; // of the speed forward

export class Hand {
  constructor(model, link) {
    Object.assign(this, { model, link });
    this.on = false;
    this.byGamepad = false;
    this.held = new Set();
    this.stick = [0, 0]; // ahead, left
    this.take = byId("drive-take");
    this.take.addEventListener("click", () => (this.on ? this.off() : this.#begin()));
    this.speed = byId("drive-speed");
    this.speed.addEventListener("input", () => this.#told());
    this.#pad(byId("pad"));
    window.addEventListener("keydown", (event) => this.#key(event, true), { capture: true });
    window.addEventListener("keyup", (event) => this.#key(event, false), { capture: true });
    window.addEventListener("blur", () => this.#rest());
    document.addEventListener("visibilitychange", () => document.hidden && this.off());
    window.addEventListener("pagehide", () => this.off());
    setInterval(() => this.#beat(), EVERY_MS);
    model.on("welcome", () => this.#told());
    model.on("state link", () => this.#draw());
  }

  off() {
    if (!this.on) return;
    this.on = this.byGamepad = false;
    this.#rest();
    this.link.send({ kind: "teleop", v: 0, w: 0, end: true });
    this.#draw();
  }

  /** Whether another page has the sticks. */
  get #taken() {
    const { state, welcome } = this.model;
    return state?.teleop != null && state.teleop !== welcome?.you;
  }

  get #may() {
    const { link, state, welcome } = this.model;
    return link === "ok" && Boolean(welcome?.can?.teleop) && !state?.stopped && !this.#taken;
  }

  #begin() {
    if (!this.#may) return; // the note says why
    this.on = true;
    this.#draw();
    this.#beat();
  }

  #rest() {
    this.held.clear();
    this.stick = [0, 0];
    this.#knob(0, 0);
  }

  #beat() {
    const pad = this.#gamepad();
    if (pad && !this.on && this.#may) {
      this.#begin();
      this.byGamepad = this.on;
    }
    if (!pad && this.byGamepad) this.off();
    if (!this.on) return;
    let [v, w] = pad ?? this.stick;
    for (const key of this.held) [v, w] = [v + KEYS[key][0], w + KEYS[key][1]];
    const share = Number(this.speed.value) / 100;
    v = Math.max(-BACK, Math.min(1, v)) * share;
    w = Math.max(-1, Math.min(1, w)) * share;
    this.link.send({ kind: "teleop", v: round(v), w: round(w) });
  }

  #key(event, down) {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!this.on || !KEYS[key] || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLInputElement && event.target.type !== "range") return;
    event.preventDefault();
    event.stopPropagation();
    if (down) this.held.add(key);
    else this.held.delete(key);
  }

  #pad(pad) {
    const moved = (event) => {
      if (!this.on || !pad.hasPointerCapture(event.pointerId)) return;
      const box = pad.getBoundingClientRect();
      const reach = box.width / 3;
      let [x, y] = [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
      const far = Math.hypot(x, y);
      if (far > reach) [x, y] = [(x * reach) / far, (y * reach) / far];
      this.stick = [-y / reach, -x / reach];
      this.#knob(x, y);
    };
    pad.addEventListener("pointerdown", (event) => {
      pad.setPointerCapture(event.pointerId);
      if (!this.on) this.#begin();
      moved(event);
    });
    pad.addEventListener("pointermove", moved);
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      pad.addEventListener(end, () => {
        this.stick = [0, 0];
        this.#knob(0, 0);
      });
    }
  }

  #knob(x, y) {
    const knob = byId("pad").firstElementChild;
    knob.style.setProperty("--x", `${x}px`);
    knob.style.setProperty("--y", `${y}px`);
  }

  /** [ahead, left] while the shoulder key is held; null else. */
  #gamepad() {
    const pad = [...(navigator.getGamepads?.() ?? [])].find((one) => one?.buttons[SHOULDER]?.pressed);
    if (!pad || document.hidden) return null;
    const axis = (i) => (Math.abs(pad.axes[i]) < DEAD ? 0 : -pad.axes[i]);
    return [axis(1), axis(0)];
  }

  #told() {
    const most = this.model.welcome?.max_v_mps;
    const share = Number(this.speed.value) / 100;
    tell(byId("drive-speed-told"), most ? `${(share * most).toFixed(2)} m/s` : `${this.speed.value} %`);
  }

  #draw() {
    const { state, welcome } = this.model;
    if (this.on && !this.#may) {
      this.off(); // which draws
      return;
    }
    document.body.toggleAttribute("data-hand", this.on);
    this.take.setAttribute("aria-pressed", String(this.on));
    this.take.disabled = !this.#may;
    tell(this.take, this.on ? "Hand back" : "Take over");
    tell(byId("drive-note"), this.#note(state, welcome));
  }

  #note(state, welcome) {
    if (welcome?.can?.teleop === false) return "This robot is not driven from here.";
    if (state?.stopped) return "It is stopped: release it first.";
    if (this.on) return "You drive; the search waits. Keys W A S D, or the stick. Hand back, and it goes on.";
    if (this.#taken || state?.hand) return `Somebody else has the sticks${state.hand ? ` (${state.hand})` : ""}.`;
    return "Taking over pauses the search. Nothing keeps the robot from zones while you drive.";
  }
}

const round = (value) => Math.round(value * 1000) / 1000;
