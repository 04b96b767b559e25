/** The map's window: where it looks, how it is moved, when it is drawn. Metres, y up, to pixels. */

const ZOOM = 1.25;
const LEAST_PX_M = 6;
const MOST_PX_M = 400;
const FIRST_PX_M = 60;
const LEAST_M = 5; // seen at once, however little is known
const PAN_PX = 60;
const MARGIN_PX = 24;
const TAP_PX = 7;

export class MapView {
  /** `draw(context)` paints; `tap(xy)`, `drag(from, to, ended)` and `key(key)` are a tool's: true
   * when it took them; `moved`, `resized` and `pointed(xy)`, null off the map, are told. */
  constructor(canvas, { draw, tap, drag, key, moved, resized, pointed }) {
    Object.assign(this, { canvas, draw, tap, drag, key, moved, resized, pointed });
    [this.width, this.height, this.ratio] = [0, 0, 1]; // px, until it is laid out
    [this.x_m, this.y_m, this.px_m] = [0, 0, FIRST_PX_M];
    this.follow = true; // keeps all of what is known, or the robot, in sight
    this.pointers = new Map();
    this.due = false;
    new ResizeObserver(() => this.#resize()).observe(canvas);
    canvas.addEventListener("pointerdown", (e) => this.#down(e));
    canvas.addEventListener("pointermove", (e) => this.#move(e));
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (e) => this.#up(e, end === "pointerup"));
    }
    canvas.addEventListener("pointerleave", () => this.pointed(null));
    canvas.addEventListener("wheel", (e) => this.#wheel(e), { passive: false });
    canvas.addEventListener("keydown", (e) => this.#keyed(e));
  }

  redraw() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      if (!this.width) return;
      const context = this.canvas.getContext("2d");
      context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
      this.draw(context, this);
    });
  }

  toScreen([x, y]) {
    return [this.width / 2 + (x - this.x_m) * this.px_m, this.height / 2 - (y - this.y_m) * this.px_m];
  }

  toMap([x, y]) {
    return [this.x_m + (x - this.width / 2) / this.px_m, this.y_m - (y - this.height / 2) / this.px_m];
  }

  /** All of [x0, y0, x1, y1] in sight, clear of `inset` [top, right, bottom, left] px. */
  fit([x0, y0, x1, y1], inset = [0, 0, 0, 0]) {
    const [top, right, bottom, left] = inset;
    const wide = Math.max(80, this.width - left - right - 2 * MARGIN_PX);
    const high = Math.max(80, this.height - top - bottom - 2 * MARGIN_PX);
    const px_m = Math.min(wide / Math.max(x1 - x0, LEAST_M), high / Math.max(y1 - y0, LEAST_M));
    this.px_m = clamp(px_m);
    this.x_m = (x0 + x1) / 2 + (right - left) / 2 / this.px_m;
    this.y_m = (y0 + y1) / 2 - (bottom - top) / 2 / this.px_m;
    this.redraw();
  }

  centre([x, y]) {
    [this.x_m, this.y_m] = [x, y];
    this.#own();
  }

  zoom(factor, about = [this.width / 2, this.height / 2]) {
    const [x, y] = this.toMap(about);
    this.px_m = clamp(this.px_m * factor);
    const [nowX, nowY] = this.toMap(about);
    this.x_m += x - nowX;
    this.y_m += y - nowY;
    this.#own();
  }

  #own() {
    this.follow = false;
    this.moved();
    this.redraw();
  }

  #resize() {
    const box = this.canvas.getBoundingClientRect();
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    [this.width, this.height] = [box.width, box.height];
    this.canvas.width = Math.max(1, Math.round(box.width * this.ratio));
    this.canvas.height = Math.max(1, Math.round(box.height * this.ratio));
    this.resized();
    this.redraw();
  }

  #at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.#at(event);
    this.pointers.set(event.pointerId, { from: at, at, far: false });
    if (this.pointers.size > 1) for (const pointer of this.pointers.values()) pointer.far = true;
  }

  #move(event) {
    const pointer = this.pointers.get(event.pointerId);
    if (event.pointerType === "mouse") this.pointed(this.toMap(this.#at(event)));
    if (!pointer) return;
    const [was, at] = [pointer.at, this.#at(event)];
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId);
    pointer.at = at;
    if (others.length) {
      const about = others[0][1].at;
      this.#pan(at[0] - was[0], at[1] - was[1], 0.5);
      this.zoom(distance(at, about) / Math.max(1, distance(was, about)), about);
      return;
    }
    pointer.far ||= distance(pointer.from, at) > TAP_PX;
    if (!pointer.far) return;
    if (this.drag(this.toMap(pointer.from), this.toMap(at), false)) return;
    this.canvas.classList.add("dragging");
    this.#pan(at[0] - was[0], at[1] - was[1]);
  }

  #up(event, meant) {
    const pointer = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    this.canvas.classList.remove("dragging");
    if (!pointer || !meant) return;
    if (!pointer.far) this.tap(this.toMap(pointer.at), pointer.at);
    else if (!this.pointers.size) this.drag(this.toMap(pointer.from), this.toMap(pointer.at), true);
  }

  #pan(dx, dy, share = 1) {
    this.x_m -= (share * dx) / this.px_m;
    this.y_m += (share * dy) / this.px_m;
    this.#own();
  }

  #wheel(event) {
    event.preventDefault();
    this.zoom(ZOOM ** (-Math.sign(event.deltaY) * Math.min(1, Math.abs(event.deltaY) / 60)), this.#at(event));
  }

  #keyed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const moves = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (moves[event.key]) {
      const [x, y] = moves[event.key];
      this.#pan(x * PAN_PX, y * PAN_PX);
    } else if (event.key === "+" || event.key === "=") this.zoom(ZOOM);
    else if (event.key === "-") this.zoom(1 / ZOOM);
    else if (!this.key(event.key)) return;
    event.preventDefault();
  }
}

const clamp = (px_m) => Math.min(MOST_PX_M, Math.max(LEAST_PX_M, px_m));
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
