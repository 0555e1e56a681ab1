"""The gallery where it is hard: hostile names, many files, none, narrow windows, paper; and its pictures."""

from __future__ import annotations

import functools
import http.server
import os
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.pages import luminance, pixels_of
from trimray.batch.gallery import write_gallery
from trimray.batch.record import Outcome, Settings, Status

from .gallery_reader import WIDTHS, make

HOSTILE = [
    "<img src=x onerror=window.hacked=1>.step",
    "</script><script>window.hacked=1</script>.step".replace("/", "\u2215"),
    "quotes '\"`.step",
    "two\nlines.step",
    "100%41.step",
    "#fragment?query&amp;.step",
    "line\u2028separator\u202egnp.step",
    "javascript:hacked=1.step",
    "ünïcödé 日本 👩‍🔧.step",
    os.fsdecode(b"latin1 caf\xe9.step"),
]


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *arguments: Any) -> None:
        pass


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("hostile <b>#%41'\"")
    outcomes = [make(folder, name, drawn=1) for name in HOSTILE]
    reason = "<img src=x onerror=window.hacked=1>\n</script>"
    outcomes += [make(folder, f"failed {name}", "failed", reason=f"{name}: {reason}") for name in HOSTILE]
    return write_gallery(folder, outcomes)


def test_hostile_names_are_text_and_their_pictures_are_found(open_page: Any, hostile: str) -> None:
    reader = open_page(hostile)
    assert reader.count == "20 files"
    assert reader.page.evaluate(WIDTHS) == [64] * len(HOSTILE)
    names = set(reader.names)
    for name in ("<img src=x onerror=window.hacked=1>.step", "two\\nlines.step", "latin1 caf\\xe9.step"):
        assert name in names
    assert "line\\u2028separator\\u202egnp.step" in names
    reader.page.fill("#search", "onerror")
    for tile in range(reader.page.locator(".tile").count()):
        reader.page.locator(".tile").nth(tile).click()
        assert reader.open
        reader.page.keyboard.press("Escape")
    reader.page.fill("#search", "hacked=1")
    link = reader.hash("q=hacked%3D1")
    assert open_page(hostile, link).names == reader.names
    reader.page.evaluate("location.hash = 'q=<img src=x onerror=window.hacked=1>&open=<b>'")
    reader.page.wait_for_function("document.getElementById('search').value.includes('<img')")
    for page in (reader.page, open_page(hostile, link).page):
        assert page.evaluate("window.hacked") is None
    assert reader.page.locator("#grid script, #grid b, .tile img[src=x]").count() == 0


def test_a_server_can_show_it_as_well(open_page: Any, gallery: str) -> None:
    handler = functools.partial(QuietHandler, directory=str(Path(gallery).parent))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever).start()
        place = f"http://127.0.0.1:{server.server_address[1]}/"
        try:
            reader = open_page(f"{place}index.html")
            widths = reader.page.evaluate(WIDTHS)
        finally:
            server.shutdown()
    assert widths == [64] * 30
    assert [url for url in reader.requests if not url.startswith((place, "data:"))] == []
    reader.requests.clear()


def test_a_picture_that_is_gone_is_told(open_page: Any, tmp_path: Path) -> None:
    there = make(tmp_path, "there.step", drawn=1)
    page = write_gallery(
        tmp_path, [there, replace(there, path=f"{tmp_path}/in/gone.step", target=f"{tmp_path}/g.png")]
    )
    reader = open_page(page)
    reader.page.wait_for_selector(".plate.empty")
    assert reader.page.locator(".plate.empty").text_content().startswith("Picture missing")
    assert len(reader.errors) == 1 and "ERR_FILE_NOT_FOUND" in reader.errors.pop()


