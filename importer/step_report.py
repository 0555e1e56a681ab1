"""Which entities of a STEP file did not arrive, and why."""

import re
from typing import Any

from OCP.StepShape import StepShape_FaceSurface

from .report import Report, Severity, changes_shape
from .step_text import StepText
from .transfer_checks import binders_of, checks, fails_of, message_text, why_lost

# Warnings of the transfer that say nothing about the geometry.
_HARMLESS = ("No Length Uncertainty", "is an empty LIST", "not Derived", "is out of scope")

# Entities of these packages of OCCT carry geometry and topology; the others styles, products, dimensions.
_GEOMETRY_PACKAGES = ("StepGeom", "StepShape")

# Records of other packages that place geometry.
_PLACING = (
    "PRODUCT_DEFINITION_SHAPE",
    "SHAPE_DEFINITION_REPRESENTATION",
    "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION",
    "NEXT_ASSEMBLY_USAGE_OCCURRENCE",
)

# What OCCT says of a record that names another one as what that is not, such as a shell of a face. It leaves
# the member out. The number is that of the parameter, or of the member in a list.
_NOT_ONE = re.compile(r"Parameter n\d+(?:\.(\d+))? \(([^)]*)\) : Entity has illegal type")

# Annotations that AP203 and AP214 let a shape representation hold, some of which OCCT does not know.
_ANNOTATION = re.compile(
    rb"\b(?:ANNOTATION_\w+|DRAUGHTING_\w+|\w+_CALLOUT|(?:\w+_)?TEXT(?:_\w+)?|(?:\w+_)?SYMBOL|SYMBOL_TARGET)\s*\("
)


