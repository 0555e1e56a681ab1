"""trimray info: what is in a file."""

from __future__ import annotations

from collections import Counter
from typing import Any

from trimray import EmptyError, Model
from trimray.faces import Color

from .jobs import each_input, exit_code, read, tell_damage, tell_problems
from .output import json_text, write_stdout
from .progress import Sink


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""

    def work(source: str, name: str, progress: Sink) -> Model:
        return read(source, name, progress, options)

    codes: list[int] = []
    facts: list[dict[str, Any]] = []
    for done in each_input(inputs, options, work):
        if done.value is None:
            codes.append(done.exit_code)
            facts.append({"input": done.source, "error": done.error})
            continue
        name, model = done.name, done.value
        about = describe(name, model)
        facts.append(about)
        if not options["json"]:
            write_stdout(("\n" if len(codes) else "") + as_text(about))
            tell_problems(name, model.report.reasons(), "--json")
        codes.append(0 if tell_damage(name, model.report) and model.report.complete else 1)
    if options["json"]:
        write_stdout(json_text(facts[0] if len(inputs) == 1 else facts))
    return exit_code(codes)


def describe(name: str, model: Model) -> dict[str, Any]:
    """JSON-able facts. Lengths in mm."""
    kinds: Counter[str] = Counter()
    colors: Counter[Color | None] = Counter()
    per_part: Counter[str] = Counter()
    for face in model.faces:
        kinds[face.kind] += 1
        colors[face.color] += 1
    for instance in model.instances:
        per_part[instance.part] += 1
    parts = {i.part: len(i.faces) for i in model.instances}
    try:
        bounds: list[list[float]] | None = model.bounds.tolist()
    except EmptyError:
        bounds = None
    return {
        "input": name,
        "unit": model.unit,
        "bounds_mm": bounds,
        "faces": len(model.faces),
        "faces_by_kind": dict(kinds.most_common()),
        "instances": len(model.instances),
        "parts": [{"name": p, "faces": parts[p], "instances": n} for p, n in per_part.most_common()],
        "colors": [
            {"color": None if c is None else _hex(c), "faces": n}
            for c, n in sorted(colors.items(), key=lambda item: -item[1])
        ],
        "report": model.report.as_dict(),
    }


def as_text(about: dict[str, Any]) -> str:
    """The same for the eye."""
    report = about["report"]
    lines = [f"{about['input']}"]
    if about["bounds_mm"] is not None:
        low, high = about["bounds_mm"]
        size = " x ".join(f"{b - a:.6g}" for a, b in zip(low, high, strict=True))
        lines.append(f"  size       {size} mm")
        corners = "  to  ".join(", ".join(f"{x:.6g}" for x in corner) for corner in (low, high))
        lines.append(f"  bounds     {corners} mm")
    lines.append(f"  unit       {about['unit']}")
    declared = report["faces_in_file"]
    lines.append(
        f"  faces      {about['faces']}: {report['drawn']} drawn, {len(report['not_drawn'])} not"
        + ("" if declared is None else f" (the file declares {declared})")
    )
    lines += [f"    {kind:<14} {count:>7}" for kind, count in about["faces_by_kind"].items()]
    lines.append(f"  parts      {len(about['parts'])} in {about['instances']} places")
    for part in about["parts"][:30]:
        lines.append(f"    {part['name'] or '(unnamed)'}: {part['faces']} faces, {part['instances']} x")
    if len(about["parts"]) > 30:
        lines.append(f"    and {len(about['parts']) - 30} more")
    colors = [f"{c['color'] or 'none'} ({c['faces']})" for c in about["colors"][:12]]
    lines.append(f"  colours    {', '.join(colors)}" + (" ..." if len(about["colors"]) > 12 else ""))
    return "\n".join(lines) + "\n"


def _hex(color: Color) -> str:
    digits = "".join(f"{round(255 * x):02x}" for x in color)
    return "#" + (digits[:6] if color[3] >= 1.0 else digits)
