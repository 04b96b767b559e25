/** What lies on the map, from the floor up: cells, belief, zones, paths, frontiers, things, the
 * robot. Pure drawing: a context, a view and a model. */

import { FONT, metres, percent } from "./words.js";
import { Labels } from "./map_labels.js";

const BAR_M = [0.5, 1, 2, 5, 10, 20];
const BAR_PX = 90;
const SURE = 0.35; // things at least so sure are drawn
const FULL_TURN = 2 * Math.PI;

export function drawMap(context, view, model, tiles, colours, drawing) {
  const { width, height } = view;
  const scene = model.drawn;
  colours.paint(scene.hues);
  context.fillStyle = colours.unknown;
  context.fillRect(0, 0, width, height);
  grid(context, view, colours);
  cells(context, view, tiles, colours);
  const labels = new Labels(context, view, colours.halo);
  rooms(view, tiles, scene.rooms, colours, labels);
  const { target: goes, pose } = model.past ? {} : (model.state ?? {});
  if (goes) labels.avoid(view.toScreen(goes), 12);
  if (pose) labels.avoid(view.toScreen(pose), 10);
  for (const one of scene.belief ?? []) expected(context, view, one, colours);
  if (scene.area) area(context, view, scene.area, colours);
  for (const zone of model.zones) keepOut(context, view, zone, colours, labels);
  line(context, view, scene.path, colours.path, 2.5, [], 0.55);
  line(context, view, scene.plan, colours.plan, 2.5, [2, 6]);
  const going = model.past ?? (model.state?.goal ? model.state : null);
  const taken = going?.frontier ?? null;
  for (const frontier of frontiersOf(model, scene)) {
    const is = { taken: frontier.id === taken, marked: frontier.id === model.marked };
    edge(context, view, frontier, is, colours, labels);
  }
  for (const place of model.places) if (place.xy) named(context, view, place, colours, labels);
  const things = scene.things.filter((t) => t.goal || t.confidence >= SURE);
  things.sort((a, b) => b.goal - a.goal || b.confidence - a.confidence);
  for (const thing of things) object(context, view, thing, colours, labels);
  if (goes) target(context, view, goes, colours);
  if (pose) robot(context, view, model, colours);
  labels.draw();
  if (drawing) outline(context, view, drawing, colours);
  scaleBar(context, view, colours);
}

/** Those of now, or those that a past decision was made on. */
function frontiersOf(model, scene) {
  const { past } = model;
  if (!past?.frontiers || past.scene) return scene.frontiers;
  return past.frontiers.map((f) => ({ ...f, xy: f.goal_xy, cells: null }));
}

function grid(context, view, colours) {
  const step = view.px_m < 14 ? 5 : 1;
  const [left, top] = view.toMap([0, 0]);
  const [right, bottom] = view.toMap([view.width, view.height]);
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
  context.beginPath();
  for (let x = Math.ceil(left / step) * step; x <= right; x += step) {
    const at = Math.round(view.toScreen([x, 0])[0]) + 0.5;
    context.moveTo(at, 0);
    context.lineTo(at, view.height);
  }
  for (let y = Math.ceil(bottom / step) * step; y <= top; y += step) {
    const at = Math.round(view.toScreen([0, y])[1]) + 0.5;
    context.moveTo(0, at);
    context.lineTo(view.width, at);
  }
  context.stroke();
}

function cells(context, view, tiles, colours) {
  context.imageSmoothingEnabled = tiles.resolution_m * view.px_m < 2;
  for (const [picture, x, y, size] of tiles.pictures(colours.cells)) {
    const [left, bottom] = view.toScreen([x, y]).map(Math.round);
    const [right, top] = view.toScreen([x + size, y + size]).map(Math.round);
    if (right < 0 || left > view.width || bottom < 0 || top > view.height) continue;
    context.drawImage(picture, left, top, right - left, bottom - top);
  }
}

function rooms(view, tiles, names, colours, labels) {
  const style = { colour: colours.thing, rank: 0.5, soft: true };
  for (const [index, x, y] of tiles.labels()) {
    if (names[index]) labels.add(names[index], view.toScreen([x, y]), style);
  }
}

function expected(context, view, { xy, p }, colours) {
  if (!xy || p < 0.02) return;
  const at = view.toScreen(xy);
  const radius = view.px_m * (0.25 + 0.9 * Math.sqrt(p));
  const glow = context.createRadialGradient(...at, 0, ...at, radius);
  glow.addColorStop(0, mixed(colours.belief, 0.25 + 0.35 * Math.min(1, 2 * p)));
  glow.addColorStop(1, mixed(colours.belief, 0));
  context.fillStyle = glow;
  disc(context, at, radius);
  context.fill();
}

