"""What the page says, without a browser: its data, its safety, its size."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

from trimray import OutputError
from trimray.batch.gallery import check_gallery, write_gallery
from trimray.batch.record import STATUSES, Outcome, Settings


def outcome(folder: Path, name: str, status: str = "complete", **facts: object) -> Outcome:
    target = folder / f"{name}.png"
    return Outcome(str(folder / "in" / name), str(target), status, **facts)  # type: ignore[arg-type]


def data_of(page: Path) -> dict[str, list[list[object]]]:
    text = page.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert found is not None
    data: dict[str, list[list[object]]] = json.loads(found[1])
    return data


def test_the_page_tells_every_fact(tmp_path: Path) -> None:
    facts = {"sha256": "ab" * 32, "seconds": 1.23456, "peak_memory": 3 << 20, "covered": 0.25}
    part = outcome(tmp_path, "part.step", "partial", drawn=7, not_drawn=2, reason="2 faces", **facts)
    path = write_gallery(tmp_path, [part], sizes={part.path: 99})
    assert path == str(tmp_path / "index.html")
    rows = data_of(tmp_path / "index.html")["rows"]
    assert rows == [["part.step", "part.step.png", 1, 7, 2, 1.235, 3.0, 99, 0.25, "ab" * 32, "2 faces"]]


def test_equal_outcomes_give_equal_bytes_in_any_order(tmp_path: Path) -> None:
    outcomes = [outcome(tmp_path, f"{i}.step", STATUSES[i % 5]) for i in range(20)]
    page = Path(write_gallery(tmp_path, outcomes))
    first = page.read_bytes()
    write_gallery(tmp_path, reversed(outcomes))
    assert page.read_bytes() == first


def test_links_are_relative_and_escaped(tmp_path: Path) -> None:
    names = [
        "a b",
        "q\"'",
        "n\nl",
        "#1?x",
        "100%",
        "é",
        "javascript:alert(1)",
        "&lt;",
        os.fsdecode(b"caf\xe9"),
    ]
    page = Path(write_gallery(tmp_path, [outcome(tmp_path, name) for name in names]))
    links = {str(row[0]): row[1] for row in data_of(page)["rows"]}
    assert links == {
        "a b": "a%20b.png",
        "q\"'": "q%22%27.png",
        "n\\nl": "n%0Al.png",
        "#1?x": "%231%3Fx.png",
        "100%": "100%25.png",
        "é": "%C3%A9.png",
        "javascript:alert(1)": "javascript%3Aalert%281%29.png",
        "&lt;": "%26lt%3B.png",
        "caf\\xe9": "caf%E9.png",
    }


def test_pictures_outside_of_the_folder_are_linked_upwards(tmp_path: Path) -> None:
    (tmp_path / "page").mkdir()
    page = Path(write_gallery(tmp_path / "page", [outcome(tmp_path, "a.step")]))
    assert data_of(page)["rows"][0][1] == "../a.step.png"


def test_a_failed_file_has_no_link_and_its_reason_not_its_path_twice(tmp_path: Path) -> None:
    path = str(tmp_path / "in" / "a.step")
    failed = outcome(tmp_path, "a.step", "failed", exit_code=3, reason=f"{path}: empty")
    row = data_of(Path(write_gallery(tmp_path, [failed])))["rows"][0]
    assert row[1] == "" and row[-1] == "empty"
    blank = outcome(tmp_path, "a.step", "blank", reason="blank: no pixel")
    assert data_of(Path(write_gallery(tmp_path, [blank])))["rows"][0][-1] == "no pixel"


def test_nobody_learns_where_the_folders_lie(tmp_path: Path) -> None:
    secret = tmp_path / "of somebody"
    (secret / "out").mkdir(parents=True)
    paths = [f"{secret}/lib/{name}" for name in ("a.step", "sub/b.step")]
    failed = Outcome(
        paths[1], "", "failed", reason=f"{secret}/lib/sub/c.step: missing; {secret}/out/b.png: not written"
    )
    drawn = Outcome(paths[0], f"{secret}/out/a.png", "complete")
    page = Path(write_gallery(secret / "out", [drawn, failed]))
    assert "of somebody" not in page.read_text(encoding="utf-8")
    data = data_of(page)
    assert data["root"] == "lib" and [row[0] for row in data["rows"]] == ["a.step", "sub/b.step"]
    assert data["rows"][1][-1] == "sub/c.step: missing; b.png: not written"


def test_no_name_ends_the_script_or_the_title(tmp_path: Path) -> None:
    hostile = "</script><script>alert(1)</script><!--{{script}}\u2028\u202e"
    reason = "</title></script>{{data}}"
    bad = Outcome(f"/in/{hostile}", f"{tmp_path}/{hostile}.png", "failed", reason=reason)
    plain = Outcome("/plain.step", f"{tmp_path}/plain.png", "complete")  # so that paths begin at "/"
    page = Path(write_gallery(tmp_path, [bad, plain], title=f"</title><b>{hostile}"))
    text = page.read_text(encoding="utf-8")
    assert text.count("</script>") == 2 and text.count("</title>") == 1
    assert "\u2028" not in text and "\u202e" not in text and "<b>" not in text
    row = data_of(page)["rows"][0]
    assert row[0] == "in/</script><script>alert(1)</script><!--{{script}}\\u2028\\u202e" and row[-1] == reason


def test_a_page_of_ten_thousand_weighs_less_than_4_mb(tmp_path: Path) -> None:
    def make(i: int) -> Outcome:
        name = f"vendor_{i % 37:03}/assembly_{i % 101:04}/Part-{i:06}_M8x40_DIN_EN_ISO_4762.step"
        reason = (
            "not drawn: face 12 (BSpline surface): its trim loop is open by 0.25 mm" if i % 4 == 0 else ""
        )
        status = STATUSES[i % 4 == 0]
        return outcome(
            tmp_path,
            name,
            status,
            sha256=f"{i:064x}",
            seconds=i / 7,
            drawn=i,
            reason=reason,
            peak_memory=i << 20,
        )

    page = Path(write_gallery(tmp_path, (make(i) for i in range(10_000))))
    assert page.stat().st_size < 4_000_000
    small = Path(write_gallery(tmp_path, (make(i) for i in range(300))))
    assert small.stat().st_size < 160_000


def test_an_empty_batch_has_a_page(tmp_path: Path) -> None:
    assert data_of(Path(write_gallery(tmp_path, [], settings=Settings())))["rows"] == []


def test_a_page_of_someone_else_stays(tmp_path: Path) -> None:
    page = tmp_path / "index.html"
    page.write_text("<html>mine</html>")
    with pytest.raises(OutputError, match=r"index\.html: not written: it is there already"):
        check_gallery(tmp_path)
    with pytest.raises(OutputError):
        write_gallery(tmp_path, [])
    assert page.read_text() == "<html>mine</html>"


def test_what_is_no_file_stays(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "index.html")
    with pytest.raises(OutputError, match="it is there already"):
        check_gallery(tmp_path)


def test_a_folder_that_is_missing_is_told(tmp_path: Path) -> None:
    check_gallery(tmp_path / "none")
    with pytest.raises(OutputError, match="not written"):
        write_gallery(tmp_path / "none", [])


def test_nothing_of_the_page_is_elsewhere(tmp_path: Path) -> None:
    text = Path(write_gallery(tmp_path, [outcome(tmp_path, "a")])).read_text(encoding="utf-8")
    assert not re.search(r"https?://|@import|url\(|innerHTML|eval\(", text)
    assert "default-src 'none'" in text and "unsafe" not in text
