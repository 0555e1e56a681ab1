"""Which entities of an IGES file did not arrive, and why."""

from typing import Any

from . import iges_text
from .iges_text import Entity, IgesText
from .report import Report, Severity, changes_shape
from .transfer_checks import binders_of, checks, why_lost

# Where the surface of a trimmed or bounded one stands among the parameters.
_SURFACE_PARAMETER = {143: 1, 144: 0, 510: 0, 140: 4}


class IgesAudit:
    """Compares a loaded and transferred IGES file with its text."""

    def __init__(self, reader: Any, text: IgesText, report: Report, *, changed: Severity = "note") -> None:
        self.reader, self.text, self.report, self.changed = reader, text, report, changed
        self.model = reader.IGESModel()

    def run(self, arrived: int) -> None:
        """arrived: distinct faces in the model."""
        entities = self.text.entities
        trimmed = {_pointer(e, _SURFACE_PARAMETER[e.type]) for e in entities if e.type in _SURFACE_PARAMETER}
        faces = [e for e in entities if e.type in iges_text.FACE_TYPES]
        loose = [
            e
            for e in entities
            if e.type in iges_text.SURFACE_TYPES
            and e.number not in trimmed
            and (e.type != 108 or e.form != 0)
            and e.type < 190
            and not self._used_by_curve(entities, e)
        ]
        self.report.faces_in_file = len(faces) + len(loose)
        self._checks()
        if arrived < len(faces) + len(loose):
            self._lost(faces + loose, arrived)
        self._not_understood(entities, arrived)

    def _used_by_curve(self, entities: list[Entity], surface: Entity) -> bool:
        return surface.subordinate and any(
            e.type == 142 and _pointer(e, 1) == surface.number for e in entities
        )

    def _checks(self) -> None:
        check = self.model.GlobalCheck()
        for index in range(1, min(check.NbFails(), 50) + 1):
            self.report.add("", "syntax", str(check.CFail(index)), "warning")
        process = self.reader.WS().TransferReader().TransientProcess()
        if process is None:
            return
        for number, fails, warnings in checks(process.CheckList(False)):
            found: list[tuple[list[str], Severity]] = [(fails, "warning"), (warnings, self.changed)]
            for messages, severity in found:
                if severity == self.changed and not changes_shape(messages):
                    severity = "note"
                if messages:
                    reason = "; ".join(dict.fromkeys(messages[:3]))
                    self.report.add(f"D{2 * number - 1}", self._kind(number), reason, severity)

    def _lost(self, wanted: list[Entity], arrived: int) -> None:
        """Names every face or loose surface without a result."""
        binders = binders_of(self.reader.WS().TransferReader().TransientProcess())
        lost = 0
        for entity in wanted:
            number = (entity.number + 1) // 2
            item = self.model.Entity(number) if number <= self.model.NbEntities() else None
            reason = why_lost(binders.get(item), "not reached from any root entity")
            if reason is None:
                continue
            lost += 1
            self.report.add(f"D{entity.number}", f"entity {entity.type}", reason)
        missing = len(wanted) - arrived - lost
        if missing > 0:
            self.report.add("", "face", f"{missing} faces were transferred but did not stay in a shape")

    def _not_understood(self, entities: list[Entity], arrived: int) -> None:
        """Solids by construction, and planes without a border."""
        for entity in entities:
            name = iges_text.SOLID_TYPES.get(entity.type)
            if name is not None and not entity.subordinate:
                reason = f"{name}: constructive solid geometry is not read"
                self.report.add(f"D{entity.number}", f"entity {entity.type}", reason)
            elif entity.type == 108 and entity.form == 0 and not entity.subordinate and arrived == 0:
                self.report.add(f"D{entity.number}", "entity 108", "plane without a border: no face", "note")

    def _kind(self, number: int) -> str:
        return (
            f"entity {self.model.Entity(number).TypeNumber()}"
            if 0 < number <= self.model.NbEntities()
            else "file"
        )


def _pointer(entity: Entity, index: int) -> int:
    try:
        return int(entity.parameters[index])
    except (IndexError, ValueError):
        return 0
