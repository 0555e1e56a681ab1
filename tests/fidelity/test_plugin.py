"""The assertions and the pytest plugin, as people use them in their own test suites."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cadquery as cq
import numpy as np
import pytest

import trimray
from trimray.fidelity import colors, golden, pictures, pytest_plugin, running
from trimray.fidelity.running import Running
from trimray.image_io import decode
from trimray.testing import assert_matches_picture, assert_roundtrip, assert_same_geometry

ROOT = Path(__file__).resolve().parents[2]
SIZE = (100, 80)
SMALL: dict[str, Any] = {"views": ["iso"], "size": (64, 64), "points": 500}


def part(radius: float = 4.0, moved: float = 0.0) -> cq.Workplane:
    """A plate of 40 x 30 x 10 mm with a bore. moved: mm, of its top face."""
    return cq.Workplane().box(40, 30, 10 + moved).faces(">Z").workplane().hole(2 * radius)


def message_of(call: Callable[[], None]) -> str:
    with pytest.raises(AssertionError) as caught:
        call()
    return str(caught.value)


def saved(here: Running) -> set[str]:
    """Names of the files that the latest failure has left."""
    folder = here.root / str(here.notes[-1][1])
    return {file.name for file in folder.iterdir()}


PROJECT = """
import os
import cadquery as cq
from trimray.testing import assert_matches_picture, assert_same_geometry

RADIUS = float(os.environ.get("RADIUS", "4"))

def part(radius):
    return cq.Workplane().box(40, 30, 10).faces(">Z").workplane().hole(2 * radius)

def test_picture():
    assert_matches_picture(part(RADIUS), "golden/part.png", size=(100, 80))

def test_other_picture():
    assert_matches_picture(part(3.0), "golden/small.png", view="top", size=(64, 64))

def test_files(tmp_path):
    a, b = tmp_path / "a.step", tmp_path / "b.step"
    cq.exporters.export(part(4.0), str(a))
    cq.exporters.export(part(RADIUS), str(b))
    assert_same_geometry(a, b, views=["iso"], size=(64, 64), points=500)
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "suite").mkdir()
    (tmp_path / "suite" / "test_part.py").write_text(PROJECT)
    manual = (ROOT / "docs" / "testing.md").read_text()
    (example,) = re.findall(r"^```python\n(.*?)^```", manual, re.M | re.S)
    (tmp_path / "suite" / "test_manual.py").write_text(example)
    return tmp_path


def run_pytest(project: Path, *words: str, **environment: str) -> tuple[int, str]:
    installed = metadata.entry_points(group="pytest11", name="trimray")
    plugin = () if installed else ("-p", pytest_plugin.__name__)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *plugin, "--rootdir=.", *words],
        cwd=project,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | environment,
    )
    return done.returncode, done.stdout + done.stderr


def test_a_suite_as_a_user_writes_it(project: Path) -> None:
    """With --trimray-update; as it should be; then with another part, and a golden picture missing."""
    code, text = run_pytest(project, "-k", "picture or looks", "--trimray-update")
    assert code == 0 and "3 passed" in text, text
    assert "new: suite/golden/part.png" in text and "new: suite/golden/small.png" in text
    made = (project / "suite" / "golden" / "part.png").read_bytes()
    assert decode(made)[0].shape == (80, 100, 4)

    code, text = run_pytest(project)
    assert code == 0 and "6 passed" in text and "trimray:" not in text, text

    (project / "suite" / "golden" / "small.png").unlink()
    code, text = run_pytest(project, "suite/test_part.py", "--trimray-report=out", RADIUS="4.5")
    assert code == 1 and "3 failed" in text, text
    assert "suite/golden/small.png: there is no such golden picture" in text
    assert "pytest --trimray-update" in text and "asserts.py" not in text
    assert "part.png: changed:" in text and "(cylinder of Workplane) in" in text
    assert "b.step) against A (" in text and "trimray: failures" in text
    left = project / "out" / "suite-test_part.py-test_picture"
    assert {f.name for f in left.iterdir()} == {"part.golden.png", "part.now.png", "part.overlay.png"}
    assert (left / "part.golden.png").read_bytes() == made != (left / "part.now.png").read_bytes()
    assert (project / "out" / "suite-test_part.py-test_files" / "report.html").stat().st_size > 1000


