/** Asks for a goal, pauses and cancels it. */

import { byId, element, replace, tell, toast } from "./words.js";

const NAMES_SHOWN = 300;

export class GoalBox {
  /** `area()` is the polygon that was drawn to search in, or null. */
  constructor(model, link, area) {
    Object.assign(this, { model, link, area });
    byId("goal").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#ask();
    });
    byId("goal-more").addEventListener("click", () => this.options(byId("goal-options").hidden));
    byId("goal").addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.options(false);
    });
    document.addEventListener("pointerdown", (event) => {
      if (!byId("goal").contains(event.target)) this.options(false);
    });
    byId("pause").addEventListener("click", () => {
      const paused = Boolean(this.model.state?.goal?.paused);
      this.#do(paused ? "resume" : "pause", {}, paused ? "It goes on" : "Paused");
    });
    byId("cancel").addEventListener("click", () => this.#do("cancel", {}, "Cancelled"));
    model.on("names", () => this.#names());
    model.on("state link", () => this.#keys());
    model.on("scene", () => this.where());
  }

  options(open) {
    byId("goal-options").hidden = !open;
    byId("goal-more").setAttribute("aria-expanded", String(open));
  }

  /** The places where a search may be bound to. */
  where(choose) {
    const { things, rooms: types } = this.model.scene;
    const rooms = [...new Set([...types, ...things.map((t) => t.room)].filter(Boolean))].sort();
    const places = this.model.places.filter((p) => p.xy).map((p) => p.name);
    const drawn = this.area() ? [["drawn", "the area that is drawn"]] : [];
    const choices = [
      ["", "anywhere"],
      ...drawn,
      ...rooms.map((r) => [`room ${r}`, `in the ${r}`]),
      ...places.map((p) => [`place ${p}`, `about ${p}`]),
    ];
    const select = byId("goal-where");
    const before = choose ?? select.value;
    replace(select, JSON.stringify(choices), () =>
      choices.map(([value, said]) => element("option", { value }, said)),
    );
    select.value = choices.some(([value]) => value === before) ? before : "";
  }

  async #ask() {
    const field = byId("goal-text");
    const text = field.value.trim();
    if (!text) {
      field.focus();
      return;
    }
    const body = { goal: text, ...this.#options() };
    byId("goal-go").disabled = true;
    try {
      const answer = await this.link.ask("goal", body);
      const waits = answer.queued ? `, after ${answer.queued} before it` : "";
      toast(`${answer.how ?? text}${waits}`);
      field.value = "";
      field.blur();
      this.options(false);
    } catch (error) {
      toast(error.message, "bad");
    } finally {
      byId("goal-go").disabled = false;
    }
  }

  #options() {
    const body = {};
    const minutes = Number(byId("goal-minutes").value);
    if (minutes > 0) body.limits = { time_s: 60 * minutes };
    if (byId("goal-return").checked) body.afterwards = "return";
    if (byId("goal-queue").checked) body.if_busy = "queue";
    const where = byId("goal-where").value;
    const [kind, ...rest] = where.split(" ");
    if (kind === "drawn") body.area = { polygon: this.area() };
    else if (kind) body.area = { [kind]: rest.join(" ") };
    return body;
  }

  #names() {
    const names = this.model.names.slice(0, NAMES_SHOWN);
    replace(byId("names"), names.join(), () => names.map((value) => element("option", { value })));
  }

  #keys() {
    const { state } = this.model;
    const can = ["ok", "silent"].includes(this.model.link) && Boolean(state?.goal);
    byId("pause").disabled = byId("cancel").disabled = !can;
    const paused = Boolean(state?.goal?.paused);
    tell(byId("pause"), paused ? "Go on" : "Pause");
    tell(byId("cancel"), state?.queue?.length ? "Cancel all" : "Cancel");
    byId("pause").setAttribute("aria-pressed", String(paused));
  }

  async #do(what, body, said) {
    try {
      await this.link.ask(what, body);
      toast(said);
    } catch (error) {
      toast(error.message, "bad");
    }
  }
}
