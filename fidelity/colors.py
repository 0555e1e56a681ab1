"""Colours as they are seen: of every face at every place, in 8 bit sRGB."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .findings import found, limited, not_held
from .match import Matching
from .record import Finding
from .side import Int64s, Side
from .tolerances import Tolerances

Bytes = npt.NDArray[np.int16]  # (n, 4) 0 to 255; -1 where there is no colour


def eight_bits(colors: npt.NDArray[Any]) -> Bytes:
    """(n, 4) sRGB-encoded floats, a negative red for none."""
    rounded: Bytes = np.floor(np.clip(colors, 0.0, 1.0) * 255.0 + 0.5).astype(np.int16)
    rounded[colors[:, 0] < 0.0] = -1
    return rounded


def colors_of(side: Side, instance: int, faces: Int64s) -> Bytes:
    """(n, 4), as drawn: the face's colour, else the instance's, else the prototype's."""
    own = eight_bits(side.arrays["faces"]["color"][faces])
    rest = eight_bits(side.arrays["instances"]["color"][instance : instance + 1])
    if rest[0, 0] < 0:
        prototype = int(side.prototypes[instance])
        rest = eight_bits(side.arrays["prototypes"]["color"][prototype : prototype + 1])
    return np.where(own[:, :1] < 0, rest, own)


def compare_colors(matching: Matching, tolerances: Tolerances) -> list[Finding]:
    """Of all pairs of faces of all pairs of parts."""
    a, b = matching.a, matching.b
    if not (a.holds("colors") and b.holds("colors")):
        return [not_held("structure", "colors", a, b, "colours")]
    wrong: list[Finding] = []
    largest = 0
    seen: tuple[set[bytes], set[bytes]] = set(), set()
    for part, number_a, number_b, faces in matching.alike:
        colors = colors_of(a, number_a, faces[:, 0]), colors_of(b, number_b, faces[:, 1])
        for known, table in zip(seen, colors, strict=True):
            known.update(row.tobytes() for row in np.unique(table, axis=0) if row[0] >= 0)
        steps = np.abs(colors[0] - colors[1]).max(axis=1, initial=0)
        one_lacks = (colors[0][:, 0] < 0) != (colors[1][:, 0] < 0)
        largest = max(largest, int(steps[~one_lacks].max(initial=0)))
        for values in np.unique(
            np.column_stack([*colors, steps])[(steps > tolerances.color) | one_lacks], axis=0
        ):
            here = np.flatnonzero(
                (colors[0] == values[:4]).all(axis=1) & (colors[1] == values[4:8]).all(axis=1)
            )
            wrong.append(_finding(a, part, values, faces[here, 0], len(faces), tolerances.color))
    wrong.sort(key=lambda finding: -(finding.difference or 0.0))
    summary = Finding(
        "structure", "colours", len(seen[0]), len(seen[1]), not wrong, "steps of 8 bit", float(largest),
        float(tolerances.color), reason="different colours of faces; the largest difference of a face",
    )  # fmt: skip
    return [summary, *limited(wrong)]


def _finding(
    a: Side, part: str, values: npt.NDArray[np.int16], faces: Int64s, of: int, tolerance: int
) -> Finding:
    """values: colour of A, colour of B, steps between them."""
    shown = [hex_of(values[:4]), hex_of(values[4:8])]
    place = part if len(faces) == of else f"{a.where(int(faces[0]))}"
    if 1 < len(faces) < of:
        place += f" and {len(faces) - 1} more of {part}"
    reason = "" if all(shown) else ("the colour is lost" if shown[0] else "a colour where none was")
    steps = float(values[8]) if all(shown) else None
    return found(
        "structure", "colour", shown, False, "steps of 8 bit", steps, float(tolerance),
        missing=not shown[1], where=place, reason=reason,
    )  # fmt: skip


def hex_of(rgba: npt.NDArray[np.int16]) -> str | None:
    """ "#rrggbb", with alpha if it is not opaque; None for no colour."""
    if rgba[0] < 0:
        return None
    return "#" + "".join(f"{int(x):02x}" for x in (rgba if rgba[3] < 255 else rgba[:3]))
