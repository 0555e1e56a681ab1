"""trimray bench: what a model costs to draw, as the paper's table 1 has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .jobs import each_input, exit_code, read, tell_damage, tell_problems
from .output import json_text, write_stdout
from .progress import Sink

if TYPE_CHECKING:
    from trimray import Model

_NAME = 30  # characters of a model's name in the table, at most


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    from trimray.bench import measure

    def work(source: str, name: str, progress: Sink) -> tuple[Model, dict[str, Any]]:
        model = read(source, name, progress, options)
        camera = model.camera(
            options["size"], view=options["view"], projection=options["projection"], up=options["up"]
        )
        return model, measure(
            model, camera, seeds=options["seeds"], repeat=options["repeat"], progress=progress
        )

    codes: list[int] = []
    facts: list[dict[str, Any]] = []
    for done in each_input(inputs, options, work):
        if done.value is None:
            codes.append(done.exit_code)
            facts.append({"input": done.source, "error": done.error})
            continue
        model, figures = done.value
        facts.append({"input": done.name, **figures})
        tell_problems(done.name, model.report.reasons(), "trimray info --json")
        codes.append(0 if tell_damage(done.name, model.report) and model.report.complete else 1)
    if options["json"]:
        write_stdout(json_text(facts[0] if len(inputs) == 1 else facts))
    elif measured := [f for f in facts if "error" not in f]:
        write_stdout(as_text(measured))
    return exit_code(codes)


def as_text(facts: Sequence[dict[str, Any]]) -> str:
    """A table for the eye, a column a model."""
    rows = [("", [_short(f["input"]) for f in facts])]

    def row(title: str, cells: list[str]) -> None:
        rows.append((title, cells))

    row("picture", ["{} x {} px".format(*f["size"]) for f in facts])
    row("NURBS surfaces", [_count(f["nurbs_surfaces"]) for f in facts])
    row("triangles, to seed", [_count(f["triangles"]) for f in facts])
    row("screen coverage", [_percent(f["screen_coverage"]) for f in facts])
    row("BVH boxes, the paper's way", [_count(f["bvh_boxes"]["paper"]) for f in facts])
    row("BVH boxes", [_count(f["bvh_boxes"]["standard"]) for f in facts])
    kinds = [k for k in _TRACERS if any(k in f["intersections"] for f in facts)]
    for kind in kinds:
        counts = [f["intersections"].get(kind) for f in facts]
        row(f"intersections, {_TRACERS[kind]}", [_count(n) for n in counts])
    for threads, title in (("one_thread", "1 thread"), ("all_threads", "all threads")):
        for kind in kinds:
            rates = [f["frames_per_second"][threads].get(kind) for f in facts]
            row(f"fps, {title}, {_TRACERS[kind]}", ["-" if x is None else f"{x:.1f}" for x in rates])
    row("seeds drawn by", [f["raster"] or "none" for f in facts])
    row("hits from the seed's surface", [_percent(f["seeded_share"]) for f in facts])
    row("fallback to the hierarchy", [_percent(f["fallback_share"], 2) for f in facts])
    row("left to subdivision", [_percent(f["open_share"], 2) for f in facts])
    row("Newton steps a root", [_number(f["newton_steps"]) for f in facts])
    row("calls a covered pixel", [_number(f["calls_per_covered_pixel"]) for f in facts])
    for stage in ("mesh", "raster_id", "raster_uv", "trace", "shade"):
        cells = [f["stage_seconds"].get(stage) for f in facts]
        row(f"{stage.replace('_', ', ')}, ms", ["-" if x is None else f"{1e3 * x:.2f}" for x in cells])
    for part in ("store", "hierarchy", "paper_hierarchy"):
        title = {"paper_hierarchy": "hierarchy, the paper's way"}.get(part, part)
        row(f"{title}, MB", [f"{1e-6 * f['bytes'][part]:.2f}" for f in facts])
    first = max(len(title) for title, _ in rows)
    widths = [max(len(cells[k]) for _, cells in rows) for k in range(len(facts))]
    return "".join(
        f"{title:{first}}"
        + "".join(f"  {cell:>{width}}" for cell, width in zip(cells, widths, strict=True)).rstrip()
        + "\n"
        for title, cells in rows
    )


_TRACERS = {
    "paper": "standard, the paper's way",
    "standard": "standard",
    "hybrid": "hybrid, no seeds",
    "hybrid_id": "hybrid, ID processing",
    "hybrid_uv": "hybrid, uv processing",
}


def _short(name: str) -> str:
    last = name.rsplit("/", 1)[-1]
    return last if len(last) <= _NAME else last[: _NAME - 3] + "..."


def _count(n: int | None) -> str:
    return "-" if n is None else f"{n:,}"


def _percent(share: float | None, digits: int = 1) -> str:
    return "-" if share is None else f"{share:.{digits}%}"


def _number(x: float | None) -> str:
    return "-" if x is None else f"{x:.2f}"
