/** What the camera sees, with boxes round what the detectors saw in it. */

import { FONT, byId, percent, span, tell } from "./words.js";

const HEAD_BYTES = 14;
const BOX_PX = 2.5;
const OLD_S = 3; // after which a picture is not of now

export class Camera {
  constructor(model, colours) {
    Object.assign(this, { model, colours });
    this.canvas = byId("camera-picture");
    this.note = byId("camera-note");
    this.picture = null;
    this.busy = false;
    model.on("boxes", () => this.draw());
    setInterval(() => this.#age(), 1000);
  }

  /** A JPEG with its header; one that comes while another is decoded is left out. */
  async take(bytes) {
    if (this.busy) return;
    this.busy = true;
    try {
      const jpeg = new Blob([bytes.slice(HEAD_BYTES)], { type: "image/jpeg" });
      const picture = await createImageBitmap(jpeg);
      this.picture?.close();
      this.picture = picture;
      this.came_ms = performance.now();
      this.#age();
      this.draw();
    } finally {
      this.busy = false;
    }
  }

  draw() {
    const { picture, canvas } = this;
    if (!picture) return;
    [canvas.width, canvas.height] = [picture.width, picture.height];
    const context = canvas.getContext("2d");
    context.drawImage(picture, 0, 0);
    const boxes = this.model.freshBoxes;
    if (boxes) this.#boxes(context, boxes, picture.width / boxes.width);
    const seen = boxes?.boxes.map((b) => b.name) ?? [];
    const what = seen.length ? `What the camera sees: ${[...new Set(seen)].join(", ")}` : "What the camera sees";
    if (canvas.getAttribute("aria-label") !== what) canvas.setAttribute("aria-label", what);
  }

  /** A picture that stands still looks like one of now. */
  #age() {
    if (!this.picture) return;
    const old_s = this.model.live ? (performance.now() - this.came_ms) / 1000 : 0;
    tell(this.note, old_s < OLD_S ? "" : `This picture is ${span(old_s)} old.`);
  }

  #boxes(context, { boxes }, scale) {
    context.font = `600 13px ${FONT}`;
    context.textBaseline = "middle";
    for (const box of [...boxes].sort((a, b) => a.goal - b.goal)) {
      const [x, y, w, h] = [box.x, box.y, box.w, box.h].map((v) => v * scale);
      const colour = box.goal ? "#6fe08e" : "#ffffff";
      context.lineWidth = box.goal ? BOX_PX + 1 : BOX_PX;
      context.strokeStyle = "#000000a0";
      context.strokeRect(x - 1, y - 1, w + 2, h + 2);
      context.strokeStyle = colour;
      context.strokeRect(x, y, w, h);
      const text = `${box.name} ${percent(box.score)}`;
      const wide = context.measureText(text).width + 10;
      const left = Math.max(0, Math.min(x, context.canvas.width - wide));
      const top = y > 20 ? y - 20 : y;
      context.fillStyle = colour;
      context.fillRect(left, top, wide, 20);
      context.fillStyle = "#0b0d10";
      context.fillText(text, left + 5, top + 10.5);
    }
  }
}