def test_empty_and_all_failed_batches(open_page: Any, tmp_path: Path) -> None:
    reader = open_page(write_gallery(tmp_path, []))
    assert reader.count == "0 files"
    assert reader.page.locator("#none").text_content() == "The batch holds no files."
    failed = [make(tmp_path, f"{i}.step", "failed", reason="empty") for i in range(3)]
    reader = open_page(write_gallery(tmp_path, failed))
    assert reader.names == ["0.step", "1.step", "2.step"]
    assert reader.page.locator(".why").all_text_contents() == ["empty"] * 3


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Ten thousand entries that share five pictures."""
    folder = tmp_path_factory.mktemp("large")
    made = [make(folder, f"shared {i}", color=(50 * i, 100, 0)) for i in range(5)]

    def entry(i: int) -> Outcome:
        status: Status = "failed" if i % 1000 == 0 else "complete"
        return replace(
            made[i % 5],
            path=f"{folder}/in/f{i // 100}/part_{i:05}.step",
            status=status,
            drawn=i,
            seconds=i / 10,
        )

    return write_gallery(folder, (entry(i) for i in range(10_000)))


def test_ten_thousand_entries_keep_the_document_small(open_page: Any, large: str) -> None:
    reader = open_page(large)
    assert reader.count == "10,000 files"

    def nodes() -> int:
        return int(reader.page.evaluate("document.querySelectorAll('*').length"))

    assert nodes() < 1500
    reader.page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
    reader.page.wait_for_selector("text=part_09999.step")
    assert nodes() < 1500
    reader.page.evaluate("scrollTo(0, document.documentElement.scrollHeight / 2)")
    reader.page.wait_for_selector("text=part_05000.step")
    assert nodes() < 1500 and "part_09999.step" not in reader.names
    reader.page.fill("#search", "part_07")
    box, head = (reader.page.locator(which).first.bounding_box() for which in (".tile", "#head"))
    assert head["y"] + head["height"] <= box["y"] < 300  # scrolled back to the results, not below the head
    reader.page.fill("#search", "part_0777")
    assert reader.names == [f"part_0777{i}.step" for i in range(10)]
    reader.page.fill("#search", "")
    reader.page.click(".chip.failed")
    assert reader.names == [f"part_{i:05}.step" for i in range(0, 10_000, 1000)]
    reader.page.click(".chip.failed")
    reader.page.locator("#grid").focus()
    reader.page.keyboard.press("End")
    assert reader.active() == "part_09999.step"
    assert reader.page.locator(".tile.active").bounding_box()["y"] < 800
    rows = reader.page.locator(".row").evaluate_all("rows => rows.map(row => Number(row.ariaRowIndex))")
    assert rows == sorted(rows)


def test_the_grid_shows_the_pictures_themselves(open_page: Any, tmp_path: Path, samples_dir: Path) -> None:
    import trimray

    settings = Settings(size=(128, 128))
    outcomes = []
    for view in ("iso", "front"):
        target = tmp_path / f"{view}.png"
        trimray.load(samples_dir / "stand.stl").render(size=settings.size, view=view).save(target)
        outcomes.append(Outcome(str(tmp_path / f"{len(outcomes)}.stl"), str(target), "complete", drawn=1))
    reader = open_page(write_gallery(tmp_path, outcomes, settings=settings), color_scheme="light")
    drawn = [Path(outcome.target).read_bytes() for outcome in outcomes]
    for index in range(2):
        image = reader.page.locator(".tile img").nth(index)
        image.evaluate("image => image.decode()")
        shown = pixels_of(image.screenshot())
        own, other = (likeness(shown, drawn[which]) for which in (index, 1 - index))
        assert own > 0.97 > 0.9 > other


def likeness(shown: np.ndarray[Any, np.dtype[np.uint8]], png: bytes) -> float:
    """How a part of the screen and a picture correlate, the picture scaled as the browser scaled it."""
    height, width = shown.shape[:2]
    picture = np.asarray(Image.fromarray(pixels_of(png)).resize((width, height)))
    return float(np.corrcoef(shown.ravel(), picture.ravel())[0, 1])


def test_narrow_and_zoomed_windows_need_no_sideways_scrolling(open_page: Any, gallery: str) -> None:
    for width, height in ((320, 640), (640, 360)):  # a phone; 1280 x 720 at 200 %
        reader = open_page(gallery, viewport={"width": width, "height": height})
        assert reader.page.evaluate("document.documentElement.scrollWidth") <= width
        assert int(reader.page.locator("#grid").get_attribute("aria-colcount")) >= 2
        reader.page.locator(".tile").nth(3).click()
        close = reader.page.locator("#close").bounding_box()
        assert close["x"] + close["width"] <= width and close["y"] >= 0


def test_the_print_holds_all_tiles_and_no_controls(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery, color_scheme="dark")
    reader.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    reader.page.emulate_media(media="print")
    assert reader.page.locator(".tile").count() == 32
    assert not reader.page.locator("#search").is_visible()
    assert luminance(reader, "body", "color") < 0.2
    reader.page.emulate_media(media="screen")
    reader.page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert reader.page.locator("#search").is_visible()
