"""The one comparison that check, roundtrip and compare share."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from trimray.importer.errors import UsageError
from trimray.views import choose

from .colors import compare_colors
from .findings import found
from .geometry import compare_geometry
from .mass import compare_mass
from .match import match
from .pcurves import compare_pcurves
from .pictures import SIZE, VIEWS, compare_pictures
from .record import Comparison, Finding, Picture, Verdict, verdict_of
from .side import Side, read
from .structure import compare_structure
from .tolerances import PROFILES, Tolerances
from .topology import compare_topology

Progress = Callable[[str, float | None], None]


def compare(
    a: Any,
    b: Any,
    *,
    profile: str = "default",
    pictures: bool = True,
    views: Sequence[str] = VIEWS,
    size: tuple[int, int] = SIZE,
    images: bool = True,
    colors: bool = True,
    points: int = 20000,
    seed: int = 0,
    names: tuple[str, str] | None = None,
    threads: int = 0,
    progress: Progress | None = None,
    **options: Any,
) -> Comparison:
    """A against B, each read once.

    a, b: paths, Models, shapes (cadquery, build123d, OCP), or what ``read`` made of them.
    profile: of ``tolerances.PROFILES``. pictures: draw both, in these views, each of size (width, height) px;
        images: as PNG, too, with an overlay of what differs.
    colors: compare those, too, of faces and in pictures.
    points: at least so many on each model are held against the other, by seed.
    names: what messages call the two. progress: called with a section. options: of ``trimray.load``.

    A model that cannot be read is no exception: the verdict is "failed", or "empty", and error says why.
    Raises UsageError.
    """
    tolerances = PROFILES[choose("profile", profile, PROFILES)]
    if points < 1:
        raise UsageError(f"points: {points} is not a number above 0")
    seconds: dict[str, float] = {}
    called = names or (None, None)
    sides = []
    for source, name, key in ((a, called[0], "read a"), (b, called[1], "read b")):
        start = time.perf_counter()
        sides.append(read(source, name=name, **options))
        seconds[key] = time.perf_counter() - start
    shown = sides[0].name, sides[1].name
    failed = _unread(sides[0], sides[1])
    if failed is not None:
        verdict, error = failed
        return Comparison(*shown, profile, (), error=error, seconds=seconds, verdict=verdict)
    findings: list[Finding] = []
    drawn: list[Picture] = []
    work = _Sections(sides[0], sides[1], tolerances, seconds, progress)
    findings += work.run("file", _file)
    matching = match(sides[0], sides[1])
    findings += work.run(
        "structure",
        lambda _a, _b, t: [
            *compare_structure(matching, t),
            *(compare_colors(matching, t) if colors else ()),
        ],
    )
    findings += work.run("topology", lambda x, y, _: compare_topology(x, y))
    findings += work.run("mass", compare_mass)
    findings += work.run(
        "geometry",
        lambda x, y, t: [
            *compare_geometry(matching, t, points=points, seed=seed, threads=threads),
            *compare_pcurves(matching, t),
        ],
    )

    def draw(x: Side, y: Side, t: Tolerances) -> list[Finding]:
        differences, made = compare_pictures(
            x, y, t, views=views, size=size, images=images, colors=colors, threads=threads
        )
        drawn.extend(made)
        return differences

    if pictures:
        findings += work.run("pictures", draw)
    return Comparison(
        *shown, profile, tuple(findings), tuple(drawn), seconds=seconds, verdict=verdict_of(tuple(findings))
    )


class _Sections:
    """Runs the sections of a comparison and takes their time."""

    def __init__(
        self, a: Side, b: Side, tolerances: Tolerances, seconds: dict[str, float], progress: Progress | None
    ) -> None:
        self._sides, self._tolerances = (a, b), tolerances
        self._seconds, self._progress = seconds, progress

    def run(self, name: str, work: Callable[[Side, Side, Tolerances], list[Finding]]) -> list[Finding]:
        if self._progress is not None:
            self._progress(name, None)
        start = time.perf_counter()
        findings = work(*self._sides, self._tolerances)
        self._seconds[name] = time.perf_counter() - start
        return findings


def _unread(a: Side, b: Side) -> tuple[Verdict, str] | None:
    """Verdict and reason where a side has no model to compare."""
    wrong = [side for side in (a, b) if side.error]
    if not wrong:
        return None
    empty = all(side.empty for side in wrong) and (b.empty or a.empty)
    return ("empty" if empty else "failed"), "; ".join(side.error for side in wrong)


def _file(a: Side, b: Side, _: Tolerances) -> list[Finding]:
    """What became of the files' faces."""
    undrawn = [len(side.sound.report.not_drawn) for side in (a, b)]
    same = undrawn[0] == undrawn[1]
    return [
        Finding("file", "format", a.format, b.format, True),
        found("file", "faces that cannot be drawn", undrawn, same, difference=float(undrawn[1] - undrawn[0]),
            missing=not same,
        ),
    ]  # fmt: skip
