/** The page: a link, what is known, and who shows what of it. */

import { Ballot } from "./ballot.js";
import { Camera } from "./camera.js";
import { GoalBox } from "./goal_box.js";
import { Hand } from "./hand.js";
import { Headline } from "./headline.js";
import { Health } from "./health.js";
import { Link } from "./link.js";
import { drawMap } from "./map_layers.js";
import { MapTools } from "./map_tools.js";
import { MapView } from "./map_view.js";
import { Model } from "./model.js";
import { Palette } from "./palette.js";
import { Stop } from "./stop.js";
import { Tabs } from "./tabs.js";
import { Things } from "./things.js";
import { Tiles } from "./tiles.js";
import { Timeline } from "./timeline.js";
import { byId } from "./words.js";

const MAP = 1;
const CAMERA = 2;

const model = new Model();
const colours = new Palette();
const camera = new Camera(model, colours);
const link = new Link({
  message: (message) => model.take(message),
  bytes: (bytes) => {
    const kind = new Uint8Array(bytes, 0, 1)[0];
    if (kind === MAP) tiles.take(bytes);
    else if (kind === CAMERA) camera.take(bytes);
  },
  opened: () => {
    tiles.forget();
    model.opened(true);
    watch();
  },
  lost: (why) => model.opened(false, why),
  token: askToken,
});
const stop = new Stop(model, link);
const tools = new MapTools(model, link, () => goals.where(tools.area ? "drawn" : ""));
const goals = new GoalBox(model, link, () => tools.area);
const view = new MapView(byId("map"), {
  draw: (context) => drawMap(context, view, model, tiles, colours, tools.drawing),
  tap: (xy) => tools.tap(xy),
  drag: (from, to, ended) => tools.drag(from, to, ended),
  key: mapKey,
  moved: () => showFollow(),
  pointed: tellPoint,
  resized: () => view.follow && fitAll(),
});
const tiles = new Tiles(mapChanged);
tools.view = view;
new Headline(model, stop);
new Ballot(model);
new Things(model, link, (xy) => view.centre(xy));
new Timeline(model, link, colours);
const health = new Health(model);
new Hand(model, link);
new Tabs((tab) => {
  if (tab === "health") health.draw();
  watch();
});

model.on("state scene zones places past marked welcome link", () => view.redraw());
model.on("marked", () => showMarked());
model.on("scene", () => model.scene.area && tools.area && tools.forgetArea());
colours.onChange(() => view.redraw());
byId("zoom-in").addEventListener("click", () => view.zoom(1.4));
byId("zoom-out").addEventListener("click", () => view.zoom(1 / 1.4));
byId("zoom-all").addEventListener("click", () => fitAll());
byId("follow").addEventListener("click", () => follow(!view.follow));
document.addEventListener("visibilitychange", watch);
link.open();

/** The camera is sent only while it can be seen. */
function watch() {
  const seen = byId("camera").checkVisibility();
  link.send({ kind: "watch", camera: seen && !document.hidden, hidden: document.hidden });
}

function mapChanged() {
  byId("map-empty").hidden = tiles.bounds() !== null;
  if (view.follow) fitAll();
  const known = tiles.area_m2();
  byId("map").setAttribute("aria-label", known ? `Map of the home: ${known.toFixed(0)} square metres of floor are known` : "Map of the home: nothing is known yet");
  view.redraw();
}

function tellPoint(xy) {
  byId("pointed").hidden = !xy;
  if (xy) byId("pointed").textContent = `x ${xy[0].toFixed(2)}, y ${xy[1].toFixed(2)} m`;
}

function fitAll() {
  const bounds = tiles.bounds();
  const top = Math.min(110, view.height / 4); // under what is said of the goal
  const inset = view.width < 600 ? [top, 46, 16, 0] : [top, 100, 40, 40];
  if (bounds) view.fit(bounds, inset);
  view.follow = true;
  showFollow();
}

/** While nobody has moved the map, all that is known stays in sight. */
function follow(on) {
  view.follow = on;
  if (on) fitAll();
  showFollow();
}

function showFollow() {
  byId("follow").setAttribute("aria-pressed", String(view.follow));
}

function mapKey(key) {
  if (tools.key(key)) return true;
  if (key === "0") fitAll();
  else if (key === "f") follow(!view.follow);
  else return false;
  return true;
}

function showMarked() {
  const frontier = model.drawn.frontiers.find((f) => f.id === model.marked)
    ?? model.shown?.frontiers?.find((f) => f.id === model.marked);
  const xy = frontier?.xy ?? frontier?.goal_xy;
  if (!xy) return;
  const [x, y] = view.toScreen(xy);
  if (x < 0 || y < 0 || x > view.width || y > view.height) view.centre(xy);
}

function askToken() {
  const dialog = byId("token-ask");
  byId("token-input").value = "";
  dialog.showModal();
  return new Promise((told) => {
    byId("token-form").onsubmit = () => told(byId("token-input").value);
    dialog.oncancel = (event) => event.preventDefault(); // nothing is shown without
  });
}
