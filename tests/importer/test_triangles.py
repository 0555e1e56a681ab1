"""Files of triangles: STL, OBJ, PLY, OFF."""

import gzip
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

import trimray
from trimray.importer import EmptyError, InputError, MeshModel, TimeLimitError, read_model
from trimray.importer.formats import sniff

CORNERS = [(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]

OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "".join(
    f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES
)
OFF = f"OFF\n{len(CORNERS)} {len(FACES)} 0\n" + "".join(
    " ".join(map(str, row)) + "\n" for row in [*CORNERS, *[(3, *face) for face in FACES]]
)
PLY = (
    f"ply\nformat ascii 1.0\nelement vertex {len(CORNERS)}\n"
    "property float x\nproperty float y\nproperty float z\n"
    f"element face {len(FACES)}\nproperty list uchar int vertex_indices\nend_header\n" + OFF.split("\n", 2)[2]
)
TEXT_STL = (
    "solid tetra\n"
    + "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*CORNERS[i]) for i in face)
        + "endloop\nendfacet\n"
        for face in FACES
    )
    + "endsolid tetra\n"
)
BINARY_STL = (
    bytes(80)
    + struct.pack("<I", len(FACES))
    + b"".join(struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in CORNERS[i]), 0) for face in FACES)
)
FILES = {
    "text.stl": TEXT_STL.encode(),
    "binary.stl": BINARY_STL,
    "tetra.obj": OBJ.encode(),
    "tetra.off": OFF.encode(),
    "tetra.ply": PLY.encode(),
}


def write(folder: Path, name: str, data: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


@pytest.mark.parametrize("name", sorted(FILES))
def test_every_format_is_read_by_name_and_by_content(tmp_path, name):
    for given in (name, "model.dat"):
        mesh = read_model(write(tmp_path, given, FILES[name]))
        assert isinstance(mesh, MeshModel)
        assert mesh.triangles.shape == (4, 3)
        corners = mesh.vertices[mesh.triangles]
        assert np.array_equal(corners, np.array([[CORNERS[i] for i in face] for face in FACES], float))
        assert mesh.source["format"] == name.rpartition(".")[2]
        assert mesh.report["faces"] == 1


@pytest.mark.parametrize("name", sorted(FILES))
def test_bytes_and_archives_are_read_too(tmp_path, name):
    data = FILES[name]
    assert read_model(data).triangles.shape == (4, 3)
    packed = write(tmp_path, f"{name}.gz", gzip.compress(data))
    assert read_model(packed).source["archive"] == "gzip"
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("readme.txt", "hello")
        archive.writestr(f"inner/{name}", data)
    assert read_model(tmp_path / "a.zip").source["member"] == f"inner/{name}"


def test_the_child_does_not_load_opencascade_for_triangles(tmp_path, monkeypatch):
    broken = tmp_path / "OCP"
    broken.mkdir()
    (broken / "__init__.py").write_text("raise RuntimeError('OCP was imported')")
    import os

    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    assert read_model(write(tmp_path, "t.off", OFF)).triangles.shape == (4, 3)


def test_other_texts_are_no_obj():
    assert sniff(b"v 1 2 3\nv 1 2 3\n", "x") == "obj"
    assert sniff(b"hello world\nv 1 2 3\n", "x") == "unknown"
    assert sniff(b"f 1 2 3\ng a\n", "x") == "unknown"
    assert sniff(b"solid ground\n", "x") == "unknown"
    assert sniff(b"OFFICE\n1 2 3\n", "x") == "unknown"


def test_groups_become_named_faces_and_have_their_materials_color(tmp_path):
    write(tmp_path, "m.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 0.2\n")
    obj = "mtllib m.mtl\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    obj += "g lid\nusemtl red\nf 1 3 2\ng rest\nusemtl blue\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    path = write(tmp_path, "m.obj", obj)
    model = trimray.load(path)
    assert [face.name for face in model.faces] == ["lid red", "rest blue"]
    assert model.faces[0].color == (1.0, 0.0, 0.0, 1.0)
    assert model.faces[1].color == pytest.approx((0.0, 0.0, 0.2, 1.0))
    # The library is not the file's own: such a model is not kept.
    write(tmp_path, "m.mtl", "newmtl red\nKd 0 1 0\n")
    again = trimray.load(path)
    assert again.faces[0].color == (0.0, 1.0, 0.0, 1.0)
    assert again.faces[1].color is None


def test_a_material_library_of_another_folder_is_not_read(tmp_path):
    (tmp_path / "a").mkdir()
    write(tmp_path, "m.mtl", "newmtl red\nKd 1 0 0\n")
    obj = write(tmp_path / "a", "m.obj", "mtllib ../m.mtl\nusemtl red\n" + OBJ)
    assert trimray.load(obj).faces[0].color is None


@pytest.mark.parametrize(
    ("name", "data", "reason"),
    [
        ("cut.stl", BINARY_STL[:-7], "cut off: 4 triangles declared, 3 there"),
        ("cut_text.stl", TEXT_STL[: TEXT_STL.rindex("endsolid")], "cut off"),
        ("nan.obj", OBJ.replace("v 10", "v nan"), "line 2: 'nan' is not a coordinate"),
        ("index.obj", OBJ + "f 1 2 5\n", "corner 5 of 4 vertices does not exist"),
        ("huge.off", OFF.replace("4 4 0", "4 4000000000 0"), "cut off, or counts are wrong"),
        ("header.ply", PLY[:38], "cut off within the header"),
        ("huge.ply", PLY.replace("vertex 4", "vertex 4000000000"), "cut off"),
        ("far.off", OFF.replace("10", "1e300"), "too large"),
    ],
)
def test_damaged_files_are_refused_in_one_line(tmp_path, name, data, reason):
    path = write(tmp_path, name, data)
    with pytest.raises(InputError) as caught:
        trimray.load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert reason in str(caught.value)
    assert caught.value.exit_code == 3


def test_files_without_triangles_are_empty(tmp_path):
    with pytest.raises(EmptyError, match="no triangles"):
        read_model(write(tmp_path, "points.obj", "v 0 0 0\nv 1 1 1\n"))
    with pytest.raises(EmptyError, match="no triangles"):
        read_model(write(tmp_path, "no.stl", "solid nothing\nendsolid nothing\n"))


def test_faces_without_area_are_counted(tmp_path):
    mesh = read_model(write(tmp_path, "flat.off", OFF.replace("4 4 0", "4 5 0") + "3 0 0 1\n"))
    assert mesh.triangles.shape == (4, 3)
    assert any("1 of 5 faces have no area" in issue["reason"] for issue in mesh.report["issues"])


def test_no_triangle_is_lost_where_a_mesh_is_no_manifold(tmp_path):
    more = "f 1 2 3\nf 1 2 3\nf 2 1 3\n" + OBJ.replace("v", "# ")
    assert read_model(write(tmp_path, "book.obj", OBJ + more)).triangles.shape[0] == 11


def test_the_time_limit_holds_for_triangles(tmp_path):
    path = write(tmp_path, "t.off", OFF)
    with pytest.raises(TimeLimitError):
        read_model(path, time_limit=1e-3)
