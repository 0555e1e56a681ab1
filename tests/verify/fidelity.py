"""Round trips of whole models: the store, written as STEP or BREP and read back, is the model it came from.

Everything is held to the strict profile: 1e-9 of the diagonal, 1e-9 of volume and area, whatever p-curves
made anew may excuse, and not one pixel. What OpenCascade's reader is known to change stands in
``fidelity_exceptions``, model by model, with its reason and its size; anything else is a failure.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import trimray
from trimray import exporter
from trimray.fidelity import Comparison, Finding, compare, read

from .fidelity_exceptions import Known, known_for

HEADER = (
    f"{'model':36} {'via':5} {'faces':>6} {'verdict':9} {'worst/diag':>10} {'volume':>9} {'area':>9} "
    f"{'allowed':>9} {'pixels':>6} {'s':>6} {'explained':>9} {'failures':>8}"
)

_EXACT = ("volume", "area")


@dataclass(frozen=True)
class Row:
    """distance: the worst one, of the diagonal. volume, area: relative differences. allowed: the larger
    tolerance of these two, relative. pixels: that differ, in all views together."""

    model: str
    via: str
    verdict: str
    faces: int
    distance: float
    volume: float
    area: float
    allowed: float
    pixels: int
    seconds: float
    explained: tuple[tuple[Finding, Known], ...] = ()
    failures: tuple[str, ...] = ()


def check(file: Path, via: str, *, points: int = 6000, time_limit: float = 300.0, start: str = "fork") -> Row:
    """start: as of ``trimray.load``; call preload before "fork". Raises trimray.Error where the model itself
    cannot be read."""
    begin = time.perf_counter()
    a = read(file, start=start, time_limit=time_limit)
    if a.failure is not None:
        raise a.failure
    if a.diagonal == 0.0:
        raise trimray.EmptyError(f"{file}: no face that can be drawn")
    with tempfile.TemporaryDirectory(prefix="trimray-") as folder:
        target = Path(folder) / f"{file.stem}.{via}"
        store = a.sound._core
        written = exporter.write(store, target, via=via, name=file.name, start=start, time_limit=time_limit)  # type: ignore[arg-type]
        b = read(target, start=start, cache=False, time_limit=time_limit)
    found = compare(a, b, profile="strict", points=points, images=False)
    failures = [f"not written: {a.where(face) if face >= 0 else ''} {why}" for face, why in written.issues]
    return row(file, via, len(a.sound.faces), a.diagonal, found, failures, time.perf_counter() - begin)


def row(
    file: Path, via: str, faces: int, diagonal: float, found: Comparison, failures: list[str], seconds: float
) -> Row:
    """What a comparison amounts to, once the known exceptions are taken out."""
    explained: list[tuple[Finding, Known]] = []
    if found.error:
        failures = [*failures, found.error]
    excused = [f for f in found.findings if f.same and f.name in _EXACT and _relative(f)[0] > 1e-9]
    for finding in [*found.differences(), *excused]:
        known = known_for(file.name, via, finding)
        if known is None:
            failures.append(describe(finding))
        else:
            explained.append((finding, known))
    values = {f.name: f for f in found.findings if not f.where}
    distances = [f.difference or 0.0 for n, f in values.items() if n.startswith("largest distance of ")]
    relative = {name: _relative(values.get(name)) for name in _EXACT}
    return Row(
        file.name, via, found.verdict, faces, max(distances, default=0.0) / (diagonal or 1.0),
        relative["volume"][0], relative["area"][0], max(most for _, most in relative.values()),
        sum(sum(p.differing.values()) for p in found.pictures), seconds, tuple(explained), tuple(failures),
    )  # fmt: skip


def _relative(finding: Finding | None) -> tuple[float, float]:
    """Difference and tolerance."""
    if finding is None or not finding.a:
        return 0.0, 0.0
    size = abs(float(finding.a))
    return abs(finding.difference or 0.0) / size, (finding.tolerance or 0.0) / size


def describe(finding: Finding) -> str:
    """On one line."""
    words = [finding.section, finding.name]
    if finding.a is not None or finding.b is not None:
        words.append(f"{_short(finding.a)} -> {_short(finding.b)}")
    if finding.difference is not None and finding.tolerance is not None:
        words.append(f"({finding.difference:.2e} of {finding.tolerance:.1e} {finding.unit})")
    return " ".join([*words, finding.where, finding.reason]).strip()


def _short(value: object) -> str:
    text = f"{value:.9g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 48 else f"{text[:45]}..."


def line(r: Row) -> str:
    return (
        f"{r.model:36.36} {r.via:5} {r.faces:6} {r.verdict:9} {r.distance:10.1e} {r.volume:9.1e} "
        f"{r.area:9.1e} {r.allowed:9.1e} {r.pixels:6} {r.seconds:6.1f} {len(r.explained):9} "
        f"{len(r.failures):8}"
    )


def preload() -> None:
    """So that forked children find OpenCascade there."""
    from trimray.exporter import document, from_store  # noqa: F401
    from trimray.importer import child, inspect_file  # noqa: F401

    child.preload()


def unreadable(file: Path, error: trimray.Error) -> str:
    return f"{file.name:36.36} {error}"
