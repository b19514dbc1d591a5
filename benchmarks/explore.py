"""How fast `propmap explore` answers in a real browser, into benchmarks/results/explore.json.

First paint is the browser's first contentful paint; the first figure is timed from the request of
the address, without a cache; a step from the key that moves a slider to the frame in which all
figures of the view have changed.
"""

from __future__ import annotations

import json
import statistics
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.results_file import machine
from tools.explore_browser import browser, explorer, open_view, settle

if TYPE_CHECKING:
    from playwright.sync_api import Page

STEPS = 50
LOADS = 5

RESULT = Path(__file__).parent / "results" / "explore.json"

# A figure is there in the first frame that finds it visible; Playwright looks every half second.
FIGURE = """(function look() {
  const figure = document.querySelector(".js-plotly-plot .main-svg");
  if (figure && figure.checkVisibility({ visibilityProperty: true }) && figure.clientWidth)
    window.firstFigure = performance.now();
  else requestAnimationFrame(look);
})();"""

PAINT = """() => performance.getEntriesByName("first-contentful-paint")[0].startTime"""

STEP = """async (selector) => {
  const slider = document.querySelector(selector);
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const begin = performance.now();
  set.call(slider, String(Number(slider.value) + Number(slider.step)));
  const drawn = new Promise((done) =>
    window.addEventListener("propmap-drawn", done, { once: true }));
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  slider.dispatchEvent(new Event("change", { bubbles: true }));
  await drawn;
  return performance.now() - begin;
}"""


def opened(address: str) -> tuple[list[float], list[float]]:
    """Seconds until something and until the first figure is drawn, in browsers without a cache."""
    paints, figures = [], []
    for _ in range(LOADS):
        with browser() as one:
            page = one.new_page(viewport={"width": 1280, "height": 900})
            page.add_init_script(FIGURE)
            page.goto(address, wait_until="commit")
            page.wait_for_function("window.firstFigure", timeout=60e3)
            figures.append(1e-3 * float(page.evaluate("window.firstFigure")))
            paints.append(1e-3 * float(page.evaluate(PAINT)))
    return paints, figures


def steps(page: Page, address: str, control: str) -> list[float]:
    """Milliseconds of each step of a slider."""
    open_view(page, address)
    selector = f'[id=\'{{"control":"{control}"}}\']'
    found = []
    for _ in range(STEPS):
        found.append(float(page.evaluate(STEP, selector)))
        # A hand that lets go now and then; what follows a pause is not timed.
        page.wait_for_timeout(30.0)
    settle(page)
    return found


def summary(values: list[float]) -> dict[str, float]:
    """Median and 90 % of some times."""
    ordered = sorted(values)
    return {
        "median": round(statistics.median(ordered), 3),
        "90 %": round(ordered[int(0.9 * (len(ordered) - 1))], 3),
        "least": round(ordered[0], 3),
    }


def main() -> None:
    """Time all, print it and file it."""
    found: dict[str, Any] = {"steps": STEPS}
    with explorer("apc-8x6e") as (address, _):
        paints, figures = opened(address)
        found["first_paint_s"], found["first_figure_s"] = summary(paints), summary(figures)
        with browser() as one:
            page = one.new_page(viewport={"width": 1280, "height": 900})
            for view, control in (("loads", "rpm"), ("disk", "speed")):
                times = summary(steps(page, f"{address}/{view}", control))
                found[f"{view}_step_ms"] = times
                print(f"{view}: a step of {control} takes {times} ms")
    print(f"first paint: {found['first_paint_s']} s, first figure: {found['first_figure_s']} s")
    RESULT.write_text(json.dumps({**found, "machine": machine()}, indent=2) + "\n")


if __name__ == "__main__":
    main()
