/** Panels beside the map, one at a time; on a desk the camera stands above them. */

import { byId } from "./words.js";

export class Tabs {
  /** `shown(tab)` is called when another one is looked at. */
  constructor(shown) {
    this.shown = shown;
    this.tabs = [...document.querySelectorAll("[role=tab]")];
    for (const tab of this.tabs) {
      tab.addEventListener("click", () => this.show(tab));
      tab.addEventListener("keydown", (event) => this.#key(event, tab));
    }
    matchMedia("(max-width: 859px), (max-height: 500px)").addEventListener("change", ({ matches }) => {
      if (!matches && document.body.dataset.tab === "camera") this.show(byId("tab-why"));
      else this.shown(document.body.dataset.tab);
    });
    this.show(byId("tab-why"));
  }

  show(chosen) {
    for (const tab of this.tabs) {
      tab.setAttribute("aria-selected", String(tab === chosen));
      tab.tabIndex = tab === chosen ? 0 : -1;
    }
    document.body.dataset.tab = chosen.getAttribute("aria-controls");
    this.shown(document.body.dataset.tab);
  }

  #key(event, tab) {
    const seen = this.tabs.filter((one) => one.checkVisibility());
    const at = seen.indexOf(tab);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: seen.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const next = seen[(to + seen.length) % seen.length];
    this.show(next);
    next.focus();
  }
}
