"""Names of components in a STEP model that OpenCascade has made, but not yet written.

Its writer finds a component by shape and place alone: where two assemblies hold the same part in the same
place, the name of the later one ends up at the former.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from OCP.StepRepr import StepRepr_NextAssemblyUsageOccurrence
from OCP.TCollection import TCollection_AsciiString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool


def restore_names(model: Any, document: TDocStd_Document) -> None:
    """model: StepData_StepModel made of the document. Assemblies that do not match it are left alone."""
    entities = [model.Value(i) for i in range(1, model.NbEntities() + 1)]
    uses: dict[int, list[tuple[Any, int]]] = defaultdict(list)  # (occurrence, part) by assembly
    held = set()
    for entity in entities:  # all are alive: id() tells definitions apart
        if isinstance(entity, StepRepr_NextAssemblyUsageOccurrence):
            part = id(entity.RelatedProductDefinition())
            uses[id(entity.RelatingProductDefinition())].append((entity, part))
            held.add(part)
    free = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(free)
    roots = [label for label in free if XCAFDoc_ShapeTool.IsAssembly_s(label)]
    definitions = [definition for definition in uses if definition not in held]
    if len(roots) == len(definitions):
        done: set[int] = set()
        for label, definition in zip(roots, definitions, strict=True):
            _restore(label, definition, uses, done)


def _restore(
    assembly: TDF_Label, definition: int, uses: dict[int, list[tuple[Any, int]]], done: set[int]
) -> None:
    components = TDF_LabelSequence()
    XCAFDoc_ShapeTool.GetComponents_s(assembly, components)
    occurrences = uses[definition]
    if definition in done or components.Length() != len(occurrences):
        return
    done.add(definition)
    for component, (occurrence, part) in zip(components, occurrences, strict=True):
        name = TCollection_HAsciiString(TCollection_AsciiString(_name(component)))
        if not occurrence.Name().IsSameString(name):
            occurrence.SetName(name)
        target = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(component, target)
        if XCAFDoc_ShapeTool.IsAssembly_s(target):
            _restore(target, part, uses, done)


def _name(label: TDF_Label) -> str:
    """ "" where there is none."""
    if not label.IsAttribute(TDataStd_Name.GetID_s()):
        return ""
    attribute = TDataStd_Name()
    label.FindAttribute(TDataStd_Name.GetID_s(), attribute)
    return str(attribute.Get().ToExtString())
