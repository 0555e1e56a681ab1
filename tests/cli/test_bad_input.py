"""Every kind of bad input, by the command: its exit code, one line on stderr, and nothing half-written."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from .conftest import Result, Run, one_line

SMALL = ("--size", "24", "--time-limit", "600")  # should one of them hang: no busy machine reaches it


def replaced(pattern: str, by: str, count: int = 0) -> Callable[[str], str]:
    def change(text: str) -> str:
        changed, number = re.subn(pattern, by, text, count=count)
        assert number > 0, f"nothing like {pattern} in the file"
        return changed

    return change


KNOTS = r"\(0\.,0\.2,0\.5,0\.8,1\.\),\(0\.,0\.2,0\.5,0\.8,1\.\)"

# patch.step is one face, a rational B-spline surface of 7 x 7 points: (exit codes allowed, change).
# Exit code 1 where OpenCascade takes the damaged part for something else, and the picture is of that.
BROKEN_STEP = {
    "truncated within the data": ({3}, lambda text: text[: len(text) // 2]),
    "truncated within the header": ({3}, lambda text: text[:200]),
    "NaN coordinate": ({1}, replaced(r"\(10\.,0\.,8\.020866240553\)", "(10.,0.,NaN)")),
    "huge coordinates": ({1, 3}, replaced(r"\(10\.,", "(1.E+300,")),
    "negative weight": ({1, 3}, replaced(r"1\.545578456095", "-1.545578456095")),
    "zero weights": ({1, 3}, replaced(r"0\.545918502815", "0.")),
    "unsorted knots": ({1}, replaced(KNOTS, "(0.,0.8,0.5,0.2,1.),(0.,0.8,0.5,0.2,1.)")),
    "equal knots": ({1}, replaced(KNOTS, "(0.,0.5,0.5,0.5,1.),(0.,0.5,0.5,0.5,1.)")),
    "more knots than multiplicities": (
        {0, 1, 3},
        replaced(KNOTS, "(0.,0.1,0.2,0.5,1.,2.),(0.,1.)"),
    ),
    "wrong multiplicities": ({1, 3}, replaced(r"\(4,1,1,1,4\),\(4\s+,1,1,1,4\)", "(4,1,1,1,9),(4,1,1,1,4)")),
    "a row of points too few": ({1, 3}, replaced(r",\(#79,#80,#81,#82,#83,#84,#85\s*\)", "")),
    "a degree that does not fit": ({1, 3}, replaced(r"B_SPLINE_SURFACE\(3,3,", "B_SPLINE_SURFACE(11,-2,")),
    "a face that is its own surface": ({1, 3}, replaced(r"\(#18\),#36,\.T\.", "(#18),#17,.T.")),
    "a shell that holds itself": ({1, 3}, replaced(r"OPEN_SHELL\('',\(#17\)\)", "OPEN_SHELL('',(#16))")),
    "a bound that bounds itself": ({1, 3}, replaced(r"FACE_BOUND\('',#19", "FACE_BOUND('',#18")),
    "a point of the wrong type": ({1, 3}, replaced(r"\(#37,#38,", "(#17,#38,")),
    "references to nothing": ({1, 3}, replaced(r"\(#37,#38,", "(#90037,#38,")),
}


def refused(result: Result, codes: set[int], path: Path, picture: Path) -> None:
    """One line that names the file, and a picture only where something of the file is in it."""
    assert result.code in codes and result.out == b"", result
    assert one_line(result.err) and str(path) in result.err, result.err
    drawn = result.code == 1
    assert os.listdir(picture.parent) == ([picture.name] if drawn else [])
    assert not drawn or picture.read_bytes()[-8:-4] == b"IEND"


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    (tmp_path / "out").mkdir()
    return tmp_path / "out" / "a.png"


@pytest.mark.parametrize("kind", BROKEN_STEP)
def test_broken_step(run: Run, samples_dir: Path, tmp_path: Path, picture: Path, kind: str) -> None:
    codes, change = BROKEN_STEP[kind]
    path = tmp_path / "bad.step"
    path.write_text(change((samples_dir / "patch.step").read_text()))
    refused(run("render", path, "-o", picture, *SMALL), codes, path, picture)


# teapot.igs is 32 bicubic patches.
BROKEN_IGES = {
    "truncated within the parameters": lambda lines: lines[: 2 * len(lines) // 3],
    "truncated within the directory": lambda lines: lines[:20],
    "a line cut short": lambda lines: [*lines[:-40], lines[-40][:30]],
}


@pytest.mark.parametrize("kind", BROKEN_IGES)
def test_broken_iges(run: Run, samples_dir: Path, tmp_path: Path, picture: Path, kind: str) -> None:
    path = tmp_path / "bad.igs"
    lines = (samples_dir / "teapot.igs").read_text().splitlines()
    path.write_text("\n".join(BROKEN_IGES[kind](lines)) + "\n")
    refused(run("render", path, "-o", picture, *SMALL), {3}, path, picture)


NO_MODEL = {
    "missing": lambda path: None,
    "directory": lambda path: path.mkdir(),
    "empty": lambda path: path.touch(),
    "noise": lambda path: path.write_bytes(bytes((i * 7919 + 13) % 256 for i in range(20000))),
    "zeros": lambda path: path.write_bytes(bytes(4096)),
    "pipe": lambda path: os.mkfifo(path),
    "text": lambda path: path.write_text("Dear reader,\nthis is no model.\n"),
    "link to itself": lambda path: path.symlink_to(path),
}


@pytest.mark.parametrize("extension", ["step", "igs", "brep", "stpZ"])
@pytest.mark.parametrize("kind", NO_MODEL)
def test_no_model(run: Run, tmp_path: Path, picture: Path, kind: str, extension: str) -> None:
    path = tmp_path / f"bad.{extension}"
    NO_MODEL[kind](path)
    refused(run("render", path, "-o", picture, *SMALL), {3}, path, picture)


@pytest.mark.parametrize("path", ["", "a\0b.step", "n" * 300 + ".step"])
def test_odd_paths(run: Run, picture: Path, path: str) -> None:
    result = run("render", path, "-o", picture)
    assert result.code in (2, 3) and one_line(result.err), result
    assert os.listdir(picture.parent) == []


def test_step_without_faces(run: Run, samples_dir: Path, tmp_path: Path, picture: Path) -> None:
    path = tmp_path / "none.step"
    head = (samples_dir / "patch.step").read_text().partition("DATA;")[0]
    path.write_text(f"{head}DATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n")
    refused(run("render", path, "-o", picture, *SMALL), {3}, path, picture)


needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="becomes another user, which only root may")


def as_nobody(warm: Path, *arguments: object) -> Result:
    """The command as user 65534, in a process that drew warm first: Python itself may be root's alone."""
    code = (
        "import os, sys; from trimray.cli.__main__ import main;"
        "warm = ['render', sys.argv[1], '-o', '/dev/null', '--format', 'png', '--size', '8', '--no-cache'];"
        "assert main(warm) == 0;"
        "os.setgroups([]); os.setgid(65534); os.setuid(65534); sys.exit(main(sys.argv[2:]))"
    )
    command = [sys.executable, "-c", code, str(warm), *(str(a) for a in arguments)]
    environment = os.environ | {"XDG_CONFIG_HOME": "/nonexistent"}
    done = subprocess.run(command, capture_output=True, env=environment, check=False)
    return Result(done.returncode, done.stdout, done.stderr.decode())


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder that another user may enter; pytest's own are private."""
    folder = Path(tempfile.mkdtemp(prefix="trimray-test-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@needs_root
def test_permission_denied_for_the_input(samples_dir: Path, open_folder: Path) -> None:
    path = open_folder / "a.step"
    shutil.copy(samples_dir / "patch.step", path)
    path.chmod(0o600)
    result = as_nobody(
        samples_dir / "patch.step", "render", path, "-o", "/dev/null", "--format", "png", "--no-cache"
    )
    assert result.code == 3 and one_line(result.err), result
    assert f"{path}: Permission denied" in result.err


@needs_root
def test_permission_denied_for_the_output(samples_dir: Path, open_folder: Path) -> None:
    """Before the file is read, and the picture that was there stays."""
    path, old = open_folder / "a.step", open_folder / "old.png"
    shutil.copy(samples_dir / "patch.step", path)
    path.chmod(0o644)
    old.write_bytes(b"old")
    for target in (old, open_folder / "new.png"):
        result = as_nobody(samples_dir / "patch.step", "render", path, "-o", target, "--no-cache")
        assert result.code == 4 and one_line(result.err), result
        assert f"{target}: not written: permission denied" in result.err
    assert old.read_bytes() == b"old" and sorted(os.listdir(open_folder)) == ["a.step", "old.png"]


@pytest.fixture
def full_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system with hardly a byte free."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "none", str(folder)]
    if os.geteuid() != 0 or subprocess.run(command, capture_output=True, check=False).returncode != 0:
        pytest.skip("no file system may be mounted here")
    (folder / "ballast").write_bytes(bytes(56 << 10))
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_full_disk_keeps_the_old_picture(run: Run, samples_dir: Path, full_disk: Path) -> None:
    target = full_disk / "a.png"
    target.write_bytes(b"old")
    result = run("render", samples_dir / "patch.step", "-o", target, "--size", "200")
    assert result.code == 4 and one_line(result.err) and "No space left" in result.err, result
    assert target.read_bytes() == b"old" and sorted(os.listdir(full_disk)) == ["a.png", "ballast"]


def test_a_limited_file_size_keeps_the_old_picture(samples_dir: Path, picture: Path) -> None:
    """The same for a disk that is full for this process alone."""
    picture.write_bytes(b"old")
    code = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "from trimray.cli.__main__ import main; import trimray.image_io as io; write = io.write_file\n"
        "def limited(*a):\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)); write(*a)\n"
        "io.write_file = limited; sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "render", str(samples_dir / "patch.step"), "-o", str(picture)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 4 and one_line(done.stderr) and "too large" in done.stderr, done
    assert picture.read_bytes() == b"old" and os.listdir(picture.parent) == ["a.png"]


def test_a_cache_on_a_full_disk_is_no_matter(
    run: Run, samples_dir: Path, picture: Path, full_disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(full_disk))
    result = run("render", samples_dir / "patch.step", "-o", picture, *SMALL)
    assert (result.code, result.err) == (0, "")
    assert not [f for f in full_disk.rglob("*") if f.is_file() and f.name != "ballast"]
