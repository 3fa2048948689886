"""The page in a real browser: no errors, nothing fetched, plots there, and they answer to the pointer.

The screenshot is kept in the folder that TBI_ARTEFACTS names, if it is set.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.cli.commands import tbi

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra: test)")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium here; Debian: apt-get install chromium")

Opened = tuple[Any, list[str], list[str]]
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@pytest.fixture(scope="module")
def page_file(campaign: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("browser")
    files = [
        str(campaign / f"{name}.h5") for name in ("velocity", "velocity-masses", "velocity-damping", "masses")
    ]
    ended = tbi("report", *files, "-o", "report", "--formats", "png", "-q", folder=folder)
    assert ended.code == 0, ended.err
    return folder / "report" / "report.html"


@pytest.fixture
def opened(page_file: Path, tmp_path: Path) -> Iterator[Opened]:
    with visited(page_file, tmp_path) as page:
        yield page


@contextmanager
def visited(page_file: Path, tmp_path: Path) -> Iterator[Opened]:
    """The page once all plots are drawn, what it complained of, and what it fetched."""
    complaints: list[str] = []
    fetched: list[str] = []
    with playwright.sync_playwright() as engine:
        context = engine.chromium.launch_persistent_context(
            str(tmp_path / "profile"),
            executable_path=CHROMIUM,
            headless=True,
            args=list(QUIET),
            viewport={"width": 1200, "height": 900},
            offline=True,
        )
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: fetched.append(request.url))
        page.goto(page_file.as_uri())
        page.wait_for_selector("html[data-drawn=all]", timeout=60_000)
        yield page, complaints, fetched
        context.close()


def test_the_page_works_in_a_browser(opened: Opened, page_file: Path) -> None:
    page, complaints, fetched = opened
    # Figs. 15-21 are over velocity; every one is a plot with a curve for each of its data.
    for number, curves in ((15, 6), (16, 6), (17, 6), (18, 6), (19, 8), (20, 8), (21, 8)):
        assert page.locator(f"#fig{number} .plot .scatterlayer .trace").count() == curves
    assert page.locator("figure img").count() >= 10

    plot = page.locator("#fig19 .plot")
    plot.scroll_into_view_if_needed()
    area = page.locator("#fig19 .plot .nsewdrag").first.bounding_box()
    assert area is not None
    page.mouse.move(area["x"] + area["width"] / 2, area["y"] + area["height"] / 2)
    page.wait_for_selector("#fig19 .hoverlayer .legend", timeout=10_000)
    told = page.locator("#fig19 .hoverlayer").text_content()
    assert "mm" in told and "80" in told and "train velocity" in told and "m/s" in told
    # No legend is cut off, that of Fig. 18 with a curve of its own for each panel among them.
    for number in range(15, 22):
        legend = page.locator(f"#fig{number} .infolayer .legend").bounding_box()
        frame = page.locator(f"#fig{number} .plot").bounding_box()
        assert frame["x"] <= legend["x"] and legend["x"] + legend["width"] <= frame["x"] + frame["width"]
        assert legend["y"] + legend["height"] <= frame["y"] + frame["height"]

    kept = os.environ.get("TBI_ARTEFACTS")
    if kept:
        Path(kept).mkdir(parents=True, exist_ok=True)
        page.screenshot(path=str(Path(kept) / "report-fig19-hover.png"))
        page.screenshot(path=str(Path(kept) / "report.png"), full_page=True)

    # A click in the legend takes a curve away in both panels, the next one brings it back.
    visible = "document.querySelector('#fig19 .plot').data.filter(t => t.visible !== 'legendonly').length"
    assert page.evaluate(visible) == 8
    page.locator("#fig19 .legendtoggle").first.click()
    page.wait_for_function(f"{visible} === 6", timeout=10_000)
    page.locator("#fig19 .legendtoggle").first.click()
    page.wait_for_function(f"{visible} === 8", timeout=10_000)

    # Dragging zooms.
    before = page.evaluate("document.querySelector('#fig19 .plot').layout.xaxis.range")
    page.mouse.move(area["x"] + 40, area["y"] + 40)
    page.mouse.down()
    page.mouse.move(area["x"] + 140, area["y"] + 140, steps=5)
    page.mouse.up()
    page.wait_for_timeout(300)
    after = page.evaluate("document.querySelector('#fig19 .plot').layout.xaxis.range")
    assert after[1] - after[0] < before[1] - before[0]

    # The comparison with the paper is in sight to its last column.
    for grid in page.locator("#claims ~ .scroll").all()[:2]:
        assert grid.evaluate("grid => grid.scrollWidth <= grid.clientWidth")

    assert complaints == []
    assert fetched == [page_file.as_uri()]


def test_ten_trains_and_their_resonances_in_a_browser(tmp_path: Path) -> None:
    sweep = "{train.number: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10], velocity: {from: 80, to: 120, step: 2}}"
    for command in (
        ("run", "practice/hslm-a", "--set", f"sweep={sweep}", "-o", "trains.h5", "-q"),
        ("report", "trains.h5", "--formats", "png", "-q"),
    ):
        ended = tbi(*command, folder=tmp_path)
        assert ended.code == 0, ended.err
    file = tmp_path / "trains-report" / "report.html"
    with visited(file, tmp_path) as (page, complaints, fetched):
        # One span: deflection and acceleration of ten trains; then a panel for each train.
        deck = page.locator("#trains-deck .plot")
        assert deck.locator(".scatterlayer .trace").count() == 20
        assert deck.locator(".legendtext").all_text_contents() == [f"A{k}" for k in range(1, 11)]
        assert page.locator("#trains-resonance-acceleration .plot .lines > path").count() >= 10
        assert page.locator("#trains-resonance-acceleration .plot .points > path").count() >= 5
        deck.scroll_into_view_if_needed()
        area = deck.locator(".nsewdrag").first.bounding_box()
        assert area is not None
        page.mouse.move(area["x"] + area["width"] / 2, area["y"] + area["height"] / 2)
        page.wait_for_selector("#trains-deck .hoverlayer .legend", timeout=10_000)
        told = page.locator("#trains-deck .hoverlayer").text_content()
        assert "A10" in told and "mm" in told
        assert "Resonance" in page.locator("#tables ~ details summary, #tables ~ h3").all_text_contents()[0]
        kept = os.environ.get("TBI_ARTEFACTS")
        if kept:
            Path(kept).mkdir(parents=True, exist_ok=True)
            page.screenshot(path=str(Path(kept) / "report-trains.png"), full_page=True)
        assert complaints == []
        assert fetched == [file.as_uri()]
