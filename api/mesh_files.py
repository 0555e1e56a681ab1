"""Meshes to the bytes of files. The only module that knows trimesh, which writes glb."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from .importer.errors import OutputError, UsageError
from .tri_mesh import Part, Placed, TriMesh

# What has no colour takes this one beside faces that have: the neutral grey of the pictures, sRGB-encoded.
_GREY = (0.72, 0.74, 0.77, 1.0)
_MM = 1e-3  # glTF counts in metres
# glTF's Y is up, the model's Z.
_Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def encode(mesh: TriMesh, format: str) -> bytes:
    """format: of MESH_FORMATS. Equal meshes give equal bytes. Raises UsageError, OutputError."""
    if format == "glb":
        return _encode_glb(mesh)
    if format == "stl" and len(mesh.triangles) > np.iinfo(np.uint32).max:
        raise UsageError("stl: too many triangles")
    colors = np.empty((0, 4), np.float32)
    if format in ("ply", "off"):
        colors = _triangle_colors(mesh)
    return _core.write_mesh_file(format, mesh.vertices, mesh.triangles, np.empty((0, 3)), colors)


def _triangle_colors(mesh: TriMesh) -> npt.NDArray[np.float32]:
    """(m, 4), or (0, 4) when no face has a colour."""
    store = mesh._model._core
    own, inherited = store.face_colors(), store.instance_colors()
    colors = own[mesh.face]
    colors = np.where(colors[:, :1] >= 0.0, colors, inherited[mesh.instance])
    given = colors[:, 0] >= 0.0
    if not given.any():
        return np.empty((0, 4), np.float32)
    colors[~given] = _GREY
    return np.ascontiguousarray(colors, np.float32)


def _encode_glb(mesh: TriMesh) -> bytes:
    try:
        import trimesh
    except ImportError as error:
        raise OutputError(f"glb: needs the package trimesh: {error}") from None
    from trimesh.exchange.gltf import export_glb

    model = mesh._model
    scene = trimesh.Scene(base_frame="world")
    scene.graph.update(frame_to="model", frame_from="world", matrix=_Y_UP)
    taken = {"world", "model"}
    materials = _Materials()
    own, inherited = model._core.face_colors(), model._core.instance_colors()
    pieces: dict[tuple[int, bytes], list[str]] = {}
    for meshed in mesh._pieces:
        number, placed, part = meshed.instance, meshed.placed, meshed.part
        instance = model.instances[number]
        # Places that colour their part alike share its geometry.
        key = (id(part), inherited[number].tobytes())
        if key not in pieces:
            colors = np.where(own[part.face][:, :1] >= 0.0, own[part.face], inherited[number])
            name = f"{instance.part or 'part'} {len(pieces)}"
            pieces[key] = _add_geometry(scene, name, part, part.normals(model._core), colors, materials)
        node = instance.name or instance.part or "instance"
        if node in taken:
            node = f"{node} {number}"
        taken.add(node)
        matrix, geometry = _matrix(placed), pieces[key]
        if len(geometry) == 1:
            scene.graph.update(frame_to=node, frame_from="model", matrix=matrix, geometry=geometry[0])
            continue
        scene.graph.update(frame_to=node, frame_from="model", matrix=matrix)
        for piece in geometry:
            scene.graph.update(frame_to=f"{node}/{piece}", frame_from=node, geometry=piece)
            taken.add(f"{node}/{piece}")
    data = export_glb(scene, include_normals=True, tree_postprocessor=lambda tree: _finish(tree, materials))
    assert isinstance(data, bytes)
    return data


class _Materials:
    """glTF materials by colour, in the order of their first use."""

    def __init__(self) -> None:
        self.colors: dict[str, tuple[float, ...]] = {}

    def name_of(self, color: tuple[float, ...]) -> str:
        rgba = color if color[0] >= 0.0 else _GREY
        name = "#" + "".join(f"{round(255 * x):02x}" for x in rgba)
        self.colors.setdefault(name, rgba)
        return name


def _add_geometry(
    scene: Any,
    name: str,
    part: Part,
    normals: npt.NDArray[np.float64],
    colors: npt.NDArray[np.float32],
    materials: _Materials,
) -> list[str]:
    """One geometry a colour. A vertex stands once for each normal that meets there."""
    import trimesh
    from trimesh.visual.material import PBRMaterial

    names = []
    distinct, which = np.unique(colors, axis=0, return_inverse=True)
    for index, color in enumerate(distinct):
        chosen = which.ravel() == index
        corners = np.concatenate(
            [part.vertices[part.triangles[chosen]].reshape(-1, 3) * _MM, normals[chosen].reshape(-1, 3)],
            axis=1,
        ).astype(np.float32)
        rows, inverse = np.unique(corners, axis=0, return_inverse=True)
        material = PBRMaterial(name=materials.name_of(tuple(float(x) for x in color)))
        geometry = trimesh.Trimesh(
            vertices=rows[:, :3],
            faces=inverse.reshape(-1, 3),
            vertex_normals=rows[:, 3:],
            visual=trimesh.visual.TextureVisuals(material=material),
            process=False,
            validate=False,
        )
        piece = f"{name}.{index}" if len(distinct) > 1 else name
        scene.geometry[piece] = geometry
        names.append(piece)
    return names


def _matrix(placed: Placed) -> npt.NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = placed.linear, placed.shift * _MM
    return matrix


def _finish(tree: dict[str, Any], materials: _Materials) -> None:
    """Exact colours, which trimesh would round to 8 bits of linear light."""
    for material in tree.get("materials", ()):
        red, green, blue, alpha = materials.colors[material["name"]]
        linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in (red, green, blue)]
        material["pbrMetallicRoughness"] = {
            "baseColorFactor": [*(round(x, 6) for x in linear), round(alpha, 6)],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.6,
        }
        material["doubleSided"] = True
        if alpha < 1.0:
            material["alphaMode"] = "BLEND"
    tree["asset"] = {"version": "2.0", "generator": "trimray"}