function area(context, view, polygon, colours) {
  context.save();
  context.beginPath();
  context.rect(0, 0, view.width, view.height);
  trace(context, view, polygon, true);
  context.fillStyle = mixed(colours.unknown, 0.55);
  context.fill("evenodd");
  context.restore();
  context.beginPath();
  trace(context, view, polygon, true);
  stroke(context, colours.path, 2, [8, 5]);
}

function keepOut(context, view, { name, polygon }, colours, labels) {
  context.save();
  context.beginPath();
  trace(context, view, polygon, true);
  context.fillStyle = mixed(colours.zone, 0.12);
  context.fill();
  stroke(context, colours.zone, 2);
  context.clip();
  hatch(context, view, polygon, mixed(colours.zone, 0.45));
  context.restore();
  labels.add(name, view.toScreen(middle(polygon)), { colour: colours.zone, rank: 2, must: true });
}

function hatch(context, view, polygon, colour) {
  const points = polygon.map((xy) => view.toScreen(xy));
  const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
  const [left, right] = [Math.max(0, Math.min(...xs)), Math.min(view.width, Math.max(...xs))];
  const [top, bottom] = [Math.max(0, Math.min(...ys)), Math.min(view.height, Math.max(...ys))];
  const high = bottom - top;
  if (high <= 0 || right <= left) return;
  context.beginPath();
  for (let x = left - high - ((left - high) % 10); x < right; x += 10) {
    context.moveTo(x, bottom);
    context.lineTo(x + high, top);
  }
  stroke(context, colour, 1);
}

function edge(context, view, frontier, { taken, marked }, colours, labels) {
  const reachable = frontier.distance_m != null;
  const colour = taken ? colours.taken : colours.frontier;
  context.globalAlpha = reachable ? 1 : 0.4;
  context.fillStyle = colour;
  const size = Math.max(3, Math.min(8, view.px_m * 0.07));
  for (const cell of frontier.cells ?? []) {
    const [x, y] = view.toScreen(cell);
    context.fillRect(x - size / 2, y - size / 2, size, size);
  }
  context.globalAlpha = 1;
  const at = view.toScreen(middleDot(frontier));
  if (marked) {
    disc(context, at, 19);
    stroke(context, colour, 3);
  }
  const style = { colour, badge: taken || marked, rank: taken || marked ? 6 : 3, must: taken };
  if (reachable || taken || marked) labels.add(String(frontier.id), at, style);
}

/** That dot of a frontier that is nearest to their middle; where it is driven to, without dots. */
function middleDot({ cells, xy }) {
  if (!cells?.length) return xy;
  const [x, y] = middle(cells);
  const away = cells.map((cell) => Math.hypot(cell[0] - x, cell[1] - y));
  return cells[away.indexOf(Math.min(...away))];
}

function named(context, view, { name, xy }, colours, labels) {
  const [x, y] = view.toScreen(xy);
  context.beginPath();
  context.moveTo(x, y);
  context.bezierCurveTo(x - 4, y - 8, x - 8, y - 10, x - 8, y - 15);
  context.arc(x, y - 15, 8, Math.PI, 0);
  context.bezierCurveTo(x + 8, y - 10, x + 4, y - 8, x, y);
  context.fillStyle = colours.place;
  context.fill();
  stroke(context, colours.halo, 1.5);
  disc(context, [x, y - 15], 3);
  context.fillStyle = colours.halo;
  context.fill();
  labels.add(name, [x, y + 10], { colour: colours.place, rank: 4 });
}

function object(context, view, thing, colours, labels) {
  const colour = thing.goal ? colours.goal : colours.thing;
  const [x, y] = view.toScreen(thing.xy);
  const [w, h] = (thing.size ?? [0.1, 0.1]).map((m) => Math.max(5, m * view.px_m));
  context.beginPath();
  context.roundRect(x - w / 2, y - h / 2, w, h, Math.min(4, w / 3, h / 3));
  context.fillStyle = mixed(colours.halo, 0.62); // furniture is lighter than walls
  context.fill();
  context.fillStyle = mixed(colour, thing.goal ? 0.35 : 0.2);
  context.fill();
  stroke(context, mixed(colour, 0.3 + 0.6 * thing.confidence), thing.goal ? 2 : 1);
  const sure = thing.confidence < 0.995 ? ` ${percent(thing.confidence)}` : "";
  const style = { colour, rank: thing.goal ? 7 : 1 + thing.confidence, bold: thing.goal };
  labels.add(thing.name + sure, [x, y], style);
}

