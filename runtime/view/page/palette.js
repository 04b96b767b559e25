/** The colours of the map, of the theme that is on. */

const NAMES = ["unknown", "grid", "free", "wall", "drop", "path", "plan", "frontier", "taken", "zone", "thing", "goal", "place", "belief", "halo"];

export class Palette {
  constructor() {
    this.hues = []; // of the types of room, degrees
    this.#read();
    this.listeners = [];
    for (const query of ["(prefers-color-scheme: dark)", "(prefers-contrast: more)"]) {
      matchMedia(query).addEventListener("change", () => {
        this.#read();
        for (const then of this.listeners) then();
      });
    }
  }

  onChange(then) {
    this.listeners.push(then);
  }

  /** Takes what hue each type of room has, as `rfnav view` tells it. */
  paint(hues) {
    if (String(hues) === String(this.hues)) return;
    this.hues = hues;
    this.#read();
  }

  #read() {
    const style = getComputedStyle(document.documentElement);
    for (const name of NAMES) this[name] = style.getPropertyValue(`--map-${name}`).trim();
    const strength = Number(style.getPropertyValue("--map-tint"));
    const saturation = style.getPropertyValue("--map-tint-saturation").trim();
    const light = style.getPropertyValue("--map-tint-light").trim();
    const [free, wall] = [rgb(this.free), rgb(this.wall)];
    const tints = new Map();
    this.cells = {
      free: word(free),
      wall: word(wall),
      room: (index) => {
        if (this.hues[index] === undefined) return word(free);
        if (!tints.has(index)) {
          const hue = rgb(`hsl(${this.hues[index]} ${saturation} ${light})`);
          tints.set(index, word(free.map((c, i) => c + strength * (hue[i] - c))));
        }
        return tints.get(index);
      },
    };
  }
}

/** Any colour of CSS as three numbers to 255. */
function rgb(colour) {
  const context = new OffscreenCanvas(1, 1).getContext("2d");
  context.fillStyle = colour;
  context.fillRect(0, 0, 1, 1);
  return [...context.getImageData(0, 0, 1, 1).data.slice(0, 3)];
}

/** As a canvas keeps it in memory. */
function word([r, g, b]) {
  const bytes = new Uint8ClampedArray([r, g, b, 255]);
  return new Uint32Array(bytes.buffer)[0];
}
