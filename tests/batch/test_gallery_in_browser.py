"""The gallery as a reader uses it: headless Chromium on a file:// page, by mouse and by keyboard."""

from __future__ import annotations

from typing import Any

from tests.pages import luminance
from trimray.batch.record import STATUSES


def test_all_files_are_shown_by_name(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    assert reader.count == "32 files"
    assert reader.names[:4] == ["broken.step", "slow.step", "part 1.step", "part 2.step"]
    assert reader.names[-1] == "part 30.step"  # numbers count as numbers
    assert reader.page.title() == "Parts"


def test_search_narrows_as_one_types(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
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


def test_each_status_is_a_filter_with_its_count(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    for status, number in {"complete": 27, "partial": 1, "degraded": 1, "blank": 1, "failed": 2}.items():
        chip = reader.page.locator(f".chip.{status}")
        assert chip.text_content() == f"{status} {number}"
        chip.click()
        assert chip.get_attribute("aria-pressed") == "true"
        assert reader.count == f"{number} of 32 files", status
        assert reader.page.locator(f".tile:not(.{status})").count() == 0
        chip.click()
        assert reader.count == "32 files"


def test_filters_add_up_and_count_what_the_others_leave(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    reader.page.click(".chip.failed")
    reader.page.click(".chip.blank")
    assert reader.names == ["broken.step", "slow.step", "part 15.step"]
    reader.page.fill("#search", "part")
    assert reader.names == ["part 15.step"]
    assert reader.page.locator(".chip.failed").text_content() == "failed 0"
    assert reader.page.locator(".chip.complete").text_content() == "complete 27"


def test_faces_are_filtered_by_a_range(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    reader.page.fill("#least", "50")
    assert reader.count == "26 of 32 files"
    reader.page.fill("#most", "70")
    assert reader.names == ["part 5.step", "part 6.step", "part 7.step"]
    reader.page.fill("#least", "")
    assert len(reader.names) == 7  # failed files have no number of faces


def test_each_order_and_its_reverse(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    for key, first, last in (
        ("status", "broken.step", "part 1.step"),
        ("faces", "part 30.step", "part 1.step"),
        ("seconds", "slow.step", "broken.step"),
        ("memory", "part 20.step", "part 1.step"),
        ("size", "part 1.step", "slow.step"),
        ("name", "broken.step", "part 30.step"),
    ):
        reader.page.select_option("#sort", key)
        assert reader.names[0] == first, key
        reader.page.click("#direction")
        assert reader.names[0] == last, key
        assert reader.hash(f"sort=-{key}") == f"#sort=-{key}"


def test_a_click_opens_the_large_picture_with_its_facts(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    reader.page.click("text=part 5.step")
    assert reader.open
    image = reader.page.locator("#detail-picture img")
    assert image.get_attribute("src") == "pictures/part%205.step.png"
    assert image.evaluate("image => image.decode().then(() => image.naturalWidth)") == 64
    facts = reader.page.locator("#detail-facts").inner_text()
    for part in (
        "partial",
        "1 face not drawn: #12: open loop",
        "Path\nin/part 5.step",
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


def test_a_failed_file_has_a_tile_and_facts_with_its_reason(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    assert reader.page.locator(".tile.failed .why").all_text_contents() == [
        "the reader crashed (SIGSEGV)",
        "time limit of 30 s",
    ]
    reader.page.click("text=slow.step")
    assert "time limit of 30 s" in reader.page.locator("#detail-facts").inner_text()
    assert reader.page.locator("#detail img").count() == 0


def test_everything_works_by_keyboard(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
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


def test_every_control_is_reached_by_tab_and_named(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
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


def test_the_address_holds_the_state(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
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
    other = open_page(gallery, hash)
    assert other.open and other.page.locator("#detail-name").text_content() == name
    other.page.keyboard.press("Escape")
    assert other.names == reader.names and len(other.names) == 6
    for control in ("#search", "#least", "#most", "#sort", "#tiles"):
        assert other.page.input_value(control) == reader.page.input_value(control)
    assert other.page.locator("[aria-pressed=true].chip").count() == 2
    for name in ("part 12.step", "part 13.step"):  # another address on the same page
        other.page.evaluate("name => { location.hash = `q=part&open=${encodeURIComponent(name)}`; }", name)
        other.page.wait_for_function(
            "name => document.getElementById('detail-name').textContent === name", arg=name
        )
        other.page.wait_for_timeout(300)
        assert other.open and "open=part" in other.page.evaluate("location.hash")
    other.page.evaluate("location.hash = 'status=failed&sort=nonsense&faces=x&tiles=__proto__&open=none'")
    other.page.wait_for_function("document.getElementById('count').textContent.startsWith('2 of')")
    assert other.names == ["broken.step", "slow.step"] and not other.open


def test_dark_is_what_the_system_asks_for_or_the_reader(open_page: Any, gallery: str) -> None:
    for scheme in ("light", "dark"):
        reader = open_page(gallery, color_scheme=scheme)
        dark = scheme == "dark"
        assert (luminance(reader, "body", "backgroundColor") < 0.2) == dark
        assert (luminance(reader, "body", "color") > 0.8) == dark
        reader.page.click("#theme")
        assert (luminance(reader, "body", "backgroundColor") < 0.2) != dark
        reader.page.reload()
        assert (luminance(reader, "body", "backgroundColor") < 0.2) != dark  # it is remembered
        reader.page.click("#theme")
        assert (luminance(reader, "body", "backgroundColor") < 0.2) == dark


def test_a_search_keeps_the_pictures_that_stay(open_page: Any, gallery: str) -> None:
    reader = open_page(gallery)
    image = reader.page.locator(".tile:has-text('part 3.step') img")
    image.evaluate("image => { image.mark = 1; }")
    reader.page.fill("#search", "part 3")
    assert image.evaluate("image => image.mark") == 1
    assert reader.names == ["part 3.step", "part 13.step", "part 23.step", "part 30.step"]
    assert reader.page.locator("#tile-0 .name").text_content() == "part 3.step"
