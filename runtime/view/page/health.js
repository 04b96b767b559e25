/** How the robot fares: what is wrong, time by stage against its budget, halts, streams, money. */

import { byId, element, ms, replace, rungSaid, span, usd, whoSaid } from "./words.js";

const BUDGET_SHARE = 0.8; // of a meter's width is its budget

export class Health {
  constructor(model) {
    this.model = model;
    model.on("health", () => this.draw());
    model.on("stop", () => this.#halts());
  }

  /** Only while it is looked at: it is worked out once a second. */
  draw() {
    const { health } = this.model;
    if (!health) return;
    const wrong = health.wrong ?? [];
    replace(byId("wrong"), wrong.join("\n"), () => wrong.map((line) => element("li", {}, line)));
    if (document.body.dataset.tab !== "health") return;
    this.#facts(health);
    this.#stages(health.stages ?? {});
    this.#halts();
    this.#streams(health.streams ?? {});
  }

  #facts(health) {
    const { state } = this.model;
    const { money, late_ms: late, view } = health;
    const rungs = Object.entries(health.rungs ?? {});
    const rows = [
      ["Money", money ? `${usd(money.goal_usd)} for this goal, ${usd(money.day_usd)} today` : "no cloud"],
      money ? ["Asked in the cloud", `${money.calls} times, ${money.model}`] : null,
      ["Battery", state?.battery == null ? "not told" : `${state.battery.toFixed(0)} %`],
      late ? ["Control late by", `${ms(late.p50)} ms, 99 % ${ms(late.p99)}, most ${ms(late.max)}`] : null,
      ...rungs.map(([expert, rung]) => [whoSaid(expert), rungSaid(rung)]),
      ["Memory", `${health.memory_mb?.toFixed(0) ?? "–"} MB, up ${span(health.up_s)}`],
      view ? ["This page's server", `${view.memory_mb.toFixed(0)} MB, ${(100 * view.cpu_share).toFixed(0)} % of a core`] : null,
    ].filter(Boolean);
    replace(byId("facts"), JSON.stringify(rows), () =>
      rows.flatMap(([name, told]) => [element("dt", {}, name), element("dd", {}, told)]),
    );
  }

  #stages(stages) {
    replace(byId("stages"), JSON.stringify(stages), () =>
      Object.entries(stages).map(([name, told]) => {
        const over = told.budget_ms && told.p99_ms > told.budget_ms;
        const figures = `${ms(told.p99_ms)}${told.budget_ms ? ` of ${told.budget_ms}` : ""}`;
        return element(
          "tr",
          {},
          element("th", { scope: "row" }, name),
          element("td", {}, meter(told, over)),
          element("td", { class: over ? "over" : null, title: `over ${told.over} times` }, figures),
        );
      }),
    );
  }

  #halts() {
    const counted = Object.entries(this.model.health?.halts ?? {});
    const { stop } = this.model;
    const key = JSON.stringify([counted, stop?.number, stop?.over]);
    replace(byId("halts"), key, () => {
      const rows = counted.map(([kind, n]) =>
        element("li", {}, element("span", {}, kind), element("output", {}, `${n} times`)),
      );
      if (stop?.in_words) {
        const words = stop.in_words.map((line) => element("small", {}, line));
        rows.unshift(element("li", {}, element("span", {}, stop.over ? "The last one" : "Now", ...words)));
      }
      return rows.length ? rows : [element("li", { class: "none" }, "none since the start")];
    });
  }

  #streams(streams) {
    replace(byId("streams"), JSON.stringify(streams), () =>
      Object.entries(streams).map(([topic, told]) => {
        const age = told.age_s == null ? "never came" : `${told.age_s.toFixed(1)} s old`;
        const bad = told.bad ? `, ${told.bad} not usable` : "";
        const rate = told.per_s == null ? "" : `${told.per_s.toFixed(1)} a second, `;
        return element("li", {}, element("span", {}, topic), element("output", {}, `${rate}${age}${bad}`));
      }),
    );
  }
}

function meter({ p50_ms, p99_ms, budget_ms }, over) {
  const share = (value) => (budget_ms ? Math.min(1, (BUDGET_SHARE * value) / budget_ms) : 0);
  const [long, short] = [element("i"), element("i")];
  long.style.width = `${100 * share(p99_ms)}%`;
  short.style.width = `${100 * share(p50_ms)}%`;
  return element("div", { class: "meter", "aria-hidden": "true", data: over ? { over: "" } : {} }, long, short);
}
