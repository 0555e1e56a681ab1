"""From the store's topology to OpenCascade's: vertices, edges, wires, faces, shells, solids of a prototype.

Shared vertices and edges are shared, tolerances are the file's, and nothing is healed. What cannot be said is
left out and listed in ``issues``.
"""

from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_Surface
from OCP.gp import gp_Pnt
from OCP.Poly import Poly_Triangle, Poly_Triangulation
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import (
    TopoDS,
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Shape,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Vertex,
    TopoDS_Wire,
)

from ..importer.shapes import compound_of
from .curves import flat_curve, point, space_curve
from .splines import CurveError, Floats, Spline, joined
from .surfaces import PLANE, SurfaceError, surface_of

CONFUSION = 1e-7  # mm: the tolerance of what the file gave none, OpenCascade's least
_FORWARD, _REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED
_SAME = 1e-12  # of the prototype's size: a p-curve in a plane is the projection of its edge


class PrototypeBuilder:
    """Builds one prototype; ``shape``, ``faces`` (by number in the store) and ``issues`` are the result."""

    def __init__(self, arrays: dict[str, Any], index: int) -> None:
        self.arrays = arrays
        self.record = arrays["prototypes"][index]
        self.faces: dict[int, TopoDS_Face] = {}
        self.issues: list[tuple[int, str]] = []  # (face, reason)
        self._builder = BRep_Builder()
        self._vertices: dict[int, TopoDS_Vertex] = {}
        self._edges: dict[int, tuple[TopoDS_Edge, Spline | None]] = {}
        self._size = float(np.linalg.norm(np.ptp(self.record["bounds"], axis=0)))
        begin, end = self.record["faces"].tolist()
        for face in range(begin, end):
            self._add_face(face)
        self.shape = self._assemble()

    def _add_face(self, number: int) -> None:
        f = self.arrays["faces"][number]
        begin, end = f["triangles"].tolist()
        if begin < end:
            self.faces[number] = self._mesh_face(begin, end)
            return
        if int(f["status"]) != 0:
            self.issues.append((number, "the store holds no geometry for it"))
            return
        try:
            within = f["uv_box"] if self._has_seam(f) else None
            surface = surface_of(self.arrays, int(f["surface"]), within)
            self.faces[number] = self._trimmed(f, surface)
        except (SurfaceError, CurveError) as error:
            self.issues.append((number, str(error)))

    def _has_seam(self, f: Any) -> bool:
        """Does an edge bound the face on both sides?"""
        used = [self.arrays["coedges"][slice(*loop["coedges"].tolist())]["edge"]
                for loop in self.arrays["loops"][slice(*f["loops"].tolist())]]  # fmt: skip
        edges = np.concatenate(used) if used else np.zeros(0, int)
        return len(np.unique(edges)) < len(edges)

    def _trimmed(self, f: Any, surface: Geom_Surface) -> TopoDS_Face:
        loops = range(*f["loops"].tolist())
        face = TopoDS_Face()
        if len(loops) == 0:
            (u0, v0), (u1, v1) = f["uv_box"].tolist()
            made = BRepBuilderAPI_MakeFace(surface, u0, u1, v0, v1, CONFUSION)
            face = made.Face()
        else:
            self._builder.MakeFace(face, surface, TopLoc_Location(), CONFUSION)
            plane = self.arrays["surfaces"][int(f["surface"])] if self._is_plane(f) else None
            wires = [w for w in map(self._coedges, loops) if w is not None]
            self._put_on(wires, surface, plane)
            for wire in wires:
                self._builder.Add(face, self._wire(wire))
        return TopoDS.Face_s(face.Oriented(_REVERSED if f["reversed"] else _FORWARD))

    def _is_plane(self, f: Any) -> bool:
        return int(self.arrays["surfaces"][int(f["surface"])]["kind"]) == PLANE

    def _coedges(self, loop: int) -> Any | None:
        """The records of a loop; None for one of poles alone, which copies another loop one period on."""
        coedges = self.arrays["coedges"][slice(*self.arrays["loops"][loop]["coedges"].tolist())]
        poles: bool = self.arrays["edges"]["degenerate"][coedges["edge"]].all()
        return None if poles else coedges

    def _wire(self, coedges: Any) -> TopoDS_Wire:
        wire = TopoDS_Wire()
        self._builder.MakeWire(wire)
        for number, turned in zip(coedges["edge"].tolist(), coedges["reversed"].tolist(), strict=True):
            edge, _ = self._edge(number)
            self._builder.Add(wire, edge.Oriented(_REVERSED if turned else _FORWARD))
        wire.Closed(True)
        return wire

    def _put_on(self, wires: list[Any], surface: Geom_Surface, plane: Any | None) -> None:
        """The p-curves of all edges on a surface: one each, or two where the surface's seam lies on it."""
        uses: dict[int, dict[bool, tuple[Spline, Any | None]]] = {}
        for c in (c for wire in wires for c in wire):
            pieces = self.arrays["trim_pieces"][slice(*c["pieces"].tolist())]
            spline = joined(pieces, self.arrays["trim_ctrl_h"], turned=bool(c["reversed"]))
            uses.setdefault(int(c["edge"]), {})[bool(c["reversed"])] = spline, self._conic(c)
        here = TopLoc_Location()
        for number, curves in uses.items():
            edge, path = self._edge(number)
            spline, conic = next(iter(curves.values()))
            if len(curves) == 2:
                forward, backward = (flat_curve(*curves[turned]) for turned in (False, True))
                self._builder.UpdateEdge(edge, forward, backward, surface, here, 0.0)
            elif plane is None or path is None or not self._is_projection(spline, path, plane):
                self._builder.UpdateEdge(edge, flat_curve(spline, conic), surface, here, 0.0)
            if path is None:
                self._builder.Range(edge, spline.first, spline.last)

    def _conic(self, record: Any) -> Any | None:
        number = int(record["conic"])
        return self.arrays["conics"][number] if number >= 0 else None

    def _is_projection(self, spline: Spline, path: Spline, plane: Any) -> bool:
        if spline.ctrl_h.shape[0] != path.ctrl_h.shape[0] or not np.array_equal(spline.knots, path.knots):
            return False
        arm = path.ctrl_h[:, :3] - path.ctrl_h[:, 3:] * plane["location"]
        flat = np.stack([arm @ plane["x_axis"], arm @ plane["y_axis"], path.ctrl_h[:, 3]], axis=1)
        reach = max(self._size, float(np.abs(flat).max()))
        return bool(np.abs(flat - spline.ctrl_h).max() <= _SAME * reach)

    def _edge(self, number: int) -> tuple[TopoDS_Edge, Spline | None]:
        if number not in self._edges:
            self._edges[number] = self._make_edge(self.arrays["edges"][number])
        return self._edges[number]

    def _make_edge(self, e: Any) -> tuple[TopoDS_Edge, Spline | None]:
        edge, path = TopoDS_Edge(), None
        tolerance = float(e["tolerance"]) or CONFUSION
        self._builder.MakeEdge(edge)
        if e["degenerate"]:
            self._builder.UpdateEdge(edge, tolerance)
            self._builder.Degenerated(edge, True)
        else:
            pieces = self.arrays["edge_pieces"][slice(*e["pieces"].tolist())]
            path = joined(pieces, self.arrays["edge_ctrl_h"])
            self._builder.UpdateEdge(edge, space_curve(path, self._conic(e)), tolerance)
            self._builder.Range(edge, path.first, path.last)
        for vertex, orientation in zip(e["vertex"].tolist(), (_FORWARD, _REVERSED), strict=True):
            self._builder.Add(edge, self._vertex(vertex).Oriented(orientation))
        return edge, path

    def _vertex(self, number: int) -> TopoDS_Vertex:
        if number not in self._vertices:
            record = self.arrays["vertices"][number]
            vertex = TopoDS_Vertex()
            self._builder.MakeVertex(vertex, point(record["point"]), float(record["tolerance"]) or CONFUSION)
            self._vertices[number] = vertex
        return self._vertices[number]

    def _mesh_face(self, begin: int, end: int) -> TopoDS_Face:
        corners: Any = self.arrays["mesh_triangles"][begin:end]
        used, local = np.unique(corners, return_inverse=True)
        vertices: Floats = self.arrays["mesh_vertices"][used]
        mesh = Poly_Triangulation(len(vertices), len(corners), False)
        for i, (x, y, z) in enumerate(vertices.tolist(), start=1):
            mesh.SetNode(i, gp_Pnt(x, y, z))
        for i, (a, b, c) in enumerate((local.reshape(-1, 3) + 1).tolist(), start=1):
            mesh.SetTriangle(i, Poly_Triangle(a, b, c))
        face = TopoDS_Face()
        self._builder.MakeFace(face, mesh)
        return face

    def _assemble(self) -> TopoDS_Shape:
        """Faces into shells, shells into solids, as the file had them; several of these into a compound."""
        solids: dict[int, TopoDS_Solid] = {}
        tops: list[TopoDS_Shape] = []
        begin, end = self.record["shells"].tolist()
        for s in self.arrays["shells"][begin:end]:
            faces = [self.faces[i] for i in range(*s["faces"].tolist()) if i in self.faces]
            if not faces:
                continue
            if s["lone"]:
                tops.extend(faces)
                continue
            shell = TopoDS_Shell()
            self._builder.MakeShell(shell)
            for face in faces:
                self._builder.Add(shell, face)
            shell.Closed(bool(s["closed"]))
            number = int(s["solid"])
            if number < 0:
                tops.append(shell)
                continue
            if number not in solids:
                solids[number] = TopoDS_Solid()
                self._builder.MakeSolid(solids[number])
                tops.append(solids[number])
            self._builder.Add(solids[number], shell)
        return compound_of(tops)
