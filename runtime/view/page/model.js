/** What the page knows: the newest of each kind, and who wants to hear of it. It draws nothing. */

const FADE_MS = 1500; // boxes are of an image that is some tenths of a second old

export class Model {
  constructor() {
    this.welcome = null;
    this.state = null;
    this.scene = { frontiers: [], things: [], plan: [], path: [], area: null, rooms: [], hues: [], belief: [] };
    this.zones = [];
    this.bound = true;
    this.places = [];
    this.names = [];
    this.health = null;
    this.boxes = null;
    this.decision = null; // the newest
    this.past = null; // the one that is looked at in its place
    this.stop = null;
    this.timeline = { goal: "", decisions: [], stops: [] };
    this.span = null;
    this.at = null;
    this.open = false; // the way to `rfnav view`
    this.sentAway = "";
    this.heard_ms = 0; // when the last message came, by this computer's clock
    this.lastState_ms = 0;
    this.marked = null; // the id of a frontier that is pointed at
    this.wanted = new Map();
  }

  /** Calls `then` after each message of these kinds. */
  on(kinds, then) {
    for (const kind of kinds.split(" ")) {
      if (!this.wanted.has(kind)) this.wanted.set(kind, []);
      this.wanted.get(kind).push(then);
    }
  }

  changed(kind) {
    for (const then of this.wanted.get(kind) ?? []) then();
  }

  take(message) {
    const { kind } = message;
    this.heard_ms = performance.now();
    if (kind === "state") this.#state(message);
    else if (kind === "scene") this.scene = { ...this.scene, ...message };
    else if (kind === "zones") [this.zones, this.bound] = [message.zones, message.bound];
    else if (kind === "places") this.places = message.places;
    else if (kind === "names") this.names = message.names;
    else if (kind === "boxes") this.boxes = { ...message, came_ms: this.heard_ms };
    else if (kind === "welcome") this.#welcome(message);
    else if (["health", "decision", "stop", "timeline", "span", "at"].includes(kind)) {
      this[kind] = message;
    } else return;
    this.changed(kind);
  }

  /** `why`: what the server said when it sent this page away, "" for nothing. */
  opened(open, why = "") {
    [this.open, this.sentAway] = [open, why];
    this.changed("link");
  }

  look(past) {
    this.past = past;
    this.changed("past");
  }

  mark(id) {
    this.marked = id;
    this.changed("marked");
  }

  // -- what follows from it ---------------------------------------------------------------------

  get live() {
    return this.welcome?.mode !== "replay";
  }

  /** The decision that is shown. */
  get shown() {
    return this.past ?? this.decision;
  }

  /** What the map is drawn of: as it was, where that is known of a past decision. */
  get drawn() {
    const { past, scene } = this;
    return past?.scene ? { ...scene, ...past.scene, belief: past.belief ?? [] } : scene;
  }

  /** "none" before anything came; "lost": no way to the service; "silent": it says nothing. */
  get link() {
    if (!this.welcome) return this.open ? "none" : "lost";
    if (!this.open) return "lost";
    if (!this.live) return "ok";
    if (!this.state) return "none";
    return { ok: "ok", silent: "silent" }[this.state.link] ?? "lost";
  }

  /** Seconds since the newest of what is shown. */
  get age_s() {
    if (!this.state) return null;
    return (this.state.age_s ?? 0) + (performance.now() - this.lastState_ms) / 1000;
  }

  get freshBoxes() {
    return this.boxes && performance.now() - this.boxes.came_ms < FADE_MS ? this.boxes : null;
  }

  #state(message) {
    this.state = message;
    this.lastState_ms = this.heard_ms;
  }

  #welcome(message) {
    this.welcome = message;
    this.past = null;
  }
}
