/** What the map shows, as lists: for who cannot see the map, and to go to, show or remove. */

import { byId, element, percent, replace, toast } from "./words.js";

export class Things {
  /** `show(xy)` puts a point of the map in the middle. */
  constructor(model, link, show) {
    Object.assign(this, { model, link, show });
    model.on("scene past", () => this.#scene());
    model.on("zones", () => this.#zones());
    model.on("places state", () => this.#places());
    model.on("state", () => this.#queue());
  }

  #queue() {
    const can = Boolean(this.model.welcome?.can?.command);
    const queue = this.model.state.queue ?? [];
    replace(byId("queue-list"), JSON.stringify([queue, can]), () =>
      queue.map(({ id, goal }) =>
        element(
          "li",
          {},
          element("span", {}, goal),
          can && id ? this.#button("Cancel", `Cancel ${goal}, which waits`, `q${id}`, () => this.#do("cancel", { id }, `${goal} is not looked for`)) : null,
        ),
      ),
    );
    byId("queue").hidden = !queue.length;
  }

  #scene() {
    const { things, belief } = this.model.drawn;
    const sorted = [...things].sort((a, b) => b.goal - a.goal || a.name.localeCompare(b.name) || b.confidence - a.confidence);
    const key = sorted.map((t) => `${t.id}${t.name}${percent(t.confidence)}${t.room}`).join();
    replace(byId("things-list"), key, () =>
      sorted.map((thing) =>
        element(
          "li",
          { data: thing.goal ? { goal: "" } : {} },
          element("span", {}, thing.name, thing.room ? element("small", {}, thing.room) : null),
          element("output", {}, percent(thing.confidence)),
          this.#button("Show", `Show ${thing.name} on the map`, `t${thing.id}`, () => this.show(thing.xy)),
        ),
      ).concat(sorted.length ? [] : [none("nothing yet")]),
    );
    const likely = [...(belief ?? [])].filter((b) => b.p >= 0.01).sort((a, b) => b.p - a.p).slice(0, 8);
    replace(byId("belief-list"), JSON.stringify(likely), () =>
      likely.map((one) =>
        element(
          "li",
          {},
          element("span", {}, `${one.kind} ${one.id ?? ""}`, element("small", {}, one.why ?? "")),
          element("output", {}, percent(one.p)),
          one.xy ? this.#button("Show", `Show ${one.kind} ${one.id} on the map`, `b${one.id}`, () => this.show(one.xy)) : null,
        ),
      ).concat(likely.length ? [] : [none("nobody has said")]),
    );
  }

  #places() {
    const can = Boolean(this.model.welcome?.can?.command);
    const { places } = this.model;
    replace(byId("places-list"), JSON.stringify([places, can]), () =>
      places.map(({ name, xy }) =>
        element(
          "li",
          {},
          element("span", {}, name, xy ? null : element("small", {}, "not known where, now")),
          can && xy ? this.#button("Go", `Go to ${name}`, `g${name}`, () => this.#do("goal", { go_to: name }, `On its way to ${name}`)) : null,
          can && !xy ? this.#button("It is here", `The robot stands at ${name}`, `h${name}`, () => this.#do("places", { i_am_at: name }, `It stands at ${name}`)) : null,
          can ? this.#button("Forget", `Forget the place ${name}`, `f${name}`, () => this.#do("places", { remove: name }, `${name} is forgotten`)) : null,
        ),
      ).concat(places.length ? [] : [none("none has a name")]),
    );
  }

  #zones() {
    const can = Boolean(this.model.welcome?.can?.command);
    const { zones, bound } = this.model;
    replace(byId("zones-list"), JSON.stringify([zones, bound, can]), () => {
      const rows = zones.map(({ name }) =>
        element(
          "li",
          {},
          element("span", {}, name),
          can ? this.#button("Remove", `Remove the zone ${name}`, `z${name}`, () => this.#do("zones", { remove: name }, `${name} is open again`)) : null,
        ),
      );
      if (!bound) rows.unshift(none("Nobody knows where they lie since the restart: name where the robot stands"));
      return rows.length ? rows : [none("none is drawn")];
    });
  }

  #button(text, label, focus, onclick) {
    return element("button", { type: "button", class: "quiet", "aria-label": label, data: { focus }, onclick }, text);
  }

  async #do(what, body, said) {
    try {
      await this.link.ask(what, body);
      toast(said);
    } catch (error) {
      toast(error.message, "bad");
    }
  }
}

const none = (text) => element("li", { class: "none" }, text);
