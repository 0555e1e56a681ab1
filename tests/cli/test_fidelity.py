"""check, roundtrip, compare as their users call them: verdict, exit code, reports, other people's writers."""

from __future__ import annotations

import json
import re
import shlex
import stat
import subprocess
import xml.etree.ElementTree as xml
from pathlib import Path

import cadquery as cq
import pytest

from tests.fidelity.validate import violations
from tests.processes import runs, until
from trimray.fidelity import writer
from trimray.fidelity.report_json import schema

from .conftest import Run

FAST = ("--no-pictures",)


@pytest.fixture(scope="module")
def moved_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The box of box_file with one side 0.01 mm farther out."""
    path = tmp_path_factory.mktemp("models") / "moved.step"
    cq.exporters.export(cq.Workplane().box(10.01, 20, 30), str(path))
    return path


def script(folder: Path, text: str) -> str:
    """As a word of a command."""
    path = folder / "writer.sh"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return shlex.quote(str(path))


def test_a_clean_round_trip_is_complete(run: Run, samples_dir: Path) -> None:
    result = run("roundtrip", samples_dir / "assembly.step", "--size", "96")
    assert (result.code, result.err) == (0, "")
    lines = result.out.decode().splitlines()
    assert len(lines) == 2 and all(": complete: as STEP AP242" in line for line in lines)
    assert ", twice: " in lines[1]


@pytest.mark.parametrize("via", ["iges", "brep", "store"])
def test_every_way_of_writing_can_be_tried(run: Run, samples_dir: Path, via: str) -> None:
    result = run("roundtrip", samples_dir / "spline_part.step", "--via", via, "--once", "--json", *FAST)
    read = json.loads(result.out)
    assert violations(read, schema()) == []
    (about,) = read["results"][0]["comparisons"]
    assert result.code == (0 if about["verdict"] == "complete" else 7)
    found = {finding["name"]: finding for finding in about["findings"]}
    assert found["faces"]["a"] == found["faces"]["b"] > 0
    assert found["volume"]["same"]
    if via == "brep":  # what the format has no place for is said
        assert "brep holds none" in found["names"]["reason"]


def test_two_different_models_differ(run: Run, box_file: Path, moved_file: Path, tmp_path: Path) -> None:
    junit, html = tmp_path / "r.xml", tmp_path / "r.html"
    words = ("--size", "64", "--junit", junit, "--html", html)
    result = run("compare", box_file, moved_file, *words)
    text = result.out.decode()
    assert result.code == 7 and result.err == ""
    first = text.splitlines()[0]
    assert first.startswith(f"{box_file} - {moved_file}: changed: ") and "values differ (default" in first
    assert "! volume" in text and "6006" in text
    root = xml.fromstring(junit.read_bytes())
    assert int(root.get("failures", "0")) == int(first.split(": ")[-1].split(" of ")[0]) > 0
    assert html.read_bytes().count(b"data:image/png;base64,") > 10


def test_a_model_is_the_same_as_itself(run: Run, box_file: Path) -> None:
    result = run("compare", box_file, box_file, "--profile", "strict", "-v", *FAST)
    assert result.code == 0
    assert "volume" in result.out.decode() and "!" not in result.out.decode()


def test_what_cannot_be_read_has_its_own_exit_code(run: Run, box_file: Path, tmp_path: Path) -> None:
    missing = tmp_path / "missing.step"
    result = run("compare", box_file, missing, "--json")
    assert result.code == 3 and str(missing) in result.err
    assert json.loads(result.out)["results"][0]["verdict"] == "failed"
    result = run("roundtrip", missing, box_file, "--json", "--once", *FAST)
    assert result.code == 1  # some of several
    assert [r["exit_code"] for r in json.loads(result.out)["results"]] == [3, 0]
    result = run("roundtrip", box_file, "--time-limit", "0.01", *FAST)
    assert result.code == 5 and "within 0.01 s" in result.err + result.out.decode()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("compare", "a.step"), "compare takes two models, A and B, not 1"),
        (("compare", "-", "-"), "stdin can be read once only"),
        (("compare", "a", "b", "--json", "--junit", "-"), "only one of --json, --junit and --html"),
        (("roundtrip", "a", "--writer", "cp {in} x"), "writer: 'cp {in} x' has no {out}"),
        (("roundtrip", "a", "--writer", "cp '{in} {out}"), "No closing quotation"),
        (("roundtrip", "a", "--writer", "cp {in} {out}", "--via", "store"), "writer: cannot be given with"),
        (
            ("roundtrip", "a/x", "b/x", "--keep", "{name}"),
            "--keep: several inputs would be written to one file",
        ),
    ],
)
def test_wrong_usage_is_told_before_any_work(run: Run, words: tuple[str, ...], complaint: str) -> None:
    result = run(*words)
    assert result.code == 2 and complaint in result.err, result.err


def test_a_page_of_someone_else_is_not_overwritten(run: Run, box_file: Path, tmp_path: Path) -> None:
    page = tmp_path / "index.html"
    page.write_text("mine")
    result = run("compare", box_file, box_file, "--html", page)
    assert result.code == 4 and page.read_text() == "mine"


def test_a_writer_that_copies_is_complete(run: Run, box_file: Path, tmp_path: Path) -> None:
    kept = tmp_path / "kept.step"
    result = run("roundtrip", box_file, "--writer", "cp {in} {out}", "--keep", kept, *FAST)
    assert result.code == 0 and result.out.decode().count(": complete: as written by cp") == 2
    assert kept.read_bytes() == box_file.read_bytes()


def test_a_writer_that_loses_something_is_found_out(
    run: Run, box_file: Path, moved_file: Path, tmp_path: Path
) -> None:
    writer = script(tmp_path, f'cp "{moved_file}" "$2"')
    result = run("roundtrip", box_file, "--writer", f"{writer} {{in}} {{out}}", *FAST)
    lines = [line for line in result.out.decode().splitlines() if line.startswith(str(box_file))]
    assert result.code == 7
    assert ": changed: as written by writer.sh" in lines[0] and ": complete: " in lines[1]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("echo out of ideas >&2; exit 3", "the writer 'writer.sh' ended with exit status 3: out of ideas"),
        ("kill -SEGV $$", "the writer 'writer.sh' ended by SIGSEGV"),
        ("true", "the writer 'writer.sh' wrote no file"),
        (': > "$2"', "the writer 'writer.sh' wrote an empty file"),
        ('echo nonsense > "$2"', "not a STEP, IGES"),
    ],
)
def test_a_writer_that_fails_is_told_in_one_line(
    run: Run, box_file: Path, tmp_path: Path, text: str, complaint: str
) -> None:
    result = run("roundtrip", box_file, "--writer", f"{script(tmp_path, text)} {{in}} {{out}}", *FAST)
    lines = result.out.decode().splitlines()
    assert result.code == 7 and len(lines) == 1
    assert lines[0].startswith(f"{box_file}: failed: as written by writer.sh: ") and complaint in lines[0]


def test_a_command_that_is_not_there_is_told(run: Run, box_file: Path) -> None:
    result = run("roundtrip", box_file, "--writer", "/no/such/thing {in} {out}", *FAST)
    assert result.code == 7 and "'thing' cannot be started: No such file or directory" in result.out.decode()


def test_a_writer_that_hangs_ends_with_all_it_has_started(
    run: Run, box_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    number = tmp_path / "number"
    written = script(tmp_path, f"sleep 600 & echo $! > '{number}.part'; mv '{number}.part' '{number}'; wait")
    wait = writer._wait

    def late(process: subprocess.Popen[bytes], limit: float | None) -> int | None:
        """The limit is over as soon as the writer has started what it starts."""
        assert limit is not None and limit > 0
        until(number.exists)
        return wait(process, 0.0)

    monkeypatch.setattr(writer, "_wait", late)
    words = ("--writer", f"{written} {{in}} {{out}}", "--time-limit", "1000")
    result = run("roundtrip", box_file, *words, *FAST)
    assert result.code == 5 and ": not written within 1000 s" in result.out.decode()
    until(lambda: not runs(int(number.read_text())))


def test_quiet_is_quiet_about_what_is_complete(run: Run, box_file: Path, moved_file: Path) -> None:
    assert run("compare", box_file, box_file, "-q", *FAST).out == b""
    assert b"changed" in run("compare", box_file, moved_file, "-q", *FAST).out


def test_sound_files_are_what_they_declare(run: Run, samples_dir: Path) -> None:
    sources = [
        samples_dir / name for name in ("assembly.step", "bracket.step", "bracket_solid.igs", "teapot.igs")
    ]
    result = run("check", *sources, "--json")
    read = json.loads(result.out)
    assert (result.code, result.err) == (0, "") and violations(read, schema()) == []
    assert [r["verdict"] for r in read["results"]] == ["complete"] * 4
    found = {f["name"]: f for f in read["results"][0]["comparisons"][0]["findings"]}
    assert (found["faces in the file"]["a"], found["faces in the file"]["b"]) == (29, 29)
    assert found["invalid"]["b"] == 0 and found["edge off its face"]["same"]


def test_what_is_wrong_with_a_file_is_found(run: Run, samples_dir: Path, tmp_path: Path) -> None:
    """A solid that has lost one of its faces is open, and its file declares one face more than arrives. No
    solid arrives, but the edges around the hole are known."""
    text = (samples_dir / "bracket.step").read_text()
    face = re.search(r"#\d+ *= *ADVANCED_FACE\([^;]*;", text)
    assert face is not None
    broken = tmp_path / "broken.step"
    broken.write_text(text.replace(face[0], face[0].replace("ADVANCED_FACE", "ADVANCED_FICE"), 1))
    result = run("check", broken, "--junit", tmp_path / "r.xml")
    first = result.out.decode().splitlines()[0]
    assert result.code == 7 and first.startswith(f"{broken}: partial: ")
    failures = xml.parse(tmp_path / "r.xml").getroot().findall(".//failure/..")
    names = {str(case.get("name")).split(" (")[0] for case in failures}
    assert names == {"solids in the file", "closed shells in the file", "face", "free edge"}
    free = [case for case in failures if str(case.get("name")).startswith("free edge (edge ")]
    assert len(free) == 7 and all(case.find("failure") is not None for case in free)


def test_check_tells_what_cannot_be_read(run: Run, tmp_path: Path, box_file: Path) -> None:
    result = run("check", tmp_path / "missing.step", "--html", tmp_path / "r.html")
    assert result.code == 3 and "missing.step" in result.err and result.out == b""
    assert b"missing.step" in (tmp_path / "r.html").read_bytes()
    assert run("check", box_file, "--heal", "off", "--profile", "strict").code == 0
