"""trimray doctor and --version: what is there, and whether it works."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable

from trimray import __version__

from .output import write_stdout


def _installed(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _raster_lines() -> str:
    """One line a raster backend: what was loaded, or why it was not."""
    try:
        from trimray import _core as core
    except ImportError as error:
        return f"no raster backend: {error}\n"
    return "".join(
        f"raster backend {name}: {text if there else f'not available, {text}'}\n"
        for name, there, text in core.raster_backends()
    )


def version_text() -> str:
    """OpenCascade, which takes seconds to import, is only named."""
    occt = _installed("cadquery-ocp")
    release = ".".join(occt.split(".")[:3]) if occt[0].isdigit() else occt
    return (
        f"trimray {__version__}\n"
        f"OpenCascade {release} (cadquery-ocp {occt})\n"
        f"OpenImageIO {_installed('openimageio')}\n"
        f"{_raster_lines()}"
        f"Python {platform.python_version()}, {platform.system()} {platform.machine()}\n"
    )


def run() -> int:
    """0 when all is well, 1 otherwise."""
    checks: tuple[tuple[str, Callable[[], str]], ...] = (
        ("native core", _core),
        ("raster", _raster),
        ("OpenCascade", _opencascade),
        ("OpenImageIO", _openimageio),
        ("Pillow", _pillow),
        ("cache", _cache),
        ("configuration", _configuration),
    )
    write_stdout(version_text())
    bad = 0
    for name, check in checks:
        try:
            write_stdout(f"ok    {name}: {check()}\n")
        except Exception as error:
            bad += 1
            write_stdout(f"BAD   {name}: {' '.join(str(error).split())}\n")
    return 1 if bad else 0


def _core() -> str:
    from trimray import _core as core

    camera = core.Camera.fit  # the module loaded and has what it should have
    assert camera is not None
    return f"{len(os.sched_getaffinity(0))} threads"


def _raster() -> str:
    """No backend at all is no fault: pictures then take longer, and are the same."""
    from trimray import _core as core

    there = [name for name, available, _ in core.raster_backends() if available]
    if not there:
        return "no backend (see above); pictures are rendered without raster passes, which takes longer"
    for name in there:
        core.Rasterizer(name).warm_up()
    return ", ".join(there) + (" draws" if len(there) == 1 else " draw")


def _opencascade() -> str:
    """In a process of its own, as it is used."""
    code = "import OCP.STEPControl, OCP.Standard; print('loads')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False
    )
    if done.returncode != 0:
        raise RuntimeError((done.stderr.strip().splitlines() or [f"ended with {done.returncode}"])[-1])
    return done.stdout.strip()


def _openimageio() -> str:
    import numpy as np

    from trimray import Frame
    from trimray.image_io import FORMATS, encode

    frame = Frame({"color": np.ones((2, 2, 4), np.float32)}, (2, 2))
    sizes = [f"{name} {len(encode(frame, name))} B" for name in FORMATS]
    return "writes " + ", ".join(sizes)


def _pillow() -> str:
    import numpy as np

    from trimray import Frame
    from trimray.animation import encode_animation
    from trimray.formats import ANIMATIONS

    frames = [Frame({"color": np.full((2, 2, 4), x, np.float32)}, (2, 2)) for x in (1.0, 0.5)]
    for frame in frames:
        frame["color"][..., 3] = 1.0
    sizes = [f"{name} {len(encode_animation(frames, name, 10.0))} B" for name in ANIMATIONS]
    return "writes moving " + ", ".join(sizes)


def _cache() -> str:
    from trimray import cache

    folder = cache.folder()
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        pass
    count, size = cache.size()
    return f"{folder}: {count} models, {size / 1e6:.1f} MB"


def _configuration() -> str:
    from . import config

    values = config.read()
    return (
        f"{config.path()}: {len(values)} options" if config.path().exists() else f"{config.path()}: not there"
    )
