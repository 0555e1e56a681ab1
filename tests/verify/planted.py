"""Defects planted into real models: the arrays of their store are changed, and written as a file again.

What an exporter gets wrong is one number, one entity or one name; so is what is changed here. Each defect
says which sections of a comparison have to find it.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import trimray

Arrays = dict[str, Any]
Meta = dict[str, Any]

_BSPLINE = 8  # store.h, SurfaceKind
_PLANE, _TORUS = 0, 4
# Of the diagonal.
_MOVE = 1e-4


class NotApplicable(Exception):
    """The model has nothing of this kind to break."""


@dataclass(frozen=True)
class Defect:
    """plant: changes arrays and meta, given the diagonal (mm); returns what it has changed. sections: those
    that have to tell. via: the format it survives in; OpenCascade's STEP reader mends some. edit: of the
    text.
    """

    name: str
    plant: Callable[[Arrays, Meta, float], str]
    sections: frozenset[str]
    via: str = "step"
    edit: Callable[[str], str] | None = None
    any_of: bool = False  # one of the sections will do

    def found_in(self, sections: set[str]) -> bool:
        return bool(self.sections & sections) if self.any_of else self.sections <= sections


def plant(model: trimray.Model, defect: Defect, target: Path, diagonal: float) -> str:
    """Writes the model with the defect; returns what was changed. Raises NotApplicable."""
    from trimray.exporter.files import write_file
    from trimray.exporter.from_store import rebuild
    from trimray.importer.occt import initialize

    initialize()
    arrays = {name: np.array(array) for name, array in model._core.arrays().items()}
    meta = copy.deepcopy(model._meta)
    what = defect.plant(arrays, meta, diagonal)
    write_file(rebuild(arrays, json.dumps(meta)), str(target), defect.via, "ap242", faithful=True)
    if defect.edit is not None:
        text = target.read_text("latin-1")
        edited = defect.edit(text)
        assert edited != text
        target.write_text(edited, "latin-1")
    return what


def _sound_faces(arrays: Arrays) -> Any:
    """Numbers of drawable faces with loops, those with the largest boxes first."""
    faces = arrays["faces"]
    loops = np.diff(faces["loops"], axis=1).ravel()
    good = np.flatnonzero((faces["status"] == 0) & (loops > 0))
    if not len(good):
        raise NotApplicable
    return good[np.argsort([-_reach(arrays, face) for face in good.tolist()], kind="stable")]


def _reach(arrays: Arrays, face: int) -> float:
    """mm, of the box of its edges' control points."""
    coedges = arrays["coedges"]
    edges = np.unique(coedges["edge"][coedges["face"] == face])
    spans = [arrays["edge_pieces"]["ctrl"][slice(*arrays["edges"]["pieces"][e].tolist())] for e in edges]
    rows = [arrays["edge_ctrl_h"][b:e] for span in spans for b, e in span.tolist()]
    if not rows:
        return 0.0
    points = np.concatenate(rows)
    return float(np.linalg.norm(np.ptp(points[:, :3] / points[:, 3:], axis=0)))