function target(context, view, xy, colours) {
  const [x, y] = view.toScreen(xy);
  context.beginPath();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    context.moveTo(x + 5 * dx, y + 5 * dy);
    context.lineTo(x + 15 * dx, y + 15 * dy);
  }
  context.moveTo(x + 10, y);
  context.arc(x, y, 10, 0, FULL_TURN);
  context.lineCap = "round";
  stroke(context, colours.halo, 5);
  context.lineCap = "round";
  stroke(context, colours.taken, 2.5);
}

function robot(context, view, model, colours) {
  const [x_m, y_m, yaw] = model.state.pose;
  const at = view.toScreen([x_m, y_m]);
  const radius = Math.max(9, (model.welcome?.robot?.radius_m ?? 0.18) * view.px_m);
  disc(context, at, radius + 2);
  context.fillStyle = colours.halo;
  context.fill();
  disc(context, at, radius);
  context.fillStyle = colours.path;
  context.fill();
  context.save();
  context.translate(...at);
  context.rotate(-yaw);
  context.beginPath();
  context.moveTo(radius * 0.72, 0);
  context.lineTo(-radius * 0.5, radius * 0.55);
  context.lineTo(-radius * 0.22, 0);
  context.lineTo(-radius * 0.5, -radius * 0.55);
  context.closePath();
  context.fillStyle = colours.halo;
  context.fill();
  context.restore();
}

/** What is being drawn: {corners, closed, colour, cross}. */
function outline(context, view, { corners, kind, cross }, colours) {
  const colour = kind === "zone" ? colours.zone : kind === "place" ? colours.place : colours.path;
  if (corners.length) {
    context.beginPath();
    trace(context, view, corners, corners.length > 2);
    context.fillStyle = mixed(colour, 0.16);
    context.fill();
    stroke(context, colour, 2, [6, 4]);
    for (const corner of corners) {
      disc(context, view.toScreen(corner), 5);
      context.fillStyle = colour;
      context.fill();
      stroke(context, colours.halo, 2);
    }
  }
  if (!cross) return;
  const [x, y] = [view.width / 2, view.height / 2];
  context.beginPath();
  context.moveTo(x - 12, y);
  context.lineTo(x + 12, y);
  context.moveTo(x, y - 12);
  context.lineTo(x, y + 12);
  stroke(context, colour, 2);
}

function scaleBar(context, view, colours) {
  const bar_m = BAR_M.find((m) => m * view.px_m >= BAR_PX / 2) ?? BAR_M.at(-1);
  const [x, y, wide] = [16.5, view.height - 18.5, bar_m * view.px_m];
  context.beginPath();
  context.moveTo(x, y - 5);
  context.lineTo(x, y);
  context.lineTo(x + wide, y);
  context.lineTo(x + wide, y - 5);
  stroke(context, colours.thing, 1.5);
  context.font = `500 12px ${FONT}`;
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.fillStyle = colours.thing;
  context.fillText(bar_m < 1 ? `${bar_m} m` : metres(bar_m).replace(".0", ""), x + 5, y - 4);
}

function line(context, view, points, colour, width, dash, alpha = 1) {
  if (!points || points.length < 2) return;
  context.globalAlpha = alpha;
  context.lineJoin = context.lineCap = "round";
  context.beginPath();
  trace(context, view, points, false);
  stroke(context, colour, width, dash);
  context.globalAlpha = 1;
}

function trace(context, view, points, close) {
  points.forEach((xy, i) => context[i ? "lineTo" : "moveTo"](...view.toScreen(xy)));
  if (close) context.closePath();
}

function stroke(context, colour, width, dash = []) {
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
}

function disc(context, at, radius) {
  context.beginPath();
  context.arc(...at, radius, 0, FULL_TURN);
}

/** `#rrggbb`, seen through. */
const mixed = (colour, share) => colour + Math.round(255 * share).toString(16).padStart(2, "0");

function middle(polygon) {
  const sum = polygon.reduce(([x, y], p) => [x + p[0], y + p[1]], [0, 0]);
  return sum.map((v) => v / polygon.length);
}