class StepAudit:
    """Compares one loaded and transferred STEP file with its text.

    session: XSControl_WorkSession. changed: severity of what healing had to change.
    """

    def __init__(self, session: Any, text: StepText, report: Report, *, changed: Severity = "note") -> None:
        self.session, self.text, self.report, self.changed = session, text, report, changed
        self.model = session.Model()

    def load(self) -> None:
        """Syntax errors and entities whose parameters OCCT could not understand."""
        check = self.model.GlobalCheck()
        for index in range(1, min(check.NbFails(), 50) + 1):
            message = message_text(check.CFail(index))
            if not message.startswith("Parameter #"):  # of the header
                self.report.add("", "syntax", message, "warning")
        for spline in self.text.knot_defects():
            self.report.add(f"#{spline.id}", "knots", spline.kind, "warning")
        groups: dict[tuple[str, str], list[int]] = {}
        for number in list(filter(self.model.IsErrorEntity, range(1, self.model.NbEntities() + 1))):
            check = self.model.Check(number, True)
            fails = fails_of(check)
            if fails:
                reason = "; ".join(dict.fromkeys(fails[:3]))
                groups.setdefault((self._kind(number), reason), []).append(number)
                if self._package(number) == "StepShape" or self._kind(number) in _PLACING:
                    self._lost_members(number, fails)
        for (kind, reason), numbers in groups.items():
            more = f" (and {len(numbers) - 1} more)" if len(numbers) > 1 else ""
            geometric = self._package(numbers[0]) in _GEOMETRY_PACKAGES
            severity: Severity = "warning" if geometric else "note"
            self.report.add(self._label(numbers[0]), kind, reason + more, severity)

    def _package(self, number: int) -> str:
        """OCCT's, of an entity's type."""
        return type(self.model.Value(number)).__module__.rpartition(".")[2]

    def _lost_members(self, number: int, fails: list[str]) -> None:
        """What a shell, face, loop, ... should have and does not get."""
        label = self._label(number)
        id = int(label[1:]) if label.startswith("#") else 0
        for match in filter(None, map(_NOT_ONE.search, fails)):
            member = self.text.member(id, int(match[1] or 0))
            what = match[2].rpartition(".")[2] or "member"
            reason = f"{self._kind(number)} {label} names it as its {what}, which it is not"
            severity: Severity = "error"
            if what == "representation_item" and _ANNOTATION.match(
                self.text.record(member).lstrip(b" \r\n(")
            ):
                reason, severity = f"an annotation of {self._kind(number)} {label}: not drawn", "note"
            self.report.add(f"#{member}" if member else label, what, reason, severity)

    def transfer(self, arrived: int) -> None:
        """Lost faces and changes by healing. arrived: distinct faces in the model."""
        process = self.session.TransferReader().TransientProcess()
        expected = len(self.text.faces) + len(self.text.loose_surfaces)
        failed = False
        if process is not None:
            for number, fails, warnings in checks(process.CheckList(False)):
                failed = failed or bool(fails)
                found: list[tuple[list[str], Severity]] = [(fails, "warning"), (warnings, self.changed)]
                for messages, severity in found:
                    kept = [
                        m
                        for m in dict.fromkeys(messages)
                        if not m.strip().startswith(_HARMLESS) and m.strip()
                    ]
                    kept = [m for m in kept if not any(word in m for word in _HARMLESS)]
                    if severity == self.changed and not changes_shape(kept):
                        severity = "note"
                    if kept:
                        self.report.add(
                            self._label(number), self._kind(number), "; ".join(kept[:3]), severity
                        )
        if arrived < expected or failed:
            self._lost_faces(process, arrived)
        if arrived < expected:
            self._lost_surfaces(arrived)
        if self.text.tessellated:
            first = self.text.tessellated[0]
            reason = f"{len(self.text.tessellated)} faces are given as triangles: drawn as they are"
            self.report.add(f"#{first.id}", first.kind, reason, "note")
        if self.text.tessellated_sets:
            first = self.text.tessellated_sets[0]
            reason = f"{len(self.text.tessellated_sets)} triangle sets (annotations or meshes): not drawn"
            self.report.add(f"#{first.id}", first.kind, reason, "note")
        if arrived == 0:
            for surface in self.text.unused_surfaces:
                defect = self.text.grid_defect(surface.id)
                reason = "no face and no shape representation uses it" + (f"; {defect}" if defect else "")
                self.report.add(f"#{surface.id}", surface.kind, reason)

    def _lost_faces(self, process: Any, arrived: int) -> None:
        """Names every face entity without a result."""
        binders = binders_of(process)
        lost = 0
        for number in range(1, self.model.NbEntities() + 1):
            entity = self.model.Value(number)
            if not isinstance(entity, StepShape_FaceSurface):
                continue
            reason = why_lost(binders.get(entity), "not reached from any shape representation")
            if reason is None:
                continue
            lost += 1
            if self.model.IsErrorEntity(number):
                reason += "; " + (
                    message_text(self.model.Check(number, True).CFail(1)) or "unreadable parameters"
                )
            self.report.add(self._label(number), self._kind(number), reason)
        unread = len(self.text.faces) - sum(
            isinstance(self.model.Value(i), StepShape_FaceSurface)
            for i in range(1, self.model.NbEntities() + 1)
        )
        if unread > 0:
            self.report.add("", "face", f"{unread} face records stand in the file but were not recognised")
        missing = len(self.text.faces) - arrived - lost - max(unread, 0)
        if missing > 0:
            self.report.add("", "face", f"{missing} faces were transferred but did not stay in a shape")

    def _lost_surfaces(self, arrived: int) -> None:
        for surface in self.text.loose_surfaces:
            if defect := self.text.grid_defect(surface.id):
                self.report.add(f"#{surface.id}", surface.kind, defect)

    def _label(self, number: int) -> str:
        """#id of an entity, from the order of the records in the text; "" where that order is not certain."""
        ids = self.text.record_ids
        if 0 < number <= len(ids) == self.model.NbEntities():
            return f"#{ids[number - 1].decode()}"
        return f"entity {number}" if number > 0 else ""

    def _kind(self, number: int) -> str:
        """STEP name of an entity's type: StepShape_AdvancedFace -> ADVANCED_FACE."""
        if number <= 0:
            return "file"
        name = type(self.model.Value(number)).__name__.rpartition("_")[2]
        return "".join("_" + c if c.isupper() and i else c for i, c in enumerate(name)).upper()