def moved_face(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    face = int(_sound_faces(arrays)[0])
    number = int(arrays["faces"][face]["surface"])
    record = arrays["surfaces"][number]
    begin, end = record["ctrl"].tolist()
    along = record["z_axis"] if record["kind"] == _PLANE else record["x_axis"]
    if record["kind"] > _TORUS:
        along = _across(arrays["ctrl_h"][begin:end], int(record["count_v"]))
    shift = _MOVE * diagonal * along
    arrays["surfaces"]["location"][number] += shift
    arrays["ctrl_h"][begin:end, :3] += shift * arrays["ctrl_h"][begin:end, 3:]
    return f"face {face}"


def _across(ctrl_h: Any, columns: int) -> Any:
    """The normal of a net of control points, at its largest cell."""
    net = (ctrl_h[:, :3] / ctrl_h[:, 3:]).reshape(-1, columns, 3)
    crosses = np.cross(net[1:, :-1] - net[:-1, :-1], net[:-1, 1:] - net[:-1, :-1]).reshape(-1, 3)
    sizes = np.linalg.norm(crosses, axis=1)
    largest = int(sizes.argmax())
    return crosses[largest] / sizes[largest]


def flipped_face(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    face = int(_sound_faces(arrays)[0])
    arrays["faces"]["reversed"][face] ^= True
    return f"face {face}"


def lost_hole(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    faces = arrays["faces"]
    for face in _sound_faces(arrays).tolist():
        begin, end = faces["loops"][face].tolist()
        if end - begin < 2 or arrays["surfaces"]["kind"][faces["surface"][face]] != _PLANE:
            continue
        sizes = [_loop_size(arrays, loop) for loop in range(begin, end)]
        outer = begin + int(np.argmax(sizes))
        smallest = begin + int(np.argmin(sizes))
        if smallest in (begin, end - 1) and smallest != outer:
            faces["loops"][face] = (begin + 1, end) if smallest == begin else (begin, end - 1)
        elif outer in (begin, end - 1):
            faces["loops"][face] = (outer, outer + 1)
        else:
            continue
        return f"face {face}"
    raise NotApplicable


def _loop_size(arrays: Arrays, loop: int) -> float:
    coedges = arrays["coedges"][slice(*arrays["loops"]["coedges"][loop].tolist())]
    spans = [s for c in coedges for s in arrays["trim_pieces"]["ctrl"][slice(*c["pieces"].tolist())].tolist()]
    points = np.concatenate(
        [arrays["trim_ctrl_h"][b:e, :2] / arrays["trim_ctrl_h"][b:e, 2:] for b, e in spans]
    )
    return float(np.prod(np.ptp(points, axis=0)))


def changed_color(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    """Of one face, by five steps in green."""
    face = int(_sound_faces(arrays)[0])
    color = arrays["faces"]["color"][face]
    prototype = int(arrays["faces"]["prototype"][face])
    instances = arrays["instances"]
    for other in (
        *instances["color"][instances["prototype"] == prototype],
        arrays["prototypes"]["color"][prototype],
    ):
        if color[0] < 0.0:
            color = other
    if color[0] < 0.0:
        color = np.array([0.5, 0.5, 0.5, 1.0])
    color = np.array(color)
    color[1] += 5 / 255 if color[1] < 0.5 else -5 / 255
    arrays["faces"]["color"][face] = color
    return f"face {face}"


def renamed_part(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    for prototype in meta["prototypes"]:
        name = prototype.get("name", "")
        if re.search(r"[A-Za-z]{3}", name) and not name.startswith("Open CASCADE"):
            prototype["name"] = name[::-1] + "2"
            return str(name)
    raise NotApplicable


def _leaves(meta: Meta) -> list[int]:
    leaves = [i for i, node in enumerate(meta.get("tree") or ()) if node["prototype"] >= 0]
    if len(leaves) < 2:
        raise NotApplicable
    return leaves


def dropped_instance(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    leaf = _leaves(meta)[-1]
    row = next(i for i, about in enumerate(meta["instances"]) if about["node"] == leaf)
    name = meta["tree"][leaf]["name"]
    _drop_node(meta, leaf)
    del meta["instances"][row]
    for about in meta["instances"]:
        about["node"] -= about["node"] > leaf
    arrays["instances"] = np.delete(arrays["instances"], row)
    return str(name)


def _drop_node(meta: Meta, number: int) -> None:
    del meta["tree"][number]
    for node in meta["tree"]:
        node["parent"] -= node["parent"] > number


def swapped_transform(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    """Of two parts below one assembly."""
    leaves = _leaves(meta)
    tree = meta["tree"]
    for i in leaves:
        for j in leaves:
            one, other = tree[i], tree[j]
            alike = one["prototype"] == other["prototype"] or one["parent"] != other["parent"]
            if i < j and not alike and not np.allclose(one["placement"], other["placement"]):
                one["placement"], other["placement"] = other["placement"], one["placement"]
                return f"{one['name']} and {other['name']}"
    raise NotApplicable


def changed_knot(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    """One inner knot of the largest spline face that has one, by a hundredth of its span. A knot as multiple
    as the degree only parts two polynomials: moved, it leaves the surface where it is."""
    for face in _sound_faces(arrays).tolist():
        record = arrays["surfaces"][int(arrays["faces"]["surface"][face])]
        if int(record["kind"]) != _BSPLINE:
            continue
        for key, degree in (("knots_u", record["degree_u"]), ("knots_v", record["degree_v"])):
            begin, end = record[key].tolist()
            knots = arrays["knots"][begin:end]
            values, counts = np.unique(knots, return_counts=True)
            simple = [i for i in range(1, len(values) - 1) if counts[i] < degree]
            if simple:
                middle = simple[len(simple) // 2]
                knots[knots == values[middle]] += 1e-2 * (values[middle + 1] - values[middle])
                return f"face {face}"
    raise NotApplicable


def degraded_pcurve(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    """Of one edge of the largest face, by a thousandth of the face's size."""
    for face in _sound_faces(arrays).tolist():
        sizes = np.ptp(arrays["faces"]["uv_box"][face], axis=0)
        for coedge in np.flatnonzero(arrays["coedges"]["face"] == face).tolist():
            record = arrays["coedges"][coedge]
            if record["seam"] or arrays["edges"]["degenerate"][record["edge"]]:
                continue
            for begin, end in arrays["trim_pieces"]["ctrl"][slice(*record["pieces"].tolist())].tolist():
                points = arrays["trim_ctrl_h"][begin:end]
                points[:, :2] += 1e-3 * sizes * points[:, 2:]
            return f"edge {int(record['edge'])}"
    raise NotApplicable


def missing_face(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    faces = _sound_faces(arrays)
    face = int(faces[len(faces) // 2])
    arrays["faces"]["status"][face] = 1
    return f"face {face}"


def in_millimetres(arrays: Arrays, meta: Meta, diagonal: float) -> str:
    meta["unit"] = "mm"
    return "unit"


def as_inches(text: str) -> str:
    """The numbers of a file in mm, called inches."""
    inch = r"#\1=(CONVERSION_BASED_UNIT('INCH',#9000001)LENGTH_UNIT()NAMED_UNIT(#9000002));"
    found = r"#(\d+)\s*=\s*\(\s*LENGTH_UNIT\(\)\s*NAMED_UNIT\(\*\)\s*SI_UNIT\(\.MILLI\.,\.METRE\.\)\s*\)\s*;"
    shared = (
        "#9000001=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9000003);\n"
        "#9000002=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
        "#9000003=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n"
    )
    edited = re.sub(found, inch, text)
    head, mark, tail = edited.rpartition("ENDSEC;")
    return head + shared + mark + tail


def _of(*sections: str) -> frozenset[str]:
    return frozenset(sections)


DEFECTS = (
    Defect("moved face", moved_face, _of("geometry")),
    Defect("flipped face", flipped_face, _of("geometry"), via="brep"),
    Defect("lost hole", lost_hole, _of("topology", "mass")),
    Defect("changed colour", changed_color, _of("structure")),
    Defect("renamed part", renamed_part, _of("structure")),
    Defect("dropped instance", dropped_instance, _of("structure", "topology")),
    Defect("inch for millimetre", in_millimetres, _of("mass", "geometry"), edit=as_inches),
    Defect("swapped transform", swapped_transform, _of("structure", "geometry")),
    Defect("changed knot", changed_knot, _of("geometry", "pictures"), any_of=True),
    Defect("degraded p-curve", degraded_pcurve, _of("geometry"), via="brep"),
    Defect("missing face", missing_face, _of("topology", "geometry")),
)
