"""One file to one picture: what is said of it, and what is done when time, memory or contrast is short."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trimray
from trimray.batch import draw as module
from trimray.batch.draw import draw_file, hash_file, picture_of
from trimray.batch.pool import draw_all
from trimray.batch.record import Item, Outcome, Settings
from trimray.batch.visible import visible
from trimray.frame import Frame
from trimray.importer.forked import peak_bytes

from . import measured_draw

SMALL = Settings(size=(64, 64), samples=1, time_limit=60.0)
SOLID = "solid a\n{}endsolid a\n"
FACET = "facet normal 0 0 1\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n"


def draw(path: Path | str, target: Path, settings: Settings = SMALL) -> Outcome:
    return draw_file(Item(str(path), str(target)), settings)


@pytest.fixture
def bracket(samples_dir: Path) -> Path:
    return samples_dir / "bracket.step"


def test_a_picture_equals_that_of_render(bracket: Path, tmp_path: Path) -> None:
    target = tmp_path / "new" / "folder" / "bracket.png"
    outcome = draw(bracket, target)
    assert (outcome.status, outcome.exit_code, outcome.reason) == ("complete", 0, "")
    assert outcome.sha256 == hashlib.sha256(bracket.read_bytes()).hexdigest()
    assert (outcome.drawn, outcome.not_drawn) == (41, 0)
    assert 0.2 < outcome.covered < 0.9
    assert outcome.peak_memory > 50 << 20 and outcome.seconds > 0
    frame = trimray.load(bracket, cache=False).render((64, 64), samples=1)
    frame.save(tmp_path / "render.png")
    assert target.read_bytes() == (tmp_path / "render.png").read_bytes()
    assert os.listdir(target.parent) == ["bracket.png"]


@pytest.mark.parametrize("format", ["png", "webp", "jpg", "exr"])
def test_formats(bracket: Path, tmp_path: Path, format: str) -> None:
    settings = replace(SMALL, format=format)
    assert draw(bracket, tmp_path / "picture", settings).status == "complete"
    heads = {"png": b"\x89PNG", "webp": b"RIFF", "jpg": b"\xff\xd8", "exr": b"v/1\x01"}
    assert (tmp_path / "picture").read_bytes().startswith(heads[format])


def test_what_cannot_be_read_is_one_line_without_the_path(tmp_path: Path) -> None:
    (tmp_path / "empty.step").touch()
    (tmp_path / "folder.step").mkdir()
    (tmp_path / "text.txt").write_text("hello")
    (tmp_path / "two\nlines.step").write_text("ISO-10303-21;\nHEADER;\n")
    os.mkfifo(tmp_path / "pipe.step")
    for name, reason in [
        ("empty.step", "empty"),
        ("folder.step", "is a directory"),
        ("missing.step", "No such file or directory"),
        ("pipe.step", "not a regular file"),
        ("text.txt", "not a STEP, IGES or BREP file"),
        ("two\nlines.step", "truncated"),
    ]:
        outcome = draw(tmp_path / name, tmp_path / "out.png")
        assert (outcome.status, outcome.exit_code) == ("failed", 3), name
        assert outcome.reason.lower().startswith(reason.lower()), outcome.reason
        assert "\n" not in outcome.reason and str(tmp_path) not in outcome.reason
    assert not (tmp_path / "out.png").exists()


def test_paths_of_any_bytes(bracket: Path, tmp_path: Path) -> None:
    path = os.path.join(tmp_path, os.fsdecode(b"\xff \"'\n\xc3\xa4.step"))
    shutil.copy(bracket, path)
    assert draw(path, Path(path + ".png")).status == "complete"
    assert os.path.exists(path + ".png")


def test_a_target_that_cannot_be_written_is_code_4(bracket: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    outcome = draw(bracket, tmp_path / "file" / "out.png")
    assert (outcome.status, outcome.exit_code) == ("failed", 4)
    assert "not written" in outcome.reason


def test_memory_of_reading_and_of_drawing_is_limited(bracket: Path, tmp_path: Path) -> None:
    reading = draw(bracket, tmp_path / "out.png", replace(SMALL, memory_limit=1 << 20))
    assert reading.exit_code == 5
    # Memory is looked at from time to time: how far reading came until then is chance.
    assert re.fullmatch(r"cannot be read within 1 MiB \(stage '\w+'\)", reading.reason), reading.reason
    # The reader is a copy of this process, whose memory counts as the reader's.
    limit = (peak_bytes() >> 20) + 800
    large = replace(SMALL, size=(16384, 16384), memory_limit=limit << 20)
    drawing = draw(bracket, tmp_path / "out.png", large)
    assert (drawing.exit_code, drawing.reason) == (5, f"cannot be drawn within {limit} MiB")
    assert not (tmp_path / "out.png").exists()
    # The process is none the worse for it.
    assert draw(bracket, tmp_path / "out.png").status == "complete"


def _slow(monkeypatch: pytest.MonkeyPatch, *, heal: tuple[str, ...] = (), draws: int = 0) -> list[Any]:
    """Reading with these repairs, and the first so many drawings, take longer than they may. Returns the
    limits that were given."""
    limits: list[Any] = []
    load, render = module.load, trimray.Model.render

    def slow_load(*args: Any, **words: Any) -> trimray.Model:
        limits.append(words["time_limit"])
        if words["heal"] in heal:
            raise trimray.TimeLimitError("slow")
        return load(*args, **words | {"time_limit": None})

    def slow_render(*args: Any, **words: Any) -> Frame:
        limits.append(words["time_limit"])
        if len([x for x in limits if x is not None]) and draws >= (rendered := len(done) + 1):
            done.append(rendered)
            raise trimray.TimeLimitError("slow")
        return render(*args, **words | {"time_limit": None})

    done: list[int] = []
    monkeypatch.setattr(module, "load", slow_load)
    monkeypatch.setattr(trimray.Model, "render", slow_render)
    return limits


def test_reading_without_repairs_is_degraded(
    bracket: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    limits = _slow(monkeypatch, heal=("default",))
    outcome = draw(bracket, tmp_path / "out.png")
    assert (outcome.status, outcome.exit_code) == ("degraded", 1)
    assert outcome.reason == "read without repairs, for want of time"
    assert outcome.drawn == 41 and (tmp_path / "out.png").exists()
    assert 30 < limits[0] < 45 and 45 < limits[1] <= 60 * 0.85


def test_a_coarse_picture_has_the_size_that_was_asked_for(
    bracket: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _slow(monkeypatch, draws=1)
    picture = picture_of(str(bracket), replace(SMALL, size=(61, 45)))
    assert picture.degraded == "drawn at 16 x 12 px, for want of time"
    assert picture.frame["color"].shape == (45, 61, 4)
    assert not picture.visible.blank


def test_no_picture_within_the_time_is_code_5(
    bracket: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        _slow(patch, heal=("default", "off"))
        reading = draw(bracket, tmp_path / "out.png")
    assert (reading.exit_code, reading.reason) == (5, "not read, nor without repairs within 60 s")
    with monkeypatch.context() as patch:
        _slow(patch, draws=2)
        drawing = draw(bracket, tmp_path / "out.png")
    assert (drawing.exit_code, drawing.reason) == (5, "not drawn within 60 s")
    assert not (tmp_path / "out.png").exists()


def test_a_real_limit_of_time_is_kept(bracket: Path, tmp_path: Path) -> None:
    outcome = draw(bracket, tmp_path / "out.png", replace(SMALL, time_limit=0.002))
    assert (outcome.status, outcome.exit_code) == ("failed", 5)


def test_damage_is_partial(bracket: Path, tmp_path: Path) -> None:
    text = bracket.read_text()
    line = next(x for x in text.splitlines() if "=PLANE(" in x.replace(" ", ""))
    (tmp_path / "damaged.step").write_text(text.replace(line, line.split("=")[0] + "=NONSENSE();"))
    outcome = draw(tmp_path / "damaged.step", tmp_path / "out.png")
    assert (outcome.status, outcome.exit_code) == ("partial", 1)
    assert outcome.reason and outcome.covered > 0.1


def test_a_rod_500_times_as_long_as_thick_is_not_blank(tmp_path: Path) -> None:
    rod = tmp_path / "rod.stl"
    corners = ("0 0 0", "1000 0 0", "1000 2 2")
    rod.write_text(SOLID.format(FACET.format(*corners) + FACET.format("0 0 0", "1000 2 2", "0 2 2")))
    outcome = draw(rod, tmp_path / "out.png", replace(SMALL, size=(256, 256), samples=4))
    assert outcome.status == "complete"
    assert 0.0005 < outcome.covered < 0.02


def test_a_hair_is_blank(tmp_path: Path) -> None:
    hair = tmp_path / "hair.stl"
    hair.write_text(SOLID.format(FACET.format("0 0 0", "100 100 100", "100 100 100.0001")))
    outcome = draw(hair, tmp_path / "out.png")
    assert (outcome.status, outcome.exit_code) == ("blank", 1)
    assert "blank" in outcome.reason and outcome.covered < 0.001
    assert (tmp_path / "out.png").exists()


def _frame(shade: float, background: float, pixels: int, alpha: float = 1.0) -> Frame:
    color = np.full((100, 100, 4), background, np.float32)
    color[..., 3] = alpha
    face = np.full((100, 100), -1, np.int32)
    color.reshape(-1, 4)[:pixels] = (shade, shade, shade, 1.0)
    face.reshape(-1)[:pixels] = 0
    return Frame({"color": color, "face": face}, (100, 100))


def test_a_part_in_the_colour_of_its_background_is_blank() -> None:
    white = visible(_frame(0.99, 1.0, 4000), "white")
    assert white.blank and white.covered == 0.4 and white.seen == 0.0
    assert "in the background's colour" in white.reason
    assert not visible(_frame(0.95, 1.0, 4000), "white").blank
    assert not visible(_frame(0.99, 0.0, 4000), "black").blank
    assert not visible(_frame(1.0, 0.0, 4000, alpha=0.0), "transparent").blank
    assert visible(_frame(0.5, 0.5, 4000), "#808080").blank


def test_a_gradient_is_no_part(bracket: Path) -> None:
    picture = picture_of(str(bracket), replace(SMALL, background="white,navy"))
    alone = picture_of(str(bracket), SMALL)
    assert picture.visible.covered == pytest.approx(alone.visible.covered, abs=0.03)
    assert not picture.visible.blank


def test_hash_of_an_empty_file(tmp_path: Path) -> None:
    (tmp_path / "empty").touch()
    assert hash_file(str(tmp_path / "empty")) == hashlib.sha256(b"").hexdigest()


def test_a_worker_does_not_grow(samples_dir: Path, tmp_path: Path) -> None:
    """45 files in one worker, of three kinds: after 15 it has what it needs."""
    files = [samples_dir / name for name in ("patch.step", "stand.stl", "bracket.brep")]
    items = [Item(str(files[n % 3]), str(tmp_path / f"{n % 3}.png")) for n in range(45)]
    outcomes = list(draw_all(items, SMALL, 1, draw=measured_draw.measured, max_files=None))
    assert [o.status for o in outcomes] == ["complete"] * 45
    facts = [json.loads(o.reason) for o in outcomes]
    for kind in ("rss", "anonymous"):
        assert facts[-1][kind] < 1.2 * facts[14][kind] + (16 << 20), kind
