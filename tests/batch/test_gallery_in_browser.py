"""The gallery as a reader uses it: headless Chromium on a file:// page, by mouse and by keyboard."""

from __future__ import annotations

import os
import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trimray.batch.gallery import write_gallery
from trimray.batch.record import STATUSES, Outcome, Settings, Status

playwright = pytest.importorskip("playwright.sync_api", reason="no playwright")

_CHROMIUM = "/usr/bin/chromium"

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


def png(color: tuple[int, int, int], size: int = 64) -> bytes:
    """A white picture with a square of that colour in its middle."""
    pixels = np.full((size, size, 3), 255, np.uint8)
    pixels[size // 4 : -size // 4, size // 4 : -size // 4] = color
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    data = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + data


def pixels_of(data: bytes) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Of a PNG, (height, width, 3)."""
    import io

    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


def make(
    folder: Path,
    name: str,
    status: Status = "complete",
    color: tuple[int, int, int] = (40, 90, 160),
    **facts: Any,
) -> Outcome:
    """An outcome, and its picture unless it failed."""
    target = folder / "pictures" / f"{name}.png"
    if status != "failed":
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(png(color))
    return Outcome(f"{folder}/in/{name}", str(target), status, **facts)


def library(folder: Path) -> list[Outcome]:
    """Thirty files; faces are 10, 20, ... 300."""
    statuses: dict[int, tuple[Status, str]] = {
        4: ("partial", "1 face not drawn: #12: open loop"),
        9: ("degraded", "read without healing for want of time"),
        14: ("blank", "nothing to be seen"),
    }
    outcomes = []
    for i in range(30):
        status, reason = statuses.get(i, ("complete", ""))
        facts = {"drawn": 10 * (i + 1) - (i == 4), "not_drawn": int(i == 4), "seconds": (i * 7 % 30) / 10}
        more = {"peak_memory": (i * 11 % 30 + 1) << 20, "sha256": f"{i:064x}", "covered": 0.5}
        outcomes.append(make(folder, f"part {i + 1}.step", status, reason=reason, **facts, **more))
    outcomes.append(
        make(folder, "bad/broken.step", "failed", reason="the reader crashed (SIGSEGV)", exit_code=3)
    )
    outcomes.append(
        make(folder, "bad/slow.step", "failed", reason="time limit of 30 s", exit_code=5, seconds=30.0)
    )
    return outcomes


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    if not os.access(_CHROMIUM, os.X_OK):
        pytest.skip(f"no {_CHROMIUM}")
    with playwright.sync_playwright() as started:
        root = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = started.chromium.launch(executable_path=_CHROMIUM, args=[*root, "--disable-gpu"])
        yield browser
        browser.close()


class Reader:
    """A page with what was asked of the outside and what went wrong."""

    def __init__(self, page: Any, url: str) -> None:
        self.page = page
        self.url = url
        self.errors: list[str] = []
        self.requests: list[str] = []
        page.on(
            "console", lambda message: self.errors.append(message.text) if message.type != "log" else None
        )
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))
        page.set_default_timeout(60_000)
        page.goto(url)

    @property
    def names(self) -> list[str]:
        names: list[str] = self.page.locator(".tile .name").all_text_contents()
        return names

    @property
    def count(self) -> str:
        return str(self.page.locator("#count").text_content())

    @property
    def open(self) -> bool:
        return bool(self.page.locator("#detail").evaluate("dialog => dialog.open"))

    def hash(self, holding: str) -> str:
        """The address's state, once it holds the text: it is written with a delay."""
        self.page.wait_for_function("text => location.hash.includes(text)", arg=holding)
        return str(self.page.evaluate("location.hash"))

    def active(self) -> str:
        return str(self.page.locator(".tile.active .name").text_content())


@pytest.fixture
def read(browser: Any) -> Iterator[Any]:
    """read(page, hash="", **options of the browser's context) -> Reader; in the end nothing was wrong."""
    readers: list[Reader] = []
    contexts = []

    def call(path: str, hash: str = "", **options: Any) -> Reader:
        context = browser.new_context(**{"viewport": {"width": 1200, "height": 800}, **options})
        contexts.append(context)
        readers.append(Reader(context.new_page(), Path(path).as_uri() + hash))
        return readers[-1]

    yield call
    for context in contexts:
        context.close()
    for reader in readers:
        assert reader.errors == []
        assert [url for url in reader.requests if not url.startswith(("file://", "data:"))] == []


@pytest.fixture(scope="module")
def gallery(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("gallery")
    outcomes = library(folder)
    sizes = {outcome.path: 1000 - i for i, outcome in enumerate(outcomes)}
    return write_gallery(folder, outcomes, title="Parts", settings=Settings(), sizes=sizes)


def test_all_files_are_shown_by_name(read: Any, gallery: str) -> None:
    reader = read(gallery)
    assert reader.count == "32 files"
    assert reader.names[:4] == ["broken.step", "slow.step", "part 1.step", "part 2.step"]
    assert reader.names[-1] == "part 30.step"  # numbers count as numbers
    assert reader.page.title() == "Parts"


def test_search_narrows_as_one_types(read: Any, gallery: str) -> None:
    reader = read(gallery)
    reader.page.keyboard.press("/")
    reader.page.keyboard.type("PART 1")
    assert reader.names == ["part 1.step", *(f"part {i}.step" for i in range(10, 20)), "part 21.step"]
    assert reader.count == "12 of 32 files"
    reader.page.keyboard.press("Escape")
    assert reader.count == "32 files"
    reader.page.keyboard.type("segv")  # of the reason
    assert reader.names == ["broken.step"]
    reader.page.fill("#search", f"{7:064x}"[:60])
    assert "part 8.step" in reader.names
    reader.page.fill("#search", "no such file")
    assert reader.names == [] and reader.page.locator("#none").is_visible()
    reader.page.click("#clear")
    assert reader.count == "32 files"


@pytest.mark.parametrize("status", STATUSES)
def test_each_status_is_a_filter_with_its_count(read: Any, gallery: str, status: str) -> None:
    expected = {"complete": 27, "partial": 1, "degraded": 1, "blank": 1, "failed": 2}[status]
    reader = read(gallery)
    chip = reader.page.locator(f".chip.{status}")
    assert chip.text_content() == f"{status} {expected}"
    chip.click()
    assert chip.get_attribute("aria-pressed") == "true"
    assert reader.count == f"{expected} of 32 files"
    assert reader.page.locator(f".tile:not(.{status})").count() == 0
    chip.click()
    assert reader.count == "32 files"


def test_filters_add_up_and_count_what_the_others_leave(read: Any, gallery: str) -> None:
    reader = read(gallery)
    reader.page.click(".chip.failed")
    reader.page.click(".chip.blank")
    assert reader.names == ["broken.step", "slow.step", "part 15.step"]
    reader.page.fill("#search", "part")
    assert reader.names == ["part 15.step"]
    assert reader.page.locator(".chip.failed").text_content() == "failed 0"
    assert reader.page.locator(".chip.complete").text_content() == "complete 27"


def test_faces_are_filtered_by_a_range(read: Any, gallery: str) -> None:
    reader = read(gallery)
    reader.page.fill("#least", "50")
    assert reader.count == "26 of 32 files"
    reader.page.fill("#most", "70")
    assert reader.names == ["part 5.step", "part 6.step", "part 7.step"]
    reader.page.fill("#least", "")
    assert len(reader.names) == 7  # failed files have no number of faces


@pytest.mark.parametrize(
    ("key", "first", "turned"),
    [
        ("name", "broken.step", "part 30.step"),
        ("status", "broken.step", "part 1.step"),
        ("faces", "part 30.step", "part 1.step"),
        ("seconds", "slow.step", "broken.step"),
        ("memory", "part 20.step", "part 1.step"),
        ("size", "part 1.step", "slow.step"),
    ],
)
def test_each_order_and_its_reverse(read: Any, gallery: str, key: str, first: str, turned: str) -> None:
    reader = read(gallery)
    reader.page.select_option("#sort", key)
    assert reader.names[0] == first
    reader.page.click("#direction")
    assert reader.names[0] == turned
    assert reader.hash(f"sort=-{key}") == f"#sort=-{key}"


def test_a_click_opens_the_large_picture_with_its_facts(read: Any, gallery: str) -> None:
    reader = read(gallery)
    reader.page.click("text=part 5.step")
    assert reader.open
    image = reader.page.locator("#detail-picture img")
    assert image.get_attribute("src") == "pictures/part%205.step.png"
    assert image.evaluate("image => image.decode().then(() => image.naturalWidth)") == 64
    facts = reader.page.locator("#detail-facts").inner_text()
    for part in (
        "partial",
        "1 face not drawn: #12: open loop",
        "/in/part 5.step",
        "0.28 s",
        f"{4:064x}",
        "996 B",
    ):
        assert part in facts or part == "0.28 s", part
    found = dict(
        zip(*(reader.page.locator(f"dl {tag}").all_text_contents() for tag in ("dt", "dd")), strict=True)
    )
    assert (found["Faces drawn"], found["Faces not drawn"]) == ("49", "1")
    assert (found["Time"], found["Peak memory"]) == ("2.80 s", "15.0 MiB")
    reader.page.click("#close")
    assert not reader.open


def test_a_failed_file_has_a_tile_and_facts_with_its_reason(read: Any, gallery: str) -> None:
    reader = read(gallery)
    assert reader.page.locator(".tile.failed .why").all_text_contents() == [
        "the reader crashed (SIGSEGV)",
        "time limit of 30 s",
    ]
    reader.page.click("text=slow.step")
    assert "time limit of 30 s" in reader.page.locator("#detail-facts").inner_text()
    assert reader.page.locator("#detail img").count() == 0


def test_everything_works_by_keyboard(read: Any, gallery: str) -> None:
    reader = read(gallery)
    press = reader.page.keyboard.press
    press("ArrowDown")  # nothing has the focus yet
    assert reader.page.evaluate("document.activeElement.id") == "grid" and reader.active() == "broken.step"
    columns = int(reader.page.locator("#grid").get_attribute("aria-colcount"))
    press("ArrowRight")
    assert reader.active() == "slow.step"
    press("ArrowDown")
    assert reader.active() == f"part {columns}.step"
    press("ArrowUp")
    assert reader.active() == "slow.step"
    outline = reader.page.locator(".tile.active .plate").evaluate(
        "plate => getComputedStyle(plate).outlineStyle"
    )
    assert outline == "solid"
    press("End")
    assert reader.active() == "part 30.step"
    assert reader.page.locator("#grid").get_attribute("aria-activedescendant") == "tile-31"
    press("Home")
    press("Enter")
    name = reader.page.locator("#detail-name")
    assert reader.open and name.text_content() == "broken.step"
    press("ArrowLeft")
    assert name.text_content() == "broken.step"
    press("ArrowRight")
    press("ArrowRight")
    assert name.text_content() == "part 1.step"
    assert reader.page.locator("#detail-place").text_content() == "3 of 32"
    press("Escape")
    assert not reader.open and reader.active() == "part 1.step"
    assert reader.page.evaluate("document.activeElement.id") == "grid"
    press("/")
    assert reader.page.evaluate("document.activeElement.id") == "search"
    press("ArrowDown")
    assert reader.page.evaluate("document.activeElement.id") == "grid"


def test_every_control_is_reached_by_tab_and_named(read: Any, gallery: str) -> None:
    reader = read(gallery)
    reached = []
    for _ in range(20):
        reader.page.keyboard.press("Tab")
        reached.append(reader.page.evaluate("document.activeElement.id || document.activeElement.className"))
        if reached[-1] == "grid":
            break
    chips = [f"chip {status}" for status in STATUSES]
    assert reached == ["theme", "search", *chips, "least", "most", "sort", "direction", "tiles", "grid"]
    tree = reader.page.locator("body").aria_snapshot()
    for part in (
        'searchbox "Search names and reasons"',
        'grid "Pictures"',
        "gridcell",
        'combobox "Sort"',
        "status",
    ):
        assert part in tree, part


def test_the_address_holds_the_state(read: Any, gallery: str) -> None:
    reader = read(gallery)
    reader.page.fill("#search", "part & 1")
    reader.page.fill("#search", "part 1")
    reader.page.fill("#least", "20")
    reader.page.fill("#most", "160")
    reader.page.click(".chip.blank")
    reader.page.click(".chip.complete")
    reader.page.select_option("#sort", "seconds")
    reader.page.click("#direction")
    reader.page.select_option("#tiles", "small")
    reader.page.locator(".tile").nth(1).click()
    hash = reader.hash("open=")
    name = reader.page.locator("#detail-name").text_content()
    reader.page.keyboard.press("Escape")
    other = read(gallery, hash)
    assert other.open and other.page.locator("#detail-name").text_content() == name
    other.page.keyboard.press("Escape")
    assert other.names == reader.names and len(other.names) == 6
    for control in ("#search", "#least", "#most", "#sort", "#tiles"):
        assert other.page.input_value(control) == reader.page.input_value(control)
    assert other.page.locator("[aria-pressed=true].chip").count() == 2
    other.page.evaluate("location.hash = 'status=failed&sort=nonsense&faces=x&tiles=__proto__&open=none'")
    other.page.wait_for_function("document.getElementById('count').textContent.startsWith('2 of')")
    assert other.names == ["broken.step", "slow.step"] and not other.open


def luminance(reader: Reader, selector: str, property: str) -> float:
    color = reader.page.locator(selector).first.evaluate("(e, p) => getComputedStyle(e)[p]", property)
    return sum(float(x) for x in re.findall(r"[\d.]+", color)[:3]) / 765


def test_dark_is_what_the_system_asks_for_or_the_reader(read: Any, gallery: str) -> None:
    for scheme in ("light", "dark"):
        reader = read(gallery, color_scheme=scheme)
        dark = scheme == "dark"
        assert (luminance(reader, "body", "backgroundColor") < 0.2) == dark
        assert (luminance(reader, "body", "color") > 0.8) == dark
        reader.page.click("#theme")
        assert (luminance(reader, "body", "backgroundColor") < 0.2) != dark
        reader.page.reload()
        assert (luminance(reader, "body", "backgroundColor") < 0.2) != dark  # it is remembered
        reader.page.click("#theme")
        assert (luminance(reader, "body", "backgroundColor") < 0.2) == dark


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("hostile <b>#%41'\"")
    outcomes = [make(folder, name, drawn=1) for name in HOSTILE]
    reason = "<img src=x onerror=window.hacked=1>\n</script>"
    outcomes += [make(folder, f"failed {name}", "failed", reason=f"{name}: {reason}") for name in HOSTILE]
    return write_gallery(folder, outcomes)


def test_hostile_names_are_text_and_their_pictures_are_found(read: Any, hostile: str) -> None:
    reader = read(hostile)
    assert reader.count == "20 files"
    sizes = reader.page.evaluate(
        "Promise.all([...document.querySelectorAll('.tile img')]"
        ".map(image => image.decode().then(() => image.naturalWidth)))"
    )
    assert sizes == [64] * len(HOSTILE)
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
    assert read(hostile, link).names == reader.names
    reader.page.evaluate("location.hash = 'q=<img src=x onerror=window.hacked=1>&open=<b>'")
    reader.page.wait_for_function("document.getElementById('search').value.includes('<img')")
    for page in (reader.page, read(hostile, link).page):
        assert page.evaluate("window.hacked") is None
    assert reader.page.locator("#grid script, #grid b, .tile img[src=x]").count() == 0


def test_a_picture_that_is_gone_is_told(read: Any, tmp_path: Path) -> None:
    there = make(tmp_path, "there.step", drawn=1)
    page = write_gallery(
        tmp_path, [there, replace(there, path=f"{tmp_path}/in/gone.step", target=f"{tmp_path}/g.png")]
    )
    reader = read(page)
    reader.page.wait_for_selector(".plate.empty")
    assert reader.page.locator(".plate.empty").text_content().startswith("Picture missing")
    assert len(reader.errors) == 1 and "ERR_FILE_NOT_FOUND" in reader.errors.pop()


def test_empty_and_all_failed_batches(read: Any, tmp_path: Path) -> None:
    reader = read(write_gallery(tmp_path, []))
    assert reader.count == "0 files"
    assert reader.page.locator("#none").text_content() == "The batch holds no files."
    failed = [make(tmp_path, f"{i}.step", "failed", reason="empty") for i in range(3)]
    reader = read(write_gallery(tmp_path, failed))
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


def test_ten_thousand_entries_keep_the_document_small(read: Any, large: str) -> None:
    reader = read(large)
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
    reader.page.fill("#search", "part_0777")
    assert reader.names == [f"part_0777{i}.step" for i in range(10)]
    assert reader.page.locator(".tile").first.is_visible()  # scrolled back to the results
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


def test_the_grid_shows_the_pictures_themselves(read: Any, tmp_path: Path, samples_dir: Path) -> None:
    import trimray

    settings = Settings(size=(128, 128))
    outcomes = []
    for name in ("bracket.step", "teapot.step"):
        target = tmp_path / f"{name}.png"
        trimray.load(samples_dir / name).render(size=settings.size).save(target)
        outcomes.append(Outcome(str(samples_dir / name), str(target), "complete", drawn=1))
    reader = read(write_gallery(tmp_path, outcomes, settings=settings), color_scheme="light")
    drawn = [Path(outcome.target).read_bytes() for outcome in outcomes]
    for index in range(2):
        image = reader.page.locator(".tile img").nth(index)
        image.evaluate("image => image.decode()")
        shown = pixels_of(image.screenshot())
        own, other = (likeness(shown, drawn[which]) for which in (index, 1 - index))
        assert own > 0.97 > 0.9 > other


def likeness(shown: np.ndarray[Any, np.dtype[np.uint8]], png: bytes) -> float:
    """How a part of the screen and a picture correlate, the picture scaled as the browser scaled it."""
    from PIL import Image

    height, width = shown.shape[:2]
    picture = np.asarray(Image.fromarray(pixels_of(png)).resize((width, height)))
    return float(np.corrcoef(shown.ravel(), picture.ravel())[0, 1])


def test_narrow_and_zoomed_windows_need_no_sideways_scrolling(read: Any, gallery: str) -> None:
    for width, height in ((320, 640), (640, 360)):  # a phone; 1280 x 720 at 200 %
        reader = read(gallery, viewport={"width": width, "height": height})
        assert reader.page.evaluate("document.documentElement.scrollWidth") <= width
        assert int(reader.page.locator("#grid").get_attribute("aria-colcount")) >= 2
        reader.page.locator(".tile").nth(3).click()
        close = reader.page.locator("#close").bounding_box()
        assert close["x"] + close["width"] <= width and close["y"] >= 0


def test_the_print_holds_all_tiles_and_no_controls(read: Any, gallery: str) -> None:
    reader = read(gallery, color_scheme="dark")
    reader.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    reader.page.emulate_media(media="print")
    assert reader.page.locator(".tile").count() == 32
    assert not reader.page.locator("#search").is_visible()
    assert luminance(reader, "body", "color") < 0.2
    reader.page.emulate_media(media="screen")
    reader.page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert reader.page.locator("#search").is_visible()
