"""In GNOME's sandbox: good files become pictures, bad ones a line and nothing else."""

from __future__ import annotations

import io
import platform
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from . import gnome
from .gnome import Done

pytestmark = pytest.mark.skipif(bool(gnome.why_not()), reason=gnome.why_not() or "-")

_PYTHON = f"{gnome.ENVIRONMENT}/bin/python"
_OUTPUT = "gnome-desktop-thumbnailer.png"


def thumbnail(source: Path, *options: str) -> Done:
    """The scripts of a virtual environment know its place by heart; the module is the same program."""
    program = [_PYTHON, "-m", "trimray.desktop.thumbnail", "-s", "128", *options, "%i", "%o"]
    return gnome.run(program, source)


@pytest.mark.parametrize("name", ["bracket.step", "bracket_solid.igs", "bracket.brep", "stand.stl"])
def test_a_good_file(samples_dir: Path, name: str) -> None:
    done = thumbnail(samples_dir / name)
    assert (done.code, done.text) == (0, "")
    assert list(done.outputs) == [_OUTPUT], "GNOME complains of whatever else is left"
    image = Image.open(io.BytesIO(done.outputs[_OUTPUT]))
    assert image.size == (128, 128) and image.format == "PNG"
    assert 0.05 < (np.asarray(image)[..., 3] == 255).mean() < 0.9


@pytest.mark.parametrize(("name", "size"), [("cut.step", 3000), ("zero.step", 0), ("cut.igs", 3000)])
def test_a_bad_file(samples_dir: Path, tmp_path: Path, name: str, size: int) -> None:
    source = tmp_path / name
    whole = samples_dir / ("bracket_solid.igs" if source.suffix == ".igs" else "bracket.step")
    source.write_bytes(whole.read_bytes()[:size])
    done = thumbnail(source)
    assert done.code == 3
    assert "gnome-desktop-file-to-thumbnail" in done.text and done.text.count("\n") == 1
    assert done.outputs == {}


def test_a_file_that_takes_too_long(samples_dir: Path) -> None:
    done = thumbnail(samples_dir / "teapot.step", "--time-limit", "0.01")
    assert done.code == 5 and done.text.count("\n") == 1 and done.outputs == {}


def test_a_hostile_name(samples_dir: Path, tmp_path: Path) -> None:
    """GNOME takes over the extension alone."""
    source = tmp_path / "-a b'\"$(x)\n.st;l$(x) '"
    shutil.copy(samples_dir / "stand.stl", source)
    done = thumbnail(source)
    assert (done.code, done.text, list(done.outputs)) == (0, "", [_OUTPUT])


def test_the_sandbox_is_one(tmp_path: Path) -> None:
    """There is no home, no network, and system calls are refused: or else the tests above say little."""
    source = tmp_path / "a.txt"
    source.write_text("content")
    code = (
        "import ctypes, os, socket, sys\n"
        "print(sorted(os.listdir('/')))\n"
        "print(os.path.exists(os.environ['HOME']), os.path.exists('/sys'))\n"
        "libc = ctypes.CDLL(None, use_errno=True)\n"
        "for call in ((272, 0), (101, 0), (435, 0, 0), (56, 0x10000000), (135, 8), (250, 0)):\n"
        "    libc.syscall(*call)\n"
        "    print(ctypes.get_errno(), end=' ')\n"
        "try:\n"
        "    socket.socket(17, socket.SOCK_RAW)\n"
        "except OSError as error:\n"
        "    print(error.errno)\n"
        "print(len(open('/proc/net/route').readlines()) - 1)\n"
        "open(sys.argv[1]).read()\n"
        "print(os.access(sys.argv[1], os.W_OK))\n"
    )
    done = gnome.run([_PYTHON, "-c", code, "%i"], source)
    lines = done.text.splitlines()
    assert done.code == 0, done.text
    # A Python that is installed below /home is shown there, and nothing else of it.
    assert ("'home'" not in lines[0] or sys.base_prefix.startswith("/home/")) and "'usr'" in lines[0]
    assert lines[1] == "False False"
    if platform.machine() == "x86_64":
        assert lines[2].split() == ["1", "1", "38", "1", "1", "1", "97"]
    assert lines[3] == "0" and lines[4] == "False"
