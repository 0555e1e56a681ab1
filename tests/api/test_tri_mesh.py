"""Meshes of models: Model.tessellate, its files, and merged models."""

from __future__ import annotations

import io
import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trimray

ASSEMBLY = "assembly.step"
BRACKET = "bracket.step"


@pytest.fixture(scope="module")
def assembly() -> trimray.Model:
    return trimray.load(Path(__file__).parents[2] / "samples" / ASSEMBLY)


@pytest.fixture(scope="module")
def mesh(assembly: trimray.Model) -> trimray.TriMesh:
    return assembly.tessellate()


def test_the_default_is_a_share_of_the_size(assembly: trimray.Model, mesh: trimray.TriMesh) -> None:
    low, high = assembly.bounds
    assert mesh.asked == pytest.approx(1e-3 * float(np.linalg.norm(high - low)))
    assert mesh.deviation.max() <= mesh.asked
    assert mesh.issues == ()


def test_every_instance_is_closed_and_in_its_place(assembly: trimray.Model, mesh: trimray.TriMesh) -> None:
    assert mesh.vertices.dtype == np.float64 and mesh.triangles.dtype == np.int32
    assert mesh.corner_uv.shape == (len(mesh.triangles), 3, 2)
    assert mesh.check().watertight and mesh.check().degenerate_triangles == 0
    for instance in assembly.instances:
        own = mesh.instance == instance.number
        assert set(mesh.face[own].tolist()) == set(instance.faces)
        check = trimray._core.check_mesh(mesh.vertices, np.ascontiguousarray(mesh.triangles[own]))
        assert check["volume"] > 0.0, "a mirrored part is turned round"
    assert np.abs(mesh.vertices.min(axis=0) - assembly.bounds[0]).max() <= mesh.asked + 1e-9
    assert np.abs(mesh.vertices.max(axis=0) - assembly.bounds[1]).max() <= mesh.asked + 1e-9


def test_a_finer_mesh_comes_nearer(assembly: trimray.Model, mesh: trimray.TriMesh) -> None:
    fine = assembly.tessellate(0.002)
    assert fine.asked == 0.002
    assert len(fine.triangles) > len(mesh.triangles)
    assert np.array_equal(fine.triangles, assembly.tessellate("0.002mm", threads=1).triangles)
    assert len(assembly.tessellate(angle=math.radians(5)).triangles) > len(mesh.triangles)


def test_normals_are_the_surfaces_own(mesh: trimray.TriMesh) -> None:
    normals = mesh.normals()
    corners = mesh.vertices[mesh.triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.allclose(np.linalg.norm(normals, axis=-1), 1.0)
    assert (normals * flat[:, None]).sum(axis=-1).min() > 0.8


@pytest.mark.parametrize("deviation", [0, -1, math.inf, math.nan, "1px", "a bit", "", "mm"])
def test_wrong_deviations_are_usage_errors(assembly: trimray.Model, deviation: Any) -> None:
    with pytest.raises(trimray.UsageError, match="deviation"):
        assembly.tessellate(deviation)
    with pytest.raises(trimray.UsageError, match="angle"):
        assembly.tessellate(angle=0.0)


@pytest.mark.parametrize("format", ["stl", "ply", "obj", "off"])
def test_files_read_back_as_the_same_mesh(mesh: trimray.TriMesh, format: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{format}"
    mesh.save(path)
    again = io.BytesIO()
    mesh.save(again, format=format)
    assert again.getvalue() == path.read_bytes()
    back = trimray.load(path).tessellate()
    assert len(back.triangles) == len(mesh.triangles)
    assert back.check().watertight
    assert back.check().volume == pytest.approx(mesh.check().volume, rel=1e-5)


def test_colors_go_into_ply(assembly: trimray.Model, mesh: trimray.TriMesh, tmp_path: Path) -> None:
    mesh.save(tmp_path / "a.ply")
    wanted = {face.color for face in assembly.faces} - {None}
    found = {face.color for face in trimray.load(tmp_path / "a.ply").faces}
    for color in wanted:
        assert any(np.allclose(color, other, atol=1 / 255) for other in found if other), color


def _gltf(data: bytes) -> dict[str, Any]:
    assert data[:4] == b"glTF"
    (length,) = struct.unpack_from("<I", data, 12)
    tree = json.loads(data[20 : 20 + length])
    assert isinstance(tree, dict)
    return tree


def test_glb_keeps_names_places_and_colors(assembly: trimray.Model, mesh: trimray.TriMesh) -> None:
    trimesh = pytest.importorskip("trimesh")
    data = io.BytesIO()
    mesh.save(data, format="glb")
    again = io.BytesIO()
    assembly.tessellate(threads=1).save(again, format="glb")
    assert again.getvalue() == data.getvalue()
    tree = _gltf(data.getvalue())
    names = [node["name"] for node in tree["nodes"]]
    for instance in assembly.instances:
        assert any(name.startswith(instance.name or instance.part) for name in names)
    assert len([node for node in tree["nodes"] if "mesh" in node]) >= len(assembly.instances)
    assert len(tree["meshes"]) < len(assembly.instances), "places of one part share its mesh"
    assert all("NORMAL" in p["attributes"] for m in tree["meshes"] for p in m["primitives"])
    data.seek(0)
    scene = trimesh.load(data, file_type="glb")
    (x0, y0, z0), (x1, y1, z1) = assembly.bounds / 1000.0  # metres, Y up
    assert np.allclose(scene.bounds, [[x0, z0, -y1], [x1, z1, -y0]], atol=mesh.asked / 1000.0)


def test_merged_models_keep_what_each_was(assembly: trimray.Model, samples_dir: Path, tmp_path: Path) -> None:
    bracket = trimray.load(samples_dir / BRACKET)
    assembly.tessellate(0.1).save(tmp_path / "triangles.off")
    triangles = trimray.load(tmp_path / "triangles.off")
    models = [assembly, bracket, triangles]
    together = trimray.merge(models)
    faces = [face for model in models for face in model.faces]
    assert [(f.kind, f.name, f.part, f.color) for f in together.faces] == [
        (f.kind, f.name, f.part, f.color) for f in faces
    ]
    assert [i.path for i in together.instances] == [i.path for model in models for i in model.instances]
    assert together.report.complete
    assert any("triangles.off" in issue.entity for issue in together.report.issues)
    low = np.min([model.bounds[0] for model in models], axis=0)
    assert np.array_equal(together.bounds[0], low)
    meshes = [model.tessellate(0.05).check().volume for model in models]
    assert together.tessellate(0.05).check().volume == pytest.approx(sum(meshes))


def test_the_nearest_of_merged_models_is_seen(samples_dir: Path) -> None:
    bracket, ball = trimray.load(samples_dir / BRACKET), trimray.load(samples_dir / "torture" / "sphere.step")
    frames = [m.render((64, 64), view="top", aovs=("instance",)) for m in (trimray.merge([bracket, ball]),)]
    assert {0, 1} <= set(np.unique(frames[0]["instance"]).tolist())


def test_nothing_cannot_be_merged() -> None:
    with pytest.raises(trimray.UsageError, match="no models"):
        trimray.merge([])
