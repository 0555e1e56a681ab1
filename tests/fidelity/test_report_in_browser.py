"""The page as its reader uses it: headless Chromium, by mouse and by keyboard."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.pages import Reader, luminance, pixels_of
from trimray.fidelity.findings import not_comparable
from trimray.fidelity.report_html import to_html
from trimray.fidelity.result import Result

from .reports import VOLUME, comparison, results


@pytest.fixture(scope="module")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_bytes(to_html(results()))
    return path


@pytest.fixture
def open_report(open_page: Callable[..., Any], page_file: Path) -> Callable[..., Any]:
    """open_report(hash, scheme): a Reader."""

    def call(hash: str = "", scheme: str = "light", path: Path = page_file, width: int = 1100) -> Any:
        return open_page(str(path), hash, color_scheme=scheme, viewport={"width": width, "height": 800})

    return call


def pressed(reader: Reader) -> list[str]:
    chosen: list[str] = reader.page.locator(".controls button[aria-pressed=true]").evaluate_all(
        "buttons => buttons.map(button => button.dataset.name)"
    )
    return chosen


def test_the_index_tells_each_input_with_its_verdict(open_report: Any) -> None:
    page = open_report().page
    assert page.locator("#count").text_content() == "4 of 5 inputs not complete"
    verdicts = page.locator("#index .badge").all_text_contents()
    assert verdicts == ["complete", "partial", "failed", "failed", "changed"]
    assert page.locator("#index tbody tr").nth(1).text_content() == "part.steppartial2 of 4 values"
    assert "the writer ended with 3" in page.locator("#index tbody tr").nth(2).text_content()
    assert page.locator("#result-name").text_content() == "good.step"


def test_differences_come_first_each_with_its_tolerance(open_report: Any) -> None:
    page = open_report("#input=2").page
    rows = page.locator("#result table").first.locator("tbody tr")
    assert rows.count() == 2
    cells = rows.nth(0).locator("td").all_text_contents()
    assert cells[1:] == ["0", "0.0025", "0.0025 mm", "1e-6 mm", "differs"]
    assert rows.nth(1).get_attribute("class") == "missing"
    summary = page.locator("summary", has_text="mass: 1 value agrees")
    summary.focus()
    page.keyboard.press("Enter")
    assert "6000.000001" in page.locator("table[aria-label=mass]").text_content()


def test_what_could_not_be_compared_is_named(open_report: Any, tmp_path: Path) -> None:
    lacking = not_comparable("mass", "masses", [True, False], "it crashed")
    path = tmp_path / "report.html"
    path.write_bytes(to_html([Result("part.step", "compare", (comparison(VOLUME, lacking),), exit_code=7)]))
    page = open_report(path=path).page
    assert "partial 2 values, none differs, 1 not compared" in page.locator(".verdict").text_content()
    cells = page.locator("#result table").first.locator("tbody td").all_text_contents()
    assert cells == ["mass massesnot compared: it crashed", "yes", "no", "", "", "not compared"]


def test_the_view_that_differs_most_is_shown_first(open_report: Any) -> None:
    reader = open_report("#input=2")
    assert pressed(reader) == ["front", "beside"]
    sources = reader.page.locator(".sheets img").evaluate_all("images => images.map(image => image.alt)")
    assert sources == ["A, front", "B, front"]
    assert "12 in depth, 340 in normal, 64 in coverage" in reader.page.locator(".legend").text_content()
    reader.page.click("button[data-name=iso]")
    assert reader.page.locator(".sheets img").first.get_attribute("alt") == "A, iso"
    assert "view=iso" in reader.hash("view=iso")


def test_equal_pictures_are_in_the_page_once(open_report: Any, page_file: Path) -> None:
    page = open_report("#input=1&view=iso").page
    sources = page.locator(".sheets img").evaluate_all("images => images.map(image => image.src)")
    assert len(sources) == 2 and sources[0] == sources[1]
    widths = page.locator(".sheets img").evaluate_all(
        "images => Promise.all(images.map(image => image.decode().then(() => image.naturalWidth)))"
    )
    assert widths == [64, 64]
    assert '"b":"a"' in page_file.read_text()


def test_the_overlay_is_one_picture(open_report: Any) -> None:
    reader = open_report("#input=2&mode=overlay")
    image = reader.page.locator(".sheets img")
    assert image.count() == 1 and image.get_attribute("alt") == "Overlay, front"
    assert image.evaluate("image => image.decode().then(() => image.naturalWidth)") == 64
    assert "only in A" in reader.page.locator("figcaption").text_content()


def test_the_slider_moves_by_keyboard_and_by_mouse(open_report: Any) -> None:
    reader = open_report("#input=2&mode=slider")
    page = reader.page
    border = page.locator("input.border")
    assert border.input_value() == "50"
    border.focus()
    page.keyboard.press("ArrowRight")
    assert border.input_value() == "51"
    assert border.get_attribute("aria-valuetext") == "51 % of A"
    clip = "element => getComputedStyle(element).clipPath"
    assert page.locator(".above").evaluate(clip) == "inset(0px 49% 0px 0px)"
    page.keyboard.press("Home")
    assert border.input_value() == "0"
    box = page.locator(".stack").bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 10, middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.75 * box["width"], middle)
    page.mouse.up()
    assert border.input_value() == "75"
    page.mouse.move(box["x"] + 0.2 * box["width"], middle)
    assert border.input_value() == "75"


def test_the_slider_shows_a_left_of_its_border_and_b_right_of_it(open_report: Any) -> None:
    """A's square begins at 1/4 of the width, B's at 5/16 and ends at 13/16."""
    reader = open_report("#input=2&mode=slider")
    page = reader.page
    page.locator(".stack img").first.evaluate("image => image.decode()")
    picture = pixels_of(page.locator(".stack").screenshot())
    middle, width = picture[picture.shape[0] // 2], picture.shape[1]
    blue = middle[:, 2].astype(int) - middle[:, 0] > 60
    assert blue[int(0.29 * width)] and blue[int(0.78 * width)]
    assert not blue[int(0.2 * width)] and not blue[int(0.84 * width)]


def test_an_input_is_chosen_by_its_link_and_by_the_address(open_report: Any) -> None:
    reader = open_report("#input=4")
    page = reader.page
    assert page.locator("#result-name").text_content() == "gone.step"
    assert "No such file or directory" in page.locator("#result .verdict").text_content()
    page.locator("#index a", has_text="part.step").focus()
    page.keyboard.press("Enter")
    assert page.locator("#result-name").text_content() == "part.step"
    assert page.locator("#index tr[aria-current=true]").text_content().startswith("part.step")
    assert reader.hash("input=2") == "#input=2"
    page.evaluate("location.hash = '#input=99&view=x&mode=constructor'")
    page.wait_for_function("document.querySelector('#result-name').textContent === 'good.step'")


def test_hostile_names_are_text(open_report: Any) -> None:
    page = open_report("#input=5").page
    assert (
        "</script><img src=x onerror=alert(1)>{{script}}\\x1b[31m\\u202e"
        in page.locator("#result").inner_text()
    )
    assert page.locator("img[src=x]").count() == 0


def test_the_page_follows_the_system_into_the_dark(open_report: Any) -> None:
    light, dark = open_report(scheme="light"), open_report(scheme="dark")
    assert luminance(light, "body", "backgroundColor") > 0.9
    assert luminance(dark, "body", "backgroundColor") < 0.2
    assert luminance(dark, "body", "color") > 0.7
    light.page.click("#theme")
    assert luminance(light, "body", "backgroundColor") < 0.2


def test_nothing_is_wider_than_a_narrow_window(open_report: Any) -> None:
    page = open_report("#input=5", width=360).page
    assert page.evaluate("document.documentElement.scrollWidth") <= 360


def test_one_input_needs_no_index(open_report: Any, tmp_path: Path) -> None:
    path = tmp_path / "one.html"
    path.write_bytes(to_html(results()[1:2]))
    reader = open_report(path=path)
    assert reader.page.locator("#index").is_hidden() and reader.page.title() == "Round trip: part.step"
    empty = tmp_path / "none.html"
    empty.write_bytes(to_html([]))
    assert open_report(path=empty).page.locator("#result").text_content() == "There was no input."


def test_the_policy_allows_what_is_in_the_page_and_nothing_else(page_file: Path) -> None:
    text = page_file.read_text()
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    script = text[
        text.index('<script type="module">') + len('<script type="module">') : text.rindex("</script>")
    ]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'; img-src data:;" in policy and "unsafe" not in policy
