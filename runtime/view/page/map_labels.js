/** Names on the map that do not cover each other: what matters most is placed first. */

import { FONT } from "./words.js";

const HIGH_PX = 20;
const GAP_PX = 2;
const BESIDE_PX = [[0, 0], [0, -17], [0, 17], [1, 0], [-1, 0], [0, -25], [0, 25]]; // 1: half of the label's width
const BADGE_PX = 12;
const SOFT = 0.8; // how much of a room's name is seen

export class Labels {
  constructor(context, view, halo) {
    Object.assign(this, { context, view, halo });
    this.wanted = [];
    this.kept = []; // boxes that no label may cover
  }

  /** `rank`: higher is placed first; `must`: drawn also where there is no room for it; `soft`: as
   * a room's name; `badge`: on its colour. */
  add(text, at, style) {
    this.wanted.push({ text, at, ...style });
  }

  /** Leaves what is drawn there to be seen. */
  avoid([x, y], radius) {
    this.kept.push([x - radius, y - radius, x + radius, y + radius]);
  }

  draw() {
    const taken = [...this.kept];
    this.wanted.sort((a, b) => b.rank - a.rank);
    const placed = [];
    for (const label of this.wanted) {
      const box = this.#place(label, taken);
      if (!box) continue;
      taken.push(box);
      placed.push([label, box]);
    }
    for (const [label, box] of placed.reverse()) this.#draw(label, box);
  }

  #font({ bold, badge, soft }) {
    const how = soft ? "italic 500" : bold || badge ? "650" : "500";
    this.context.font = `${how} ${soft ? 13.5 : 12.5}px ${FONT}`;
  }

  /** [left, top, right, bottom] px; null where there is no room, or it is out of sight. */
  #place(label, taken) {
    this.#font(label);
    const wide = this.context.measureText(label.text).width + (label.badge ? 16 : 8);
    const [x, y] = label.at;
    if (x < -wide || x > this.view.width + wide || y < -HIGH_PX || y > this.view.height + HIGH_PX) return null;
    for (const [dx, dy] of BESIDE_PX) {
      const [cx, cy] = [x + dx * (wide / 2 + 10), y + dy];
      const box = [cx - wide / 2, cy - HIGH_PX / 2, cx + wide / 2, cy + HIGH_PX / 2];
      if (!taken.some((other) => meet(box, other))) return box;
    }
    return label.must ? [x - wide / 2, y - HIGH_PX / 2, x + wide / 2, y + HIGH_PX / 2] : null;
  }

  #draw(label, [left, top, right, bottom]) {
    const { context } = this;
    this.#font(label);
    context.textAlign = "center";
    context.textBaseline = "middle";
    const [x, y] = [(left + right) / 2, (top + bottom) / 2];
    if (label.badge) {
      context.beginPath();
      context.roundRect(left, y - BADGE_PX, right - left, 2 * BADGE_PX, BADGE_PX);
      context.fillStyle = label.colour;
      context.fill();
      context.lineWidth = 2;
      context.strokeStyle = this.halo;
      context.stroke();
      context.fillStyle = this.halo;
    } else if (label.soft) {
      context.fillStyle = label.colour;
    } else {
      context.lineJoin = "round";
      context.lineWidth = 4;
      context.strokeStyle = this.halo;
      context.strokeText(label.text, x, y + 0.5);
      context.fillStyle = label.colour;
    }
    context.globalAlpha = label.soft ? SOFT : 1;
    context.fillText(label.text, x, y + 0.5);
    context.globalAlpha = 1;
  }
}

const meet = (a, b) =>
  a[0] < b[2] + GAP_PX && b[0] < a[2] + GAP_PX && a[1] < b[3] + GAP_PX && b[1] < a[3] + GAP_PX;
