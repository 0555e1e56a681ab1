"""The thumbnailer: a picture, or no file, one line and an exit code."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.processes import runs, until
from trimray import UsageError
from trimray.desktop.thumbnail import parse

from .conftest import Thumbnailer, opened


def one_line(done: subprocess.CompletedProcess[str]) -> str:
    assert done.stdout == "" and done.stderr.count("\n") == 1, (done.stdout, done.stderr)
    assert done.stderr.startswith("trimray-thumbnailer: ")
    return done.stderr


def test_a_square_png_of_that_size_whatever_its_name(
    thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path
) -> None:
    target = tmp_path / "picture.jpg"
    target.touch()  # some file managers make it first
    done = thumbnailer("-s", 96, samples_dir / "bracket.step", target)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    image = opened(target)
    assert (image.format, image.size, image.mode) == ("PNG", (96, 96), "RGBA")
    alpha = np.asarray(image)[..., 3]
    assert alpha[0, 0] == 0, "the background is transparent"
    assert 0.2 < (alpha == 255).mean() < 0.9
    assert os.listdir(tmp_path) == ["picture.jpg"]


def test_a_uri_and_an_output_beside_it_and_no_other_place_to_write(
    thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path
) -> None:
    source = tmp_path / "a b\u00e9%20'\"\n.stl"
    source.write_bytes((samples_dir / "stand.stl").read_bytes())
    uri = source.as_uri()
    done = thumbnailer(
        uri, tmp_path / "out.png", HOME="/proc/none", TMPDIR="/proc/none", XDG_CACHE_HOME="/proc/1"
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert opened(tmp_path / "out.png").size == (128, 128)
    assert sorted(os.listdir(tmp_path)) == sorted([source.name, "out.png"])


def test_names_that_are_no_text(thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path) -> None:
    source = os.fsencode(tmp_path) + b"/-\xff\n$(x);.stl"
    with open(source, "wb") as file:
        file.write((samples_dir / "stand.stl").read_bytes())
    target = os.fsencode(tmp_path) + b"/\xfe.png"
    done = thumbnailer("-s", "32", source, target)
    assert (done.returncode, done.stderr) == (0, "")
    assert opened(Path(os.fsdecode(target))).size == (32, 32)


@pytest.mark.parametrize(
    ("content", "code", "text"),
    [
        (None, 3, "No such file"),
        (b"", 3, "empty"),
        (b"\0" * 5000, 3, ""),
        (b"ISO-10303-21;\nHEADER;\n", 3, ""),
        ("cut", 3, "truncated"),
    ],
)
def test_a_bad_file_is_one_line_and_no_picture(
    thumbnailer: Thumbnailer,
    samples_dir: Path,
    tmp_path: Path,
    content: bytes | str | None,
    code: int,
    text: str,
) -> None:
    source = tmp_path / "bad\nname.step"
    if content is not None:
        whole = (samples_dir / "bracket.step").read_bytes()
        source.write_bytes(content if isinstance(content, bytes) else whole[: len(whole) // 2])
    done = thumbnailer("-s", 64, source, tmp_path / "out" / "no.png", TMPDIR=str(tmp_path))
    assert done.returncode == code
    line = one_line(done)
    assert text in line and "bad name.step" in line
    assert os.listdir(tmp_path) == ([] if content is None else [source.name])


def test_closed_standard_streams(samples_dir: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "trimray.desktop.thumbnail", "-s", "16", samples_dir / "stand.stl"]
    closing = ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *command, tmp_path / "out.png"]
    assert subprocess.run(closing, check=False).returncode == 0
    assert opened(tmp_path / "out.png").size == (16, 16)


def test_a_time_limit(thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path) -> None:
    source = samples_dir / "teapot.step"
    done = thumbnailer("--time-limit", "0.05", source, tmp_path / "no.png", TMPDIR=str(tmp_path))
    assert done.returncode == 5 and "0.05 s" in one_line(done)
    assert os.listdir(tmp_path) == []


def test_a_memory_limit(thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path) -> None:
    """Far less than OpenCascade needs before it has read anything."""
    source = samples_dir / "teapot.step"
    done = thumbnailer("--memory-limit=40M", source, tmp_path / "no.png", TMPDIR=str(tmp_path))
    assert done.returncode == 5 and "40 MiB" in one_line(done)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("deed", "limit", "code", "text"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", 600, 70, "SIGSEGV"),
        ("time.sleep(600)", 0.1, 5, "no picture within 0.1 s"),
        ("os._exit(0)", 600, 70, "ended early"),
        ("os.write(pipe, b'nonsense\\n')", 600, 70, "nonsense"),
        ("os.write(pipe, b'x' * 200000)", 600, 70, "nonsense"),
        ("1 / 0", 600, 70, "ended early"),
    ],
)
def test_whatever_the_drawing_process_does(
    thumbnailer: Thumbnailer, tmp_path: Path, deed: str, limit: float, code: int, text: str
) -> None:
    """Its scratch files are removed, too."""
    (tmp_path / "scratch").mkdir()
    before = (
        "import os, signal, time\n"
        "from trimray.desktop import drawing, thumbnail\n"
        "thumbnail._GRACE_SECONDS = 0.5\n"
        "def draw(request, pipe, parent):\n"
        "    open(os.environ['TMPDIR'] + '/left', 'w').close()\n"
        f"    {deed}\n"
        "drawing.draw = draw\n"
    )
    arguments = ("--time-limit", limit, "a.step", tmp_path / "no.png")
    done = thumbnailer(*arguments, before=before, TMPDIR=str(tmp_path / "scratch"))
    assert done.returncode == code and text in one_line(done)
    assert os.listdir(tmp_path) == ["scratch"] and os.listdir(tmp_path / "scratch") == []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_file_manager_that_loses_patience(tmp_path: Path, number: signal.Signals) -> None:
    """Nothing runs on and nothing is left behind."""
    code = (
        "import os, sys, time\n"
        "from trimray.desktop import drawing, thumbnail\n"
        "def draw(request, pipe, parent):\n"
        "    open(os.environ['TMPDIR'] + '/left', 'w').write(str(os.getpid()))\n"
        "    time.sleep(600)\n"
        "drawing.draw = draw\n"
        "sys.exit(thumbnail.main())\n"
    )
    command = [sys.executable, "-c", code, "--time-limit", "600", "a.step", str(tmp_path / "no.png")]
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as running:
        while not (written := [p.read_text() for p in tmp_path.glob(".trimray-*/left")]) or not written[0]:
            assert running.poll() is None
            time.sleep(0.01)
        running.send_signal(number)
        _, error = running.communicate(timeout=240)
    assert running.returncode == (130 if number == signal.SIGINT else 128 + number)
    assert error.count("\n") <= 1 and os.listdir(tmp_path) == []
    assert not os.path.exists(f"/proc/{written[0]}")


def test_patience_may_end_while_the_drawing_process_is_made(thumbnailer: Thumbnailer, tmp_path: Path) -> None:
    (tmp_path / "scratch").mkdir()
    before = (
        "import os, signal, time\n"
        "from trimray.desktop import drawing\n"
        "drawing.draw = lambda *_: time.sleep(600)\n"
        "fork = os.fork\n"
        "def fork_and_end():\n"
        "    if child := fork():\n"
        f"        open({str(tmp_path / 'child')!r}, 'w').write(str(child))\n"
        "        signal.raise_signal(signal.SIGTERM)\n"
        "    return child\n"
        "os.fork = fork_and_end\n"
    )
    done = thumbnailer("a.step", tmp_path / "no.png", before=before, TMPDIR=str(tmp_path / "scratch"))
    assert done.returncode == 128 + signal.SIGTERM
    assert not runs(int((tmp_path / "child").read_text()))
    assert os.listdir(tmp_path / "scratch") == []


def test_the_drawing_process_ends_with_its_parent(tmp_path: Path) -> None:
    """Also when that has no time to say so."""
    code = (
        "import os, sys, time\n"
        "from trimray.desktop import drawing, thumbnail\n"
        "def encoded(request, start):\n"
        "    open(os.environ['TMPDIR'] + '/left', 'w').write(str(os.getpid()))\n"
        "    time.sleep(600)\n"
        "drawing.encoded = encoded\n"
        "sys.exit(thumbnail.main())\n"
    )
    command = [sys.executable, "-c", code, "--time-limit", "600", "a.step", str(tmp_path / "no.png")]
    with subprocess.Popen(command, env=os.environ | {"TMPDIR": str(tmp_path)}) as running:
        while not (written := [p.read_text() for p in tmp_path.glob(".trimray-*/left")]) or not written[0]:
            assert running.poll() is None
            time.sleep(0.01)
        running.kill()
    until(lambda: not runs(int(written[0])))


def test_an_output_that_cannot_be_written(
    thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path
) -> None:
    done = thumbnailer("-s", 16, samples_dir / "stand.stl", tmp_path / "none" / "out.png")
    assert done.returncode == 4 and "not written" in one_line(done)


def test_it_takes_one_thread(thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path) -> None:
    """Of the native core: the others wait for it."""
    before = (
        "import os\n"
        "from trimray import _core, image_io\n"
        "write = image_io.write_file\n"
        "def count(path, data):\n"
        f"    write({str(tmp_path / 'threads')!r}, str(len(os.listdir('/proc/self/task'))).encode())\n"
        "image_io.write_file = count\n"
    )
    done = thumbnailer("-s", 64, samples_dir / "stand.stl", tmp_path / "out.png", before=before)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "threads").read_text() == "1"


def test_starting_imports_nothing_heavy(thumbnailer: Thumbnailer) -> None:
    before = (
        "import trimray.desktop.thumbnail\n"
        "heavy = {'numpy', 'OCP', 'OpenImageIO', 'click', 'rich', 'trimray._core', 'trimray.batch'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    done = thumbnailer("--help", before=before)
    assert done.returncode == 0 and done.stdout.startswith("usage: ") and done.stderr == ""


def test_drawing_imports_no_command_line_and_no_pool(
    thumbnailer: Thumbnailer, samples_dir: Path, tmp_path: Path
) -> None:
    before = (
        "from trimray.desktop import drawing\n"
        "encoded = drawing.encoded\n"
        "def spy(request, start):\n"
        "    data = encoded(request, start)\n"
        "    foreign = {'click', 'rich', 'distributed', 'sqlite3', 'OCP', 'PIL'} & set(sys.modules)\n"
        "    return data if not foreign else str(foreign).encode()\n"
        "drawing.encoded = spy\n"
    )
    target = tmp_path / "out.png"
    done = thumbnailer("-s", 16, samples_dir / "stand.stl", target, before=before)
    assert done.returncode == 0, done.stderr
    assert target.read_bytes().startswith(b"\x89PNG"), target.read_bytes()


def test_arguments() -> None:
    assert parse(["a", "b"]).size == 128
    request = parse(["-s256", "--time-limit=3s", "--memory-limit", "1.5G", "file:///a%20b", "out"])
    assert (request.source, request.target, request.size) == ("/a b", "out", 256)
    assert (request.time_limit, request.memory_limit) == (3.0, 3 << 29)
    assert parse(["-s", "64", "--", "-a", "-b"]).source == "-a"


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["a"],
        ["a", ""],
        ["a", "b", "c"],
        ["-s", "0", "a", "b"],
        ["-s", "99999", "a", "b"],
        ["-s", "\u0662", "a", "b"],
        ["-s", "1e3", "a", "b"],
        ["-x", "a", "b"],
        ["--time-limit", "nan", "a", "b"],
        ["--time-limit", "-1", "a", "b"],
        ["--memory-limit", "inf", "a", "b"],
        ["a", "b", "-s"],
    ],
)
def test_wrong_arguments(arguments: list[str]) -> None:
    with pytest.raises(UsageError):
        parse(arguments)


def test_wrong_usage_is_one_line_and_exit_code_2(thumbnailer: Thumbnailer) -> None:
    done = thumbnailer("-s")
    assert done.returncode == 2 and "usage: trimray-thumbnailer" in one_line(done)
    done = thumbnailer("trash:///a", "b")
    assert done.returncode == 3 and "trash" in one_line(done)
