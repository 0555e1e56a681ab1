"""A model against its golden picture: the pixels, and which faces the wrong ones belong to."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import trimray
from trimray.formats import check_fit
from trimray.frame import Frame
from trimray.image_io import byte_pixels, decode, encode, write_file
from trimray.model import Model
from trimray.version import __version__

from .failures import save
from .overlay import boxes, overlay
from .running import PICTURE, Running

# Faces that a failure names.
_FACES = 3
_MADE_BY = "Source"  # text key of the PNG
_UPDATE = "pytest --trimray-update"

Rgba = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class _Shot:
    """A picture that was made: its file, and its pixels as a file holds them."""

    model: Model
    look: Mapping[str, Any]
    png: bytes
    pixels: Rgba


def check_picture(
    running: Running,
    source: Any,
    golden: str | os.PathLike[str],
    tolerance: int,
    pixels: int,
    look: Mapping[str, Any],
) -> str:
    """What is wrong, "" for nothing. look: arguments of Model.render. Raises UsageError."""
    path = running.beside(golden)
    if path.suffix.lower() != ".png":
        raise trimray.UsageError(f"{path.name}: golden pictures are PNG files")
    if not (0 <= tolerance <= 255 and pixels >= 0):
        raise trimray.UsageError(f"tolerance: {tolerance} of 0 to 255, pixels: {pixels} of 0 or more")
    try:
        shot = _take(source, look)
        if running.update:
            _update(running, path, shot)
            return ""
        return _compare(running, path, shot, tolerance, pixels)
    except trimray.UsageError:
        raise
    except trimray.Error as error:
        return str(error)


def _take(source: Any, look: Mapping[str, Any]) -> _Shot:
    model = source if isinstance(source, Model) else trimray.load(source)
    frame = model.render(**look)
    names, colors = byte_pixels(frame)
    check_fit("png", frame.aovs, len(names) == 3)
    if len(names) == 3:
        colors = np.pad(colors, ((0, 0), (0, 0), (0, 1)), constant_values=255)
    return _Shot(model, look, encode(frame, "png", text={_MADE_BY: made_by()}), colors)


def made_by() -> str:
    """Of what the pixels of a picture depend."""
    try:
        opencascade = metadata.version("cadquery-ocp")
    except metadata.PackageNotFoundError:
        opencascade = "unknown"
    return f"trimray {__version__}, cadquery-ocp {opencascade}"


def _update(running: Running, path: Path, shot: _Shot) -> None:
    """Files that show the same pixels stay as they are. Raises OutputError."""
    exists = path.exists()
    if exists:
        try:
            if np.array_equal(decode(path.read_bytes())[0], shot.pixels):
                return
        except (OSError, trimray.InputError):
            pass  # it is replaced
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise trimray.OutputError(f"{running.shown(path)}: not written: {error.strerror}") from None
    write_file(str(path), shot.png)
    undrawn = len(shot.model.report.not_drawn)
    lacking = f", without {undrawn} faces that cannot be drawn" if undrawn else ""
    running.notes.append((PICTURE, f"{'renewed' if exists else 'new'}: {running.shown(path)}{lacking}"))


def _compare(running: Running, path: Path, shot: _Shot, tolerance: int, pixels: int) -> str:
    shown, stem = running.shown(path), path.stem
    now = f"{stem}.now.png"
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        saved = save(running, {now: shot.png})
        return (
            f"{shown}: there is no such golden picture; look at the one made now, then run: {_UPDATE}{saved}"
        )
    except OSError as error:
        return f"{shown}: {error.strerror}"
    if data == shot.png:
        return ""
    golden, texts = decode(data, shown)
    if golden.shape != shot.pixels.shape:
        saved = save(running, {f"{stem}.golden.png": data, now: shot.png})
        sizes = [f"{image.shape[1]} x {image.shape[0]} px" for image in (golden, shot.pixels)]
        return f"{shown}: the golden picture is {sizes[0]}, the one made now {sizes[1]}{saved}"
    off = np.abs(golden.astype(np.int16) - shot.pixels).max(axis=-1)
    wrong = off > tolerance
    if int(wrong.sum()) <= pixels:
        return ""
    drawn = _overlay(golden, shot.pixels, wrong)
    saved = save(running, {f"{stem}.golden.png": data, now: shot.png, f"{stem}.overlay.png": drawn})
    return "\n".join(_lines(shown, shot, off, wrong, tolerance, pixels, texts)) + saved


def _lines(
    shown: str,
    shot: _Shot,
    off: npt.NDArray[np.int16],
    wrong: npt.NDArray[np.bool_],
    tolerance: int,
    pixels: int,
    texts: Mapping[str, str],
) -> list[str]:
    y, x = np.unravel_index(int(off.argmax()), off.shape)
    lines = [
        f"{shown}: changed: {int(wrong.sum())} of {wrong.size} pixels differ by more than {tolerance} of 255"
        f" ({pixels} may), most at ({x}, {y}): by {int(off.max())}",
        f"  worst: {', '.join(_faces(shot, wrong))}",
        f"  in x0 y0 x1 y1: {'; '.join(' '.join(map(str, box)) for box in boxes(wrong)[:4])}",
    ]
    made = texts.get(_MADE_BY, "")
    if made and made != made_by():
        lines.append(f"  the golden picture is of {made}, and this is {made_by()}: pictures may differ")
    return [*lines, f"  if the new picture is right: {_UPDATE}"]


def _faces(shot: _Shot, wrong: npt.NDArray[np.bool_]) -> list[str]:
    """Whose the wrong pixels are now, most of them first."""
    plain = {key: value for key, value in shot.look.items() if key in ("size", "view", "projection", "up")}
    faces = shot.model.render(**plain, aovs="face", samples=1)["face"][wrong]
    numbers, counts = np.unique(faces, return_counts=True)
    order = np.argsort(-counts, kind="stable")[:_FACES]
    names = ["nothing" if n < 0 else shot.model.faces[n].call() for n in numbers[order].tolist()]
    return [f"{name} in {count} px" for name, count in zip(names, counts[order].tolist(), strict=True)]


def _overlay(golden: Rgba, now: Rgba, wrong: npt.NDArray[np.bool_]) -> bytes:
    none, zeros = np.zeros_like(wrong), np.zeros(wrong.shape, np.float32)
    frames = [{"color": image.astype(np.float32) / 255.0, "depth": zeros} for image in (golden, now)]
    marked = overlay(frames, {"coverage": none, "color": none, "depth": wrong, "normal": none})
    return encode(Frame({"color": marked}, (wrong.shape[1], wrong.shape[0])), "png")
