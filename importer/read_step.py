"""STEP files: AP203, AP214, AP242, with the files they refer to."""

import os
from pathlib import Path
from typing import Any

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPControl import STEPControl_Reader

from . import occt, xcaf
from .errors import InputError
from .report import Report
from .scene import Scene
from .sphere_seams import clear_seams
from .step_document import file_unit, open_step
from .step_report import StepAudit
from .step_text import StepText

# What the reader takes over beside shapes.
_MODES = ("Color", "Name", "Layer", "SHUO")


def read_step(
    path: str, *, name: str, heal: str, precision: float | None, report: Report
) -> tuple[Scene, str, float, dict[str, Any]]:
    """The scene, the unit's name, its size in mm, and facts of the source. Raises InputError."""
    data = Path(path).read_bytes()
    text = StepText(data)
    report.format = "step"
    broken = text.broken_off()
    if broken:
        raise InputError(f"{name}: {broken}")
    if broken == "":
        report.add("", "file", "the closing END-ISO-10303-21 is missing", "warning")
    reader, document = open_step(
        path, text, name=name, heal=heal, precision=precision, modes=_MODES, report=report
    )
    with report.stage("extract"):
        scene, without_faces = xcaf.read_document(document)
        report.add_curves(without_faces)
        externals = _external_texts(Path(path).parent, text, report)
        report.faces_in_file = sum(
            len(t.faces) + len(t.loose_surfaces) + len(t.tessellated) for t in (text, *externals)
        )
        arrived = _distinct_faces(scene)
        scene.session = reader.ChangeReader().WS()
        audit = StepAudit(scene.session, text, report, changed="error" if heal == "strict" else "note")
        audit.load()
        outside = sum(len(t.faces) + len(t.loose_surfaces) for t in externals)
        audit.transfer(max(0, arrived - outside))
        unit, unit_mm = file_unit(reader, report)
    return scene, unit, unit_mm, text.header()


def _distinct_faces(scene: Scene) -> int:
    return len({face.TShape() for part in scene.parts for face in occt.faces_of(part.shape)})


def _external_texts(folder: Path, text: StepText, report: Report) -> list[StepText]:
    """The texts of all files that ``text`` refers to, directly or not; missing ones are reported."""
    found: dict[str, StepText] = {}
    queue = list(text.external_files)
    while queue:
        reference = queue.pop(0)
        if reference in found:
            continue
        path = folder / reference.replace("\\", "/")
        if not path.is_file():
            path = folder / os.path.basename(reference.replace("\\", "/"))
        try:
            inner = StepText(path.read_bytes())
        except OSError as error:
            report.add(reference, "external reference", f"cannot be read: {error.strerror or error}")
            continue
        found[reference] = inner
        _report_seams(str(path), reference, inner, report)
        queue.extend(inner.external_files)
    return list(found.values())


def _report_seams(path: str, reference: str, text: StepText, report: Report) -> None:
    """Warns of the faces of an external file that OpenCascade, which reads it itself, may take for the rest
    of their sphere."""
    if b"SPHERICAL_SURFACE" not in text.data:
        return
    reader = STEPControl_Reader()
    if reader.ReadFile(path) != IFSelect_ReturnStatus.IFSelect_RetDone:
        return
    faces = clear_seams(reader.WS().Model(), text)
    if faces:
        more = f" and {len(faces) - 8} more" if len(faces) > 8 else ""
        reason = (
            f"{', '.join(faces[:8])}{more}: the sphere's seam runs along an edge: in an assembly the rest "
            "of the sphere may be drawn instead; the file by itself is drawn as it says"
        )
        report.add(reference, "ADVANCED_FACE", reason, "warning")
