"""Planted defects are found, and nothing is found in what was written cleanly: over real models."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import trimray
from trimray import exporter
from trimray.fidelity import Comparison, Side, compare, read

from .fidelity import describe
from .fidelity_exceptions import known_for
from .planted import DEFECTS, Defect, NotApplicable, plant

Via = Literal["step", "brep"]
SMALL: dict[str, Any] = {"points": 4000, "size": (192, 192), "images": False}
# Of all kinds: assemblies, splines, planes and cylinders, inches, IGES. The default of the full run.
MODELS = (
    "red_cube_blue_cylinder.step",
    "cornell_box_nurbs_colours.step",
    "M2X10",
    "dm1-id-214.stp",
    "base_interface_AP214.STEP",
    "wing128.igs",
    "as1-oc-214.stp",
    "TAIL_TURBINE.stp",
    "SOT404.igs",
    "nacelle.stp",
    "helix_thread.step",
    "4040_base_mount.step",
    "M6-1x12-countersunk-screw.step",
    "nist_ctc_01_asme1_ap242-e1.stp",
)


@dataclass(frozen=True)
class Row:
    """what: the defect, or "clean: ..." for none. good: found where it has to be, or nothing found."""

    model: str
    what: str
    good: bool | None  # None: the model has nothing of the kind
    verdict: str = ""
    where: str = ""
    sections: tuple[str, ...] = ()
    differences: tuple[str, ...] = ()


def check(file: Path) -> Iterator[Row]:
    """Raises trimray.Error where the model cannot be read."""
    a = read(file, start="fork")
    if a.failure is not None:
        raise a.failure
    with tempfile.TemporaryDirectory(prefix="trimray-") as folder:
        yield _clean(file, "clean: the file twice", "", a, read(file, start="fork", cache=False))
        again = _written(file, Path(folder) / "again.step", "step")
        yield _clean(file, "clean: as STEP", "file", a, again)
        bases = {via: _written(a.sound._core, Path(folder) / f"a.{via}", via) for via in ("step", "brep")}
        yield _clean(file, "clean: its store as STEP", "step", a, bases["step"])
        yield _clean(file, "clean: its store as BREP", "brep", a, bases["brep"])
        for defect in DEFECTS:
            yield _planted(file, a, bases[defect.via], defect, Path(folder) / f"b.{defect.via}")


def _written(source: Any, target: Path, via: Via) -> Side:
    exporter.write(source, target, via=via, start="fork")
    return read(target, start="fork", cache=False)


def _clean(file: Path, what: str, via: str, a: Side, b: Side) -> Row:
    """via: as of the known exceptions; "file" for the file as OpenCascade writes it."""
    found = compare(a, b, **SMALL)
    known = [known_for(file.name, via, finding) for finding in found.differences()]
    why = "; ".join(sorted({one.reason for one in known if one is not None}))
    return _row(file, what, not found.error and None not in known, found, why)


def _planted(file: Path, a: Side, base: Side, defect: Defect, target: Path) -> Row:
    """base: the same model, written without the defect."""
    try:
        where = plant(a.sound, defect, target, a.diagonal)
    except NotApplicable:
        return Row(file.name, defect.name, None)
    found = compare(base, read(target, start="fork", cache=False), **SMALL)
    told: set[str] = {finding.section for finding in found.differences()}
    return _row(file, defect.name, defect.found_in(told), found, where)


def _row(file: Path, what: str, good: bool, found: Comparison, where: str) -> Row:
    differences = tuple(describe(finding) for finding in found.differences())
    sections = tuple(sorted({finding.section for finding in found.differences()}))
    error = (found.error,) if found.error else ()
    return Row(file.name, what, good, found.verdict, where, sections, (*error, *differences))


def line(r: Row) -> str:
    state = {True: "as it should be", False: "WRONG", None: "not applicable"}[r.good]
    told = f"{r.verdict}: {', '.join(r.sections)}" if r.sections else r.verdict
    return f"{r.model:32.32} {r.what:26} {state:15} {r.where:20} {told}"


def files(every: list[Path]) -> list[Path]:
    """Those of MODELS."""
    return [file for file in every if any(name in file.name for name in MODELS)]


def run(every: list[Path], show: int) -> int:
    """Prints; returns how many defects were missed, or found where there are none."""
    wrong = found = clean = 0
    for file in every:
        try:
            for row in check(file):
                print(line(row), flush=True)
                wrong += row.good is False
                clean += bool(row.good) and row.what.startswith("clean")
                found += bool(row.good) and not row.what.startswith("clean")
                for difference in row.differences[:show] if row.good is False else ():
                    print(f"    {difference}", flush=True)
        except trimray.Error as error:
            print(f"{file.name:32.32} {error}", flush=True)
    print(f"{found} defects found, {clean} clean pairs without a difference, {wrong} wrong")
    return wrong
