"""What the text of a file declares, beside what arrived in the model."""

import re
from collections import Counter

from . import iges_text
from .inspection import Count, Lost, Prototype, Topology
from .report import Report
from .scene import Scene

_RECORD = re.compile(rb"#\d+\s*=\s*([A-Z_0-9]+)\s*\(")
_COMPLEX = re.compile(rb"#\d+\s*=\s*\(([^;]*)\)\s*;")
_DEFINITION = re.compile(rb"#(\d+)\s*=\s*PRODUCT_DEFINITION(?:_WITH_ASSOCIATED_DOCUMENTS)?\s*\(")
_SHAPE = re.compile(rb"=\s*PRODUCT_DEFINITION_SHAPE\s*\([^#;]*#(\d+)")
_WORD = re.compile(rb"([A-Z_][A-Z_0-9]*)\s*\(")


def entity_counts(format: str, data: bytes) -> dict[str, int]:
    """Records of each type. A complex STEP record counts for each of its parts."""
    if format == "step":
        found = Counter(match.decode() for match in _RECORD.findall(data))
        for match in _COMPLEX.finditer(data):
            found.update({word.decode() for word in _WORD.findall(match[1])})
        return dict(sorted(found.items()))
    if format == "iges":
        types = Counter(entity.type for entity in iges_text.parse(data).entities)
        return {str(type): count for type, count in sorted(types.items())}
    return {}


def compare(
    entities: dict[str, int],
    data: bytes,
    report: Report,
    scene: Scene,
    prototypes: tuple[Prototype, ...],
) -> tuple[Count, ...]:
    """What matters of the counts, with what the model has of it. Prototypes count once, as in the file."""
    once = Topology()
    for prototype in prototypes:
        once = once.plus(prototype.topology)
    faces = Count("faces", report.faces_in_file, report.faces)
    if report.format == "step":
        return (faces, *_step(entities, data, scene, once))
    if report.format == "iges":
        return (faces, *_iges(entities, once))
    return (faces,)


def _step(entities: dict[str, int], data: bytes, scene: Scene, once: Topology) -> tuple[Count, ...]:
    def total(*names: str) -> int:
        return sum(entities.get(name, 0) for name in names)

    return (
        Count(
            "solids",
            total("MANIFOLD_SOLID_BREP", "FACETED_BREP", "BREP_WITH_VOIDS"),
            once.solids,
        ),
        Count(
            "shells",
            total("CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET"),
            once.shells,
        ),
        Count("closed shells", total("CLOSED_SHELL"), once.closed_shells),
        Count("edges", total("EDGE_CURVE"), once.edges - once.degenerate_edges, False),
        Count("vertices", total("VERTEX_POINT"), once.vertices, False),
        Count("loops", total("FACE_BOUND", "FACE_OUTER_BOUND"), once.loops, False),
        Count("products", _products(data), scene.products),
        Count("instances", total("NEXT_ASSEMBLY_USAGE_OCCURRENCE"), scene.components),
        Count("styled items", total("STYLED_ITEM", "OVER_RIDING_STYLED_ITEM"), None),
        Count("layers", total("PRESENTATION_LAYER_ASSIGNMENT"), None),
    )


def _products(data: bytes) -> int:
    """Product definitions that have a shape; materials and documents are products, too."""
    definitions = set(_DEFINITION.findall(data))
    return len(definitions & set(_SHAPE.findall(data)))


def _iges(entities: dict[str, int], once: Topology) -> tuple[Count, ...]:
    def total(*types: int) -> int:
        return sum(entities.get(str(type), 0) for type in types)

    return (
        Count("solids", total(186), once.solids),
        Count("shells", total(514), once.shells),
        Count("instances", total(408), None),
        Count("colors", total(314), None),
    )


def lost_entities(report: Report) -> tuple[Lost, ...]:
    """What the report says of entities that are missing (error) or may differ (warning)."""
    return tuple(
        Lost(issue.entity, issue.kind, issue.reason, issue.severity)
        for issue in report.issues
        if issue.severity != "note"
    )
