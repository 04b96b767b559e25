/** Why it goes where it goes: who voted for what, in words, and what would have been else. */

import { byId, element, listed, metres, percent, replace, rungSaid, span, whoSaid } from "./words.js";

const SHOWN = 3; // frontiers of one vote, the likeliest

export class Ballot {
  constructor(model) {
    this.model = model;
    this.body = byId("why-body");
    model.on("decision past welcome", () => this.draw());
  }

  draw() {
    const decision = this.model.shown;
    if (!decision?.number) {
      replace(this.body, "none", () => [element("p", { class: "note" }, "Nothing was decided yet.")]);
      return;
    }
    const key = `${decision.goal}/${decision.number}/${decision.heads_for ?? ""}`;
    replace(this.body, key, () => this.#made(decision));
  }

  #made(decision) {
    const parts = [taken(decision)];
    if (decision.votes) {
      parts.push(
        element(
          "div",
          { class: "votes" },
          ...decision.votes.map((vote) => this.#vote(vote, decision)),
          ...(decision.missing ?? []).map(absent),
        ),
      );
      parts.push(otherwise(decision));
    }
    parts.push(inFull(decision));
    return parts;
  }

  #vote(vote, decision) {
    const p = new Map(vote.probabilities);
    const reasons = new Map(vote.reasons);
    const likely = [...vote.frontiers].sort((a, b) => (p.get(b) ?? 0) - (p.get(a) ?? 0) || a - b);
    const took = vote.latency_s == null ? "" : `, ${vote.latency_s.toFixed(2)} s`;
    const rows = likely.slice(0, SHOWN).map((id) => {
      const isTaken = id === decision.frontier;
      return element(
        "li",
        {},
        this.#chip(id, isTaken),
        share(p.get(id), isTaken),
        element("output", {}, p.has(id) ? percent(p.get(id)) : ""),
        reasons.get(id) ? element("p", {}, reasons.get(id)) : null,
      );
    });
    const more = likely.length - SHOWN;
    return element(
      "article",
      { class: "vote" },
      element(
        "header",
        {},
        element("b", {}, whoSaid(vote.expert)),
        element("span", {}, `${rungSaid(vote.rung)}${took}`),
      ),
      reasons.size || !vote.reason ? null : element("p", {}, vote.reason),
      element("ul", { class: "ballots" }, ...rows),
      more > 0 ? element("p", { class: "note" }, `and ${more} less likely`) : null,
      vote.against?.length ? element("p", { class: "note" }, `against ${listed(vote.against.map(String))}`) : null,
    );
  }

  #chip(id, isTaken) {
    return element(
      "button",
      {
        class: "chip",
        type: "button",
        "aria-label": `Frontier ${id}: show it on the map`,
        data: { ...(isTaken ? { taken: "" } : {}), focus: `chip-${id}` },
        onclick: () => this.model.mark(this.model.marked === id ? null : id),
      },
      String(id),
    );
  }
}

function taken(decision) {
  const { frontier } = decision;
  const about = `Decision ${decision.number}, for “${decision.goal}”` +
    (decision.elapsed_s == null ? "" : `, ${span(decision.elapsed_s)} into it`);
  if (frontier == null && decision.votes) {
    return element("p", { class: "elected" }, "No frontier could be reached.", element("small", {}, about));
  }
  if (frontier == null) return element("p", { class: "elected" }, element("small", {}, about));
  const where = decision.frontiers?.find((f) => f.id === frontier);
  const far = where?.distance_m == null ? "" : `, ${metres(where.distance_m)} on foot`;
  const due = decision.why ? ` It was due: ${decision.why}.` : "";
  return element(
    "p",
    { class: "elected" },
    element("strong", {}, `Frontier ${frontier}`),
    `${far}: ${decision.rule_said ?? ""}.`,
    decision.taken ? element("small", {}, `${decision.taken}.`) : null,
    element("small", {}, `${about}.${due}`),
  );
}

function share(p, isTaken) {
  const fill = element("i");
  fill.style.width = percent(p ?? 0).replace(" ", "");
  return element("div", { class: "bar-p", data: isTaken ? { taken: "" } : {} }, fill);
}

function absent({ expert, why, cause, detail }) {
  return element(
    "article",
    { class: "vote none" },
    element("header", {}, element("b", {}, whoSaid(expert)), element("span", {}, "does not vote")),
    element("p", {}, cause || detail || why),
  );
}

function otherwise(decision) {
  const without = Object.entries(decision.without ?? {});
  const changed = without.filter(([, id]) => id != null && id !== decision.frontier);
  const same = without.filter((one) => !changed.includes(one)).map(([expert]) => whoSaid(expert).toLowerCase());
  const rows = changed.map(([expert, id]) => otherwiseRow(`Without ${whoSaid(expert).toLowerCase()}`, `frontier ${id}`));
  if (same.length) {
    rows.push(otherwiseRow(changed.length ? `Without ${same.join(" or ")}` : "Any one expert left out", "the same"));
  }
  if (decision.closest != null) {
    const same = decision.closest === decision.frontier;
    rows.push(otherwiseRow("The closest", same ? "this one" : `frontier ${decision.closest}`));
  }
  if (decision.heads_for != null && decision.heads_for !== decision.frontier) {
    rows.push(otherwiseRow("It was gone when the votes were in", `to ${decision.heads_for}`));
  }
  return rows.length ? element("ul", { class: "else" }, ...rows) : null;
}

function otherwiseRow(what, would) {
  return element("li", {}, element("span", {}, what), element("span", {}, would));
}

function inFull({ full, votes }) {
  if (!full?.length) return "";
  const lines = full.map((line) => element("p", {}, line));
  const given = votes ? {} : { open: true };
  return element("details", given, element("summary", {}, "In full"), ...lines);
}
