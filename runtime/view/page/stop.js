/** Stop: latched, one touch or the space bar away. Asked again until the robot says that it is
 * stopped, and said aloud when it does not. Releasing takes a second, deliberate step. */

import { byId, tell, toast } from "./words.js";

const AGAIN_MS = 400;
const UNCONFIRMED_MS = 1500;
const TOLD_MS = 1000;
const TOUCH_MS = 800; // of which the end is no second touch

export class Stop {
  constructor(model, link) {
    Object.assign(this, { model, link });
    this.button = byId("stop");
    this.dialog = byId("release-ask");
    this.asked_ms = null; // since when a stop is asked for and not confirmed
    this.timer = null;
    this.told_until_ms = 0; // a stop that was answered is shown before the next state tells of it
    this.button.addEventListener("pointerdown", () => {
      if (!this.stopped) this.stop(); // before the finger is lifted
    });
    this.button.addEventListener("click", () => this.#clicked());
    byId("release-no").addEventListener("click", () => this.dialog.close());
    byId("release-yes").addEventListener("click", () => this.#release());
    for (const kind of ["keydown", "keyup"]) {
      window.addEventListener(kind, (event) => this.#space(event), { capture: true });
    }
    model.on("state link", () => this.draw());
  }

  /** As far as the robot says so now: what it said before it was lost may be so no more. */
  get stopped() {
    const said = this.model.link === "ok" && Boolean(this.model.state?.stopped);
    return said || performance.now() < this.told_until_ms;
  }

  /** Whether a stop that was asked for was not confirmed in time. */
  get unconfirmed() {
    return this.asked_ms !== null && performance.now() - this.asked_ms > UNCONFIRMED_MS;
  }

  stop() {
    if (this.dialog.open) this.dialog.close();
    this.asked_ms ??= performance.now();
    this.asked_at_ms = performance.now();
    clearTimeout(this.timer);
    this.#send();
    this.draw();
  }

  #send() {
    this.link.stop().then(
      () => this.#confirmed(),
      () => {}, // it is asked again until it is
    );
    this.timer = setTimeout(() => {
      if (this.asked_ms === null) return;
      this.#send();
      this.draw();
      this.model.changed("stop-asked");
    }, AGAIN_MS);
  }

  #confirmed() {
    this.asked_ms = null;
    this.told_until_ms = performance.now() + TOLD_MS;
    clearTimeout(this.timer);
    this.draw();
    this.model.changed("stop-asked");
  }

  draw() {
    if (this.stopped && this.asked_ms !== null) {
      this.asked_ms = null;
      clearTimeout(this.timer);
    }
    const asked = this.asked_ms !== null;
    const state = this.stopped ? "stopped" : asked ? "asked" : "ready";
    this.button.dataset.state = state;
    const [text, small] = {
      ready: ["Stop", "space bar"],
      asked: [this.unconfirmed ? "NOT confirmed" : "Stopping", "asked again"],
      stopped: ["Stopped", "release …"],
    }[state];
    tell(this.button.querySelector("b"), text);
    tell(this.button.querySelector("small"), small);
    const label = state === "stopped" ? "Stopped. Release the stop" : "Stop the robot";
    if (this.button.getAttribute("aria-label") !== label) this.button.setAttribute("aria-label", label);
  }

  #clicked() {
    const justNow = performance.now() - (this.asked_at_ms ?? -1e9) < TOUCH_MS;
    if (justNow) return; // the touch that stopped it is over
    if (this.stopped) this.dialog.showModal();
    else this.stop(); // by Enter, or a screen reader
  }

  #space(event) {
    if (event.key !== " " || !this.model.live || typing(event.target)) return;
    event.preventDefault(); // it presses no other button
    event.stopPropagation();
    if (event.type === "keydown" && !event.repeat) this.stop();
  }

  async #release() {
    this.dialog.close();
    try {
      await this.link.ask("release");
      this.told_until_ms = 0;
      toast("Released");
    } catch (error) {
      toast(error.message, "bad");
    }
  }
}

const FILLED_IN = ["text", "password", "number", "checkbox"]; // which the space bar is needed for

function typing(target) {
  return (
    target instanceof HTMLSelectElement ||
    (target instanceof HTMLInputElement && FILLED_IN.includes(target.type))
  );
}
