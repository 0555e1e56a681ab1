"""One picture of many: every model of a folder, each in a cell, failures as dark cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio

import trimray

SUFFIXES = {".step", ".stp", ".stpz", ".igs", ".iges", ".brep"}


def models_in(folder: Path) -> list[Path]:
    return sorted(p for p in folder.rglob("*") if p.suffix.lower() in SUFFIXES)


def make(files: list[Path], out: Path, cell: int = 256, columns: int = 8) -> list[tuple[Path, str]]:
    """Writes the sheet; returns what could not be drawn, and why, a line a file."""
    rows = -(-len(files) // columns)
    sheet = np.full((rows * cell, columns * cell, 4), (0.15, 0.15, 0.15, 1.0), np.float32)
    failures = []
    for k, file in enumerate(files):
        y, x = cell * (k // columns), cell * (k % columns)
        try:
            model = trimray.load(file, time_limit=120)
            frame = model.render((cell, cell), background="white")
            sheet[y : y + cell, x : x + cell] = np.asarray(frame["color"])
            if model.report.not_drawn:
                failures.append((file, f"{len(model.report.not_drawn)} faces not drawn"))
        except trimray.Error as error:
            failures.append((file, str(error)))
    buffer = oiio.ImageBuf(oiio.ImageSpec(sheet.shape[1], sheet.shape[0], 4, "uint8"))
    buffer.set_pixels(oiio.ROI(0, sheet.shape[1], 0, sheet.shape[0], 0, 1, 0, 4), sheet)
    buffer.write(str(out))
    return failures