@pytest.mark.skipif(importlib.util.find_spec("xdist") is None, reason="pytest-xdist is not installed")
def test_golden_pictures_are_written_by_several_processes(project: Path) -> None:
    code, text = run_pytest(project, "-k", "picture", "-n", "2", "--trimray-update")
    assert code == 0 and "new: suite/golden/part.png" in text and "new: suite/golden/small.png" in text, text
    code, text = run_pytest(project, "-k", "picture", "-n", "2", RADIUS="4.5")
    assert code == 1 and "1 failed, 1 passed" in text and "suite-test_part.py-test_picture" in text, text


def test_renewing_says_what_has_changed(test_folder: Running) -> None:
    path = test_folder.folder / "golden" / "a.png"
    test_folder.update = True
    assert_matches_picture(part(), "golden/a.png", size=SIZE)
    first = path.read_bytes(), path.stat().st_ino
    assert_matches_picture(part(), "golden/a.png", size=SIZE)
    assert (path.read_bytes(), path.stat().st_ino) == first
    assert_matches_picture(part(5.0), "golden/a.png", size=SIZE)
    assert path.read_bytes() != first[0]
    path.write_bytes(b"no picture")
    assert_matches_picture(part(), "golden/a.png", size=SIZE)
    assert path.read_bytes() == first[0]
    notes = [value for key, value in test_folder.notes if key == running.PICTURE]
    assert notes == ["new: tests/golden/a.png", *["renewed: tests/golden/a.png"] * 2]
    assert [file.name for file in path.parent.iterdir()] == ["a.png"]


def test_a_picture_says_which_face_is_wrong(test_folder: Running) -> None:
    test_folder.update = True
    assert_matches_picture(part(), "a.png", "top", SIZE)
    test_folder.update = False
    assert_matches_picture(part(), "a.png", "top", SIZE)
    text = message_of(lambda: assert_matches_picture(part(3.0), "a.png", "top", SIZE))
    wrong = int(text.split("changed: ")[1].split(" ")[0])
    assert "(plane of Workplane) in" in text and "run" not in text.splitlines()[0]
    assert saved(test_folder) == {"a.golden.png", "a.now.png", "a.overlay.png"}
    # As many pixels may differ, or by so much.
    assert_matches_picture(part(3.0), "a.png", "top", SIZE, pixels=wrong)
    message_of(lambda: assert_matches_picture(part(3.0), "a.png", "top", SIZE, pixels=wrong - 1))
    assert_matches_picture(part(3.0), "a.png", "top", SIZE, tolerance=255)
    text = message_of(lambda: assert_matches_picture(part(), "a.png", "top", (80, 80)))
    assert "100 x 80 px, the one made now 80 x 80 px" in text
    assert len({value for _, value in test_folder.notes}) == 4  # a folder each


