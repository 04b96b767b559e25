/** How things are said and numbers written, and the few ways in which elements are made. */

export const WHO = {
  o2f: "Objects near by",
  r2f: "Kind of room",
  sle: "Look of the view",
  both: "Objects and rooms",
};

export const RUNG = {
  local: "model on the robot",
  cloud: "model in the cloud",
  language: "model on the robot, shown the views",
  head: "network taught what lies beyond",
  embedding: "likeness of words",
  counts: "table of counts",
  none: "nobody",
};

const STATE = {
  starting: "Starting: models load",
  ready: "Ready for a goal",
  searching: "Searching",
  driving: "Searching",
  degraded: "Searching with less than it was given",
  paused: "Paused",
  held: "Held",
  stopped: "Stopped",
  fault: "Fault: it ends",
};

const HALT_REMEDY = {
  odometry: "Look whether the base's driver runs.",
  frame: "Look whether the camera's driver runs and the lens is free.",
  plan: "It goes on by itself. If it comes again, see Health for the stage over its budget.",
  jump: "It goes on by itself. If it comes again, the wheels slip or somebody lifts it.",
  clock: "It goes on by itself.",
  base: "Do what the base asks for.",
  wheel: "Set the robot down on the floor.",
  tilt: "Set it upright on level floor.",
  area: "Bring it back by hand.",
  obstacle: "It goes on when that has gone, or round it.",
  floor: "It goes another way.",
  bumper: "It backs off and goes another way.",
  cliff: "It backs off and goes another way.",
};

export const stateSaid = (state) => STATE[state] ?? String(state ?? "");
export const remedy = (cause) => HALT_REMEDY[String(cause).split(":")[0]] ?? "";
export const whoSaid = (expert) => WHO[expert] ?? expert;
export const rungSaid = (rung) => RUNG[rung] ?? rung ?? "";

export const metres = (m) => (m == null ? "–" : `${m.toFixed(m < 10 ? 1 : 0)} m`);
export const percent = (p) => `${Math.round(100 * p)} %`;
export const usd = (amount) => `${(amount ?? 0).toFixed(amount >= 1 ? 2 : 4)} USD`;
export const ms = (value) => (value >= 100 ? value.toFixed(0) : (value ?? 0).toFixed(1));

export function span(s) {
  if (s == null) return "–";
  if (s < 100) return `${s.toFixed(0)} s`;
  if (s < 6000) return `${Math.floor(s / 60)} min ${String(Math.floor(s % 60)).padStart(2, "0")} s`;
  return `${(s / 3600).toFixed(1)} h`;
}

export function listed(words) {
  if (words.length < 2) return words.join("");
  return `${words.slice(0, -1).join(", ")} and ${words.at(-1)}`;
}

export const FONT = "Inter, system-ui, sans-serif";

export const byId = (id) => document.getElementById(id);

/** An element with text and children; what came from elsewhere is text, never markup. */
export function element(name, given = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(given)) {
    if (key === "data") Object.assign(made.dataset, value);
    else if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value != null && value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child != null && child !== ""));
  return made;
}

export function svg(name, given = {}) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(given)) made.setAttribute(key, value);
  return made;
}

/** Sets text only where it differs: a screen reader says again what is set again. */
export function tell(where, text) {
  if (where.textContent !== text) where.textContent = text;
}

/** Puts rows in place of what was there, where they differ: what has the focus keeps it, and what is
 * being pressed is left until it is let go. */
export function replace(where, key, make) {
  if (where.dataset.key === key || where.matches(":active")) return;
  where.dataset.key = key;
  const focused = where.contains(document.activeElement)
    ? document.activeElement.getAttribute("data-focus")
    : null;
  where.replaceChildren(...make().filter((part) => part));
  if (focused) where.querySelector(`[data-focus="${CSS.escape(focused)}"]`)?.focus();
}

/** As a sentence: what a program says begins small and ends anyhow. A name of `topics`, or what can
 * only be one, stays as it is. */
export function sentence(text, topics = []) {
  if (!text) return "";
  const first = text.split(/[ ,:]/, 1)[0];
  const named = /[/_]/.test(first) || topics.includes(first);
  return (named ? text[0] : text[0].toUpperCase()) + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".");
}

export function toast(text, kind = "") {
  const line = element("p", { data: { kind } }, text);
  byId("toasts").append(line);
  setTimeout(() => line.remove(), kind === "bad" ? 7000 : 3500);
}
