"""The pages in a real browser."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import propmap as pm
from tests.cli.invented_tables import invented
from tools.explore_browser import browser, browser_path, explorer, open_view, settle

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytest.importorskip("playwright", reason="playwright is not installed")
absent = pytest.mark.skipif(browser_path() is None, reason="no browser is installed (chromium)")
pytestmark = [pytest.mark.slow, absent]

VIEWS = ("loads", "disk", "blade", "constants", "compare", "aircraft")
VEHICLE = Path(__file__).parents[2] / "examples" / "aircraft" / "delivery.toml"
RPM = np.pi / 30.0


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with explorer("apc-8x6e") as (found, _):
        yield found


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.fixture
def page(chromium: Browser, address: str) -> Iterator[Page]:
    """A page that fails the test where something goes wrong in it, or leaves the machine."""
    found = chromium.new_page(viewport={"width": 1024, "height": 800})
    wrong: list[str] = []
    found.on("pageerror", lambda error: wrong.append(str(error)))
    found.on("console", lambda one: wrong.append(one.text) if one.type == "error" else None)
    own = (address, "data:", "blob:")
    found.on("request", lambda r: None if r.url.startswith(own) else wrong.append(r.url))
    yield found
    found.close()
    assert not wrong


def test_each_view_opens_fits_and_is_accessible(page: Page, address: str, tmp_path: Path) -> None:
    """No serious violation that axe finds, and nothing wider than a telephone."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    invented().save(tmp_path / "map.npz")
    open_view(page, f"{address}/disk")
    for path, kind in ((VEHICLE, "vehicle"), (tmp_path / "map.npz", "table")):
        page.locator("input[type=file]").set_input_files(path)
        page.wait_for_selector(f".files:has-text('{kind}')", timeout=60e3)
        settle(page)
    for name in VIEWS:
        page.get_by_role("link", name=name.capitalize(), exact=True).click()
        page.wait_for_selector(f".view-{name}", timeout=60e3)
        settle(page)
        assert page.locator(".js-plotly-plot .main-svg").count()
        assert page.locator("#tables table").count() or name == "constants"
        for width, scheme in ((390, "light"), (1600, "dark")):
            page.set_viewport_size({"width": width, "height": 800})
            page.emulate_media(color_scheme=scheme)
            page.wait_for_timeout(150)
            for one in axe.run(page).response["violations"]:
                assert one["impact"] not in ("serious", "critical"), f"{name}: {one}"
            assert page.evaluate("document.documentElement.scrollWidth") <= width, name


def test_numbers_commands_and_address(page: Page, address: str) -> None:
    """By keyboard: a slider is moved, the table, the address and the command follow."""
    open_view(page, f"{address}/loads?prop=apc-8x6e&rpm=5000&speed=12&beta=70&bands=")
    slider = page.get_by_label("Rotational speed [rpm]")
    slider.focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_timeout(50)
    settle(page)
    assert "rpm=5010" in page.url
    loads = pm.Rotor(pm.catalogue_model("apc-8x6e")).loads(5010.0 * RPM, 12.0, np.radians(70.0))
    row = page.locator("#tables tr", has=page.locator("th", has_text="thrust")).first
    assert row.locator("td").first.inner_text() == f"{float(loads.thrust):.4g}"
    command = str(page.locator("#command").text_content())
    assert "--rpm 5010" in command and "--no-bands" in command
    box = page.get_by_label("Rotational speed, as a number")
    box.fill("4321")
    box.press("Enter")
    page.wait_for_function("location.href.includes('rpm=4321')")
    settle(page)
    page.reload()
    page.wait_for_selector(".view")
    settle(page)
    assert float(page.get_by_label("Rotational speed, as a number").input_value()) == 4321.0


def test_a_fit_outlives_a_reload_and_a_killed_browser(chromium: Browser, address: str) -> None:
    includes = "document.querySelector('#progress').innerText.includes('{}')"

    def fitting(one: Browser) -> Page:
        page = one.new_page()
        open_view(page, f"{address}/constants?prop=apc-8x6e&data=uiuc-8x6e&free=c_l1")
        page.locator("#fit").click()
        page.wait_for_function(includes.format("fit"))
        return page

    killed = chromium.browser_type.launch(executable_path=browser_path(), args=["--no-sandbox"])
    fitting(killed)
    killed.close()
    page = fitting(chromium)
    page.reload()
    page.wait_for_selector(".view-constants")
    page.wait_for_function(includes.format("c_l1 ="), timeout=240e3)
    page.wait_for_timeout(600)
    fitted = float(page.get_by_label("c_l1, lift slope").first.input_value())
    shown = re.search(r"c_l1 = ([\d.]+)", page.locator("#progress").inner_text())
    assert shown is not None and fitted == pytest.approx(float(shown[1]), abs=0.01)
    page.close()


def test_a_point_of_the_blade_is_dragged_and_put_back(page: Page, address: str) -> None:
    open_view(page, f"{address}/blade?prop=apc-8x6e")
    place = page.locator('[id=\'{"graph":"chord"}\']')
    place.scroll_into_view_if_needed()
    point = place.locator(".shapelayer path").nth(2).bounding_box()
    assert point is not None
    x, y = point["x"] + 0.5 * point["width"], point["y"] + 0.5 * point["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 30.0, steps=6)
    page.mouse.up()
    page.wait_for_function("/chord-2=1[0-9][1-9]/.test(location.href)")
    settle(page)
    assert "cat > blade.toml" in str(page.locator("#command").text_content())
    page.locator("#undo").click()
    page.wait_for_function("location.href.includes('chord-2=100')")
    settle(page)
