/** Drawing on the map: a keep-out zone, an area to search in, a place. Corners by taps, or a box by
 * dragging; by keys, at the cross in the middle. */

import { byId, tell, toast } from "./words.js";

const CLOSE_PX = 14;
const MOST_CORNERS = 64;
const SAID = {
  zone: "Tap the corners of where it must not be, or drag a box.",
  area: "Tap the corners of where to search, or drag a box.",
  place: "Tap the place, or Done for where the robot stands.",
};

export class MapTools {
  /** `areaDrawn()` is called when the area to search in is another. */
  constructor(model, link, areaDrawn) {
    Object.assign(this, { model, link, areaDrawn });
    this.kind = null;
    this.corners = [];
    this.byKeys = false;
    this.area = null; // for the next goal
    this.view = null;
    this.buttons = [...document.querySelectorAll("[data-tool]")];
    for (const button of this.buttons) {
      button.addEventListener("click", () => this.choose(button.dataset.tool));
    }
    byId("drawing-done").addEventListener("click", () => this.done());
    byId("drawing-undo").addEventListener("click", () => this.#undo());
    byId("drawing-off").addEventListener("click", () => this.choose(null));
    byId("name-no").addEventListener("click", () => byId("name-ask").close("no"));
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.kind && !byId("name-ask").open) this.choose(null);
    });
  }

  /** What the map draws of it; null while nothing is drawn. */
  get drawing() {
    if (this.kind) return { kind: this.kind, corners: this.corners, cross: this.byKeys };
    return this.area ? { kind: "area", corners: this.area, cross: false } : null;
  }

  choose(kind) {
    const again = kind === this.kind;
    this.kind = again ? null : kind;
    this.corners = [];
    this.byKeys = false;
    if (this.kind === "area" || (kind === "area" && again)) this.#setArea(null);
    this.#draw();
  }

  tap(xy) {
    if (!this.kind) return;
    if (this.kind === "place") {
      this.corners = [xy];
      this.done();
      return;
    }
    const [first] = this.corners;
    const near = first && this.corners.length > 2 &&
      Math.hypot(first[0] - xy[0], first[1] - xy[1]) * this.view.px_m < CLOSE_PX;
    if (near) this.done();
    else if (this.corners.length < MOST_CORNERS) this.corners = [...this.corners, xy];
    this.#draw();
  }

  drag([x0, y0], [x1, y1], ended) {
    if (!this.kind || this.kind === "place" || this.corners.length > 4) return false;
    if (this.corners.length && !this.box) return false; // corners were tapped: the map moves
    this.box = true;
    this.corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
    this.#draw();
    if (ended) {
      this.box = false;
      this.done();
    }
    return true;
  }

  key(key) {
    if (key === "Escape" && this.kind) this.choose(null);
    else if (key === "Enter" && this.kind) {
      this.byKeys = true;
      this.tap([this.view.x_m, this.view.y_m]);
    } else if (key === "d" && this.kind) this.done();
    else if (key === "Backspace" && this.kind) this.#undo();
    else return false;
    return true;
  }

  async done() {
    const { kind, corners } = this;
    if (kind !== "place" && corners.length < 3) {
      tell(byId("drawing-text"), "It takes three corners.");
      return;
    }
    if (kind === "area") {
      this.kind = null;
      this.#setArea(corners);
      toast("The next goal is searched for in there.");
    } else {
      const name = await this.#named(kind, corners);
      if (name) await this.#keep(kind, name, corners);
      this.kind = null;
    }
    this.corners = [];
    this.#draw();
  }

  /** Also when it is searched in: then it is the search's. */
  forgetArea() {
    if (this.area) this.#setArea(null);
    this.#draw();
  }

  #setArea(corners) {
    this.area = corners;
    this.areaDrawn();
  }

  #undo() {
    this.corners = this.corners.slice(0, -1);
    this.#draw();
  }

  #named(kind, corners) {
    const [dialog, input] = [byId("name-ask"), byId("name-input")];
    tell(byId("name-title"), kind === "zone" ? "Name this zone" : "Name this place");
    tell(byId("name-text"), kind === "zone"
      ? "The robot keeps out of it from its next look on."
      : corners.length ? "A point on the map." : "Where the robot stands now, facing as it does.");
    input.value = kind === "zone" ? `zone ${this.model.zones.length + 1}` : "";
    dialog.returnValue = "no";
    dialog.showModal();
    input.select();
    return new Promise((named) => {
      const form = byId("name-form");
      form.onsubmit = () => dialog.close("yes");
      dialog.onclose = () => named(dialog.returnValue === "no" ? "" : input.value.trim());
    });
  }

  async #keep(kind, name, corners) {
    const body = kind === "zone" ? { add: name, polygon: rounded(corners) } : { name };
    if (kind === "place" && corners.length) body.at = [...rounded(corners)[0], 0];
    try {
      const answer = await this.link.ask(kind === "zone" ? "zones" : "places", body);
      toast(answer?.warning ?? (kind === "zone" ? `${name}: it keeps out` : `${name} is on the map`));
    } catch (error) {
      toast(error.message, "bad");
    }
  }

  #draw() {
    for (const button of this.buttons) {
      button.setAttribute("aria-pressed", String(button.dataset.tool === this.kind));
    }
    byId("map").classList.toggle("tool", Boolean(this.kind));
    byId("drawing").hidden = !this.kind;
    const n = this.corners.length;
    const many = n ? ` ${n} corner${n > 1 ? "s" : ""}.` : "";
    if (this.kind) tell(byId("drawing-text"), SAID[this.kind] + many);
    byId("drawing-undo").disabled = !n;
    this.view?.redraw();
  }
}

const rounded = (corners) => corners.map((xy) => xy.map((v) => Math.round(v * 100) / 100));
