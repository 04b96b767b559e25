/** The map's tiles: bytes become cells, cells become small pictures that are drawn scaled. */

const HEAD_BYTES = 30; // kind, version, side, epoch, resolution, origin, count
const NO_ROOM = 255;
const UNKNOWN = 0;
const FREE = 1;
const LABEL_CELLS = 160; // of a room in one tile, to be named

export class Tiles {
  /** `changed` is called when there is something new to draw. */
  constructor(changed) {
    this.changed = changed;
    this.tiles = new Map();
    this.epoch = null;
    this.side = 64;
    this.resolution_m = 0.05;
    this.x0_m = this.y0_m = 0;
    this.colours = null;
    this.turn = Promise.resolve(); // inflating is asynchronous; tiles keep their order
  }

  /** What comes next is all there is: another server numbers its maps anew. */
  forget() {
    this.turn = this.turn.then(() => (this.epoch = null));
  }

  /** One that cannot be read is said, and the next is taken all the same. */
  take(bytes) {
    this.turn = this.turn.then(() => this.#take(bytes)).catch((error) => console.error(error));
  }

  async #take(bytes) {
    const view = new DataView(bytes);
    const epoch = view.getUint32(4, true);
    const side = view.getUint16(2, true);
    const count = view.getUint16(28, true);
    const at = [...Array(count).keys()].map((i) => [
      view.getInt32(HEAD_BYTES + 8 * i, true),
      view.getInt32(HEAD_BYTES + 8 * i + 4, true),
    ]);
    const cells = count ? await inflated(bytes.slice(HEAD_BYTES + 8 * count)) : null;
    if (epoch !== this.epoch) this.tiles.clear();
    Object.assign(this, { epoch, side, resolution_m: view.getFloat32(8, true) });
    [this.x0_m, this.y0_m] = [view.getFloat64(12, true), view.getFloat64(20, true)];
    const area = side * side;
    at.forEach(([col, row], i) => {
      const tile = {
        col,
        row,
        cells: cells.subarray(2 * i * area, (2 * i + 1) * area),
        rooms: cells.subarray((2 * i + 1) * area, (2 * i + 2) * area),
        picture: null,
      };
      tile.known = extent(tile.cells, side);
      this.tiles.set(`${col},${row}`, tile);
    });
    this.changed();
  }

  /** Metres of what is known, [x0, y0, x1, y1]; null while nothing is. */
  bounds() {
    let all = null;
    for (const tile of this.tiles.values()) {
      if (!tile.known) continue;
      const [c0, r0, c1, r1] = tile.known;
      const [x0, y0] = this.#corner(tile);
      const r = this.resolution_m;
      const box = [x0 + c0 * r, y0 + r0 * r, x0 + c1 * r, y0 + r1 * r];
      all = all
        ? [Math.min(all[0], box[0]), Math.min(all[1], box[1]), Math.max(all[2], box[2]), Math.max(all[3], box[3])]
        : box;
    }
    return all;
  }

  /** Free and all known cells, in m²: how much of the home is known. */
  area_m2() {
    let free = 0;
    for (const tile of this.tiles.values()) {
      tile.free ??= tile.cells.reduce((n, cell) => n + (cell === FREE), 0);
      free += tile.free;
    }
    return free * this.resolution_m ** 2;
  }

  /** Each [picture, x0, y0, side_m], y0 the lowest y. */
  *pictures(colours) {
    if (colours !== this.colours) {
      this.colours = colours;
      for (const tile of this.tiles.values()) tile.picture = null;
    }
    for (const tile of this.tiles.values()) {
      if (!tile.known) continue;
      tile.picture ??= painted(tile, this.side, colours);
      yield [tile.picture, ...this.#corner(tile), this.side * this.resolution_m];
    }
  }

  /** Where each room's name stands, [index, x, y]: in the tile that has most of it. */
  labels() {
    const best = new Map();
    for (const tile of this.tiles.values()) {
      tile.counts ??= counted(tile, this.side);
      for (const [room, [n, sumCol, sumRow]] of tile.counts) {
        if (n < LABEL_CELLS || n <= (best.get(room)?.n ?? 0)) continue;
        const [x0, y0] = this.#corner(tile);
        const r = this.resolution_m;
        best.set(room, { n, x: x0 + (sumCol / n + 0.5) * r, y: y0 + (sumRow / n + 0.5) * r });
      }
    }
    return [...best].map(([room, { x, y }]) => [room, x, y]);
  }

  #corner({ col, row }) {
    const size_m = this.side * this.resolution_m;
    return [this.x0_m + col * size_m, this.y0_m + row * size_m];
  }
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** [col0, row0, col1, row1] round the cells that are known; null where none is. */
function extent(cells, side) {
  let [c0, r0, c1, r1] = [side, side, 0, 0];
  for (let i = 0; i < cells.length; i++) {
    if (cells[i] === UNKNOWN) continue;
    const [row, col] = [Math.floor(i / side), i % side];
    c0 = Math.min(c0, col);
    c1 = Math.max(c1, col + 1);
    r0 = Math.min(r0, row);
    r1 = Math.max(r1, row + 1);
  }
  return c1 ? [c0, r0, c1, r1] : null;
}

function counted({ cells, rooms }, side) {
  const counts = new Map();
  for (let i = 0; i < cells.length; i++) {
    if (rooms[i] === NO_ROOM || cells[i] !== FREE) continue;
    const sums = counts.get(rooms[i]) ?? [0, 0, 0];
    sums[0] += 1;
    sums[1] += i % side;
    sums[2] += Math.floor(i / side);
    counts.set(rooms[i], sums);
  }
  return counts;
}

/** The tile as a picture, whose first row is its highest y. */
function painted({ cells, rooms }, side, colours) {
  const canvas = new OffscreenCanvas(side, side);
  const context = canvas.getContext("2d");
  const image = context.createImageData(side, side);
  const words = new Uint32Array(image.data.buffer);
  for (let i = 0; i < cells.length; i++) {
    const to = (side - 1 - Math.floor(i / side)) * side + (i % side);
    if (cells[i] === FREE) words[to] = rooms[i] === NO_ROOM ? colours.free : colours.room(rooms[i]);
    else words[to] = cells[i] === UNKNOWN ? 0 : colours.wall;
  }
  context.putImageData(image, 0, 0);
  return canvas;
}