def test_a_picture_of_another_version_says_so(test_folder: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    test_folder.update = True
    monkeypatch.setattr(golden, "made_by", lambda: "trimray 0.0.1")
    assert_matches_picture(part(), "a.png", size=SIZE)
    monkeypatch.undo()
    test_folder.update = False
    assert_matches_picture(part(), "a.png", size=SIZE)  # equal pixels are all that counts
    text = message_of(lambda: assert_matches_picture(part(5.0), "a.png", size=SIZE))
    assert f"the golden picture is of trimray 0.0.1, and this is {golden.made_by()}" in text


def test_what_cannot_be_written_is_one_line(test_folder: Running) -> None:
    (test_folder.folder / "file").write_text("")
    test_folder.update = True
    text = message_of(lambda: assert_matches_picture(part(), "file/a.png", size=SIZE))
    assert text == "tests/file/a.png: not written: File exists"
    test_folder.update = False
    test_folder.report = test_folder.folder / "file"
    text = message_of(lambda: assert_matches_picture(part(), "b.png", size=SIZE))
    assert "(tests/file: File exists)" in text
    assert saved(test_folder) == {"b.now.png"}
    # A folder of an earlier failure that cannot be written to any more.
    test_folder.report = test_folder.root / "out"
    (test_folder.report / test_folder.folder_name() / "b.now.png").mkdir(parents=True)
    test_folder.failures = 0
    text = message_of(lambda: assert_matches_picture(part(), "b.png", size=SIZE))
    assert "there is no such golden picture" in text and "(out: Is a directory)" in text
    assert saved(test_folder) == {"b.now.png"}


def test_broken_golden_pictures_are_one_line(test_folder: Running) -> None:
    test_folder.update = True
    assert_matches_picture(part(), "a.png", size=SIZE)
    test_folder.update = False
    sound = (test_folder.folder / "a.png").read_bytes()
    for data in (b"", b"GIF89a", sound[:40], sound[: len(sound) // 2]):
        (test_folder.folder / "a.png").write_bytes(data)
        text = message_of(lambda: assert_matches_picture(part(), "a.png", size=SIZE))
        assert text.startswith("tests/a.png: ") and "PNG" in text and "\n" not in text


def test_a_defect_is_found_and_its_report_saved(test_folder: Running) -> None:
    assert_same_geometry(part(), part())
    text = message_of(lambda: assert_same_geometry(part(), part(moved=5e-3)))  # 1e-4 of the size
    assert text.startswith("B (Workplane) against A (Workplane): changed: ") and "tolerance" in text
    left = saved(test_folder)
    assert "report.html" in left and len(left) == 7 and {"a", "b", "overlay"} == {
        name.split(".")[1] for name in left if name.endswith(".png")
    }  # fmt: skip
    assert_same_geometry(part(), part(moved=1e-6), **SMALL)
    message_of(lambda: assert_same_geometry(part(), part(moved=1e-6), "strict", **SMALL))
    text = message_of(lambda: assert_same_geometry(part(), cq.Workplane().box(40, 30, 10), **SMALL))
    assert "topology: " in text


def test_names_and_colours_are_no_geometry(test_folder: Running) -> None:
    red, blue = (
        cq.Assembly(name="all").add(part(), name=name, color=cq.Color(color))
        for name, color in (("lid", "red"), ("cover", "blue"))
    )
    assert_same_geometry(red, blue, **SMALL)
    everything = ("structure", "topology", "mass", "pictures")
    text = message_of(lambda: assert_same_geometry(red, blue, **SMALL, sections=everything))
    assert "colour" in text and "name" in text
    text = message_of(lambda: assert_same_geometry(red, blue, **SMALL, sections=everything, ignore="*name*"))
    assert "colour" in text and "name" not in text
    for pattern in ("colour", "colour*"):
        assert_same_geometry(red, blue, **SMALL, sections=everything, ignore=["*name*", pattern])


def test_colours_that_do_not_count_are_not_compared(
    test_folder: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither of faces nor in pictures: all of that goes through colors_of."""
    asked: list[int] = []

    def colors_of(side: Any, instance: int, faces: Any) -> Any:
        asked.append(instance)
        return true(side, instance, faces)

    true = colors.colors_of
    for module in (colors, pictures):
        monkeypatch.setattr(module, "colors_of", colors_of)
    assert_same_geometry(part(), part(), **SMALL)
    assert_roundtrip(part(), ignore="colour", **SMALL)
    assert asked == []
    assert_same_geometry(part(), part(), **SMALL, sections=("structure", "pictures"))
    assert asked


def test_whatever_holds_a_shape_is_compared(test_folder: Running) -> None:
    class FromAnotherLibrary:  # as the objects of build123d
        def __init__(self, shape: cq.Shape) -> None:
            self.wrapped, self.label, self.children = shape.wrapped, "part", ()

    solid = part().val()
    assert isinstance(solid, cq.Shape)
    model, builder = trimray.load(part()), SimpleNamespace(part=FromAnotherLibrary(solid))
    for other in (solid, solid.wrapped, FromAnotherLibrary(solid), builder, cq.Assembly(part()), model):
        assert_same_geometry(model, other, **SMALL)


def test_models_are_found_beside_the_test(test_folder: Running) -> None:
    cq.exporters.export(part(), str(test_folder.folder / "beside_the_test.step"))
    assert_same_geometry("beside_the_test.step", part(), **SMALL)
    for call in (
        lambda: assert_same_geometry("gone.step", part()),
        lambda: assert_roundtrip("gone.step"),
        lambda: assert_matches_picture("gone.step", "a.png"),
    ):
        assert "gone.step: " in message_of(call).splitlines()[0]


def test_a_model_is_written_from_its_store(test_folder: Running) -> None:
    assert_roundtrip(trimray.load(part()), **SMALL)


def test_a_round_trip_that_loses_something(test_folder: Running) -> None:
    """A writer that writes another part."""
    folder = test_folder.folder
    cq.exporters.export(part(), str(folder / "a.step"))
    cq.exporters.export(cq.Workplane().box(40, 30, 10), str(folder / "other.step"))
    text = message_of(
        lambda: assert_roundtrip(
            "a.step", writer=f'sh -c \'cp "{folder}/other.step" "{{out}}" # {{in}}\'', **SMALL
        )
    )
    assert "a.step" in text and "topology: " in text and "report.html" in saved(test_folder)


@pytest.mark.parametrize(
    "call",
    [
        lambda: assert_same_geometry(part(), part(), "sloppy"),
        lambda: assert_same_geometry(part(), part(), sections=["colours"]),
        lambda: assert_roundtrip(part(), "stl"),  # type: ignore[arg-type]
        lambda: assert_matches_picture(part(), "a.jpg"),
        lambda: assert_matches_picture(part(), "a.png", view="underneath"),
        lambda: assert_matches_picture(part(), "a.png", tolerance=-1),
        lambda: assert_same_geometry(part(), object()),
    ],
)
def test_wrong_words_are_usage_errors(test_folder: Running, call: Callable[[], None]) -> None:
    with pytest.raises(trimray.UsageError):
        call()


def test_without_pytest_the_calling_file_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    before = running.enter(None)
    try:
        text = message_of(lambda: assert_matches_picture(part(), "no_such_folder/a.png", size=SIZE))
    finally:
        running.enter(before)
    assert str(Path(__file__).parent / "no_such_folder" / "a.png") in text
    (left,) = (tmp_path / running.FAILURES).glob("*/a.now.png")
    assert "test_plugin.py" in left.parent.name


def test_the_folders_of_failures_have_names_for_every_file_system() -> None:
    ids = ["a/test_b.py::test_c", "a.py::t[1/2]", "a.py::t[1-2]", "a.py::t[ä:*?]", "x" * 300, "x" * 299, "::"]
    names = [Running(i, Path(), Path(), Path()).folder_name() for i in ids]
    assert names[0] == "a-test_b.py-test_c"
    assert len(set(names)) == len(names)
    assert all(
        name.isascii() and 0 < len(name) < 140 and not set(name) & set('/\\:*?"<>| []') for name in names
    )


def test_the_entry_point_is_the_plugin() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["entry-points"]["pytest11"] == {"trimray": pytest_plugin.__name__}
    assert not any(name.startswith("pytest") for name in project["dependencies"])


def test_the_plugin_imports_next_to_nothing() -> None:
    """Suites that have nothing to do with CAD load it, too."""
    code = (
        "import sys, pytest; before = set(sys.modules);"
        "import trimray.fidelity.pytest_plugin; print(*sorted(set(sys.modules) - before));"
        "import trimray.testing; print(*sorted(set(sys.modules) - before))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    plugin, testing = (set(line.split()) for line in done.stdout.splitlines())
    assert plugin <= {
        "trimray", "trimray.version", "trimray.fidelity", "trimray.fidelity.running", pytest_plugin.__name__
    }  # fmt: skip
    assert testing - plugin <= {"trimray.testing", "trimray.fidelity.asserts"}


def test_an_overlay_marks_what_is_off() -> None:
    picture = np.full((40, 40, 4), 255, np.uint8)
    wrong = np.zeros((40, 40), bool)
    wrong[20, 20] = True
    marked = decode(golden._overlay(picture, picture, wrong))[0]
    assert marked[20, 20, :3].tolist() == [255, 128, 0] and marked[0, 0].tolist() == [247, 247, 247, 255]
