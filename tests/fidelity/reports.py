"""Results made by hand, with everything that a report has to show."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from trimray.fidelity.record import Comparison, Finding, Picture, verdict_of
from trimray.fidelity.result import Result

# What a hostile file may call its parts: markup, templates, the end of a script, colours of a terminal, a
# turned reading direction, a path that is no UTF-8.
HOSTILE = "</script><img src=x onerror=alert(1)>{{script}}\x1b[31m\u202e]]>\udcff&amp;"

MOVED = Finding(
    "geometry", "distance of points of A from B", 0.0, 2.5e-3, False, "mm", 2.5e-3, 1e-6, where="face 12"
)
LOST = Finding("structure", "instance", "Bolt:2", None, False, missing=True, where="Top / Bolt:2")
VOLUME = Finding("mass", "volume", 6000.0, 6000.000001, True, "", 1.7e-10, 1e-6)
KINDS = Finding("topology", "faces by kind", {"plane": 6, "cylinder": 2}, {"plane": 6, "cylinder": 2}, True)


def png(offset: int = 0, size: int = 64) -> bytes:
    """A blue square on white, moved to the right by offset px."""
    pixels = np.full((size, size, 3), 255, np.uint8)
    pixels[16:48, 16 + offset : 48 + offset] = (40, 90, 160)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return stream.getvalue()


def comparison(
    *findings: Finding, a: str = "part.step", b: str = "part.step as STEP AP242", pictures: bool = True
) -> Comparison:
    views = (
        Picture("iso", (64, 64), {"depth": 0, "normal": 0, "coverage": 0}, png(), png(), png()),
        Picture("front", (64, 64), {"depth": 12, "normal": 340, "coverage": 64}, png(), png(4), png(8)),
    )
    return Comparison(
        a,
        b,
        "default",
        findings,
        views if pictures else (),
        seconds={"geometry": 0.25},
        verdict=verdict_of(findings),
    )


def results() -> list[Result]:
    """One of each: complete, partial, failed, unreadable, hostile."""
    nasty = Finding(
        "structure", HOSTILE, HOSTILE, [HOSTILE, float("nan")], False, reason=HOSTILE, where=HOSTILE
    )
    failed = Comparison(
        "b.step", "b.step by cp", "default", (), error="the writer ended with 3", verdict="failed"
    )
    return [
        Result(
            "good.step", "roundtrip", (comparison(VOLUME, KINDS, a="good.step", b="good.step as STEP AP242"),)
        ),
        Result("part.step", "roundtrip", (comparison(VOLUME, MOVED, LOST, KINDS),), exit_code=7),
        Result("b.step", "roundtrip", (failed,), exit_code=7),
        Result("gone.step", "roundtrip", (), "gone.step: No such file or directory", 3),
        Result(HOSTILE, "roundtrip", (comparison(nasty, a=HOSTILE, b=HOSTILE),), exit_code=7),
    ]
