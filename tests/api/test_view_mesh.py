"""Cameras, and meshes made for them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import trimray

from .conftest import CENTER, RADIUS

SAMPLES = Path(__file__).resolve().parents[2] / "samples"


def test_a_camera_is_the_one_of_the_picture(sphere: trimray.Model) -> None:
    for projection in ("orthographic", "perspective"):
        camera = sphere.camera((64, 48), view="top", projection=projection)
        assert (camera.size, camera.perspective) == ((64, 48), projection == "perspective")
        named = sphere.render((64, 48), view="top", projection=projection, aovs="depth", samples=1)
        given = sphere.render(view=camera, aovs="depth", samples=1)
        assert given["depth"].tobytes() == named["depth"].tobytes()
        origins, directions = camera.rays()
        hits = sphere.cast(origins.reshape(-1, 3), directions.reshape(-1, 3))
        np.testing.assert_allclose(hits.t.reshape(48, 64), given["depth"], rtol=1e-12)


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
def test_zoom_enlarges_about_the_centre(box: trimray.Model, projection: str) -> None:
    whole, near = (box.camera((91, 91), projection=projection, zoom=zoom) for zoom in (1.0, 3.0))
    assert near.pixel == pytest.approx(whole.pixel / 3.0)
    small, large = (box.render(view=c, aovs="depth", samples=1)["depth"] for c in (whole, near))
    # Three pixels of the one are one of the other, and the middle ones share their centre.
    np.testing.assert_allclose(large[0::3, 0::3], small[30:61, 30:61], rtol=1e-12)


@pytest.mark.parametrize("zoom", [0, -1.0, math.inf, math.nan, "near", None])
def test_wrong_zooms(sphere: trimray.Model, zoom: object) -> None:
    with pytest.raises(trimray.UsageError, match="zoom"):
        sphere.camera(zoom=zoom)  # type: ignore[arg-type]


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
@pytest.mark.parametrize("zoom", [1.0, 12.0])
def test_the_mesh_looks_like_the_sphere(
    sphere: trimray.Model, tmp_path: Path, projection: str, zoom: float
) -> None:
    camera = sphere.camera((200, 160), projection=projection, zoom=zoom)
    mesh = sphere.tessellate("0.25px", view=camera)
    assert mesh.asked_px == 0.25 and math.isnan(mesh.asked)
    mesh.save(tmp_path / "mesh.ply")
    seen = trimray.load(tmp_path / "mesh.ply").render(view=camera, samples=1, aovs=("face", "position"))
    exact = sphere.render(view=camera, samples=1, aovs=("face", "depth"))
    hit, true_hit = seen["face"] >= 0, exact["face"] >= 0
    # By a fraction of a pixel the silhouette is off, and only it.
    assert (hit & ~true_hit).sum() == 0
    assert (true_hit & ~hit).sum() <= 0.25 * 2.0 * math.pi * 80.0
    gap = RADIUS - np.linalg.norm(seen["position"][hit & true_hit] - CENTER, axis=-1)
    depth = exact["depth"][hit & true_hit] if projection == "perspective" else 1.0
    assert (np.abs(gap) <= 0.25 * camera.pixel * depth * 1.05 + 1e-5).all()
    if zoom == 1.0:
        assert mesh.check().watertight
    else:
        assert hit.all()
        whole = sphere.tessellate(0.25 * camera.pixel * float(np.min(depth)))
        assert len(mesh.triangles) < 0.3 * len(whole.triangles)


def _distances(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Of points (n, 3) from the nearest of the triangles (m, 3, 3); brute force."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    found = []
    for p in points:
        inside = np.ones(len(a), bool)
        nearest = np.inf
        for s, e in ((a, b), (b, c), (c, a)):
            inside &= (np.cross(e - s, p - s) * normal).sum(axis=1) >= 0.0
            t = ((p - s) * (e - s)).sum(axis=1) / ((e - s) ** 2).sum(axis=1)
            foot = s + np.clip(t, 0.0, 1.0)[:, None] * (e - s)
            nearest = min(nearest, float(np.linalg.norm(p - foot, axis=1).min()))
        height = np.abs(((p - a) * normal).sum(axis=1))[inside] / area[inside]
        found.append(min(nearest, float(height.min(initial=np.inf))))
    return np.array(found)


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
@pytest.mark.parametrize("sample", ["bracket.step", "teapot.step", "assembly.step"])
def test_what_is_seen_is_near_the_mesh(sample: str, projection: str) -> None:
    model = trimray.load(SAMPLES / sample, cache=False)
    random = np.random.default_rng(3)
    for view, zoom in (("iso", 1.0), ((200, -30), 5.0)):
        camera = model.camera((256, 256), view=view, projection=projection, zoom=zoom)
        mesh = model.tessellate("0.3px", view=camera)
        assert not mesh.issues
        seen = model.render(view=camera, aovs=("face", "position", "depth"), samples=1)
        hits = np.argwhere(seen["face"] >= 0)
        at = tuple(hits[random.integers(0, len(hits), 50)].T)
        pixel = camera.pixel * (seen["depth"][at] if projection == "perspective" else 1.0)
        assert (_distances(seen["position"][at], mesh.vertices[mesh.triangles]) <= 0.3 * pixel).all()


def test_meshes_are_kept_while_they_are_fine_enough(sphere: trimray.Model) -> None:
    first = sphere.tessellate("0.3px", view=(10, 20))
    turned = sphere.tessellate("0.3px", view=(15, 20))
    np.testing.assert_array_equal(first.triangles, turned.triangles)
    finer = sphere.tessellate("0.1px", view=(15, 20))
    assert len(finer.triangles) > len(first.triangles)


def test_parts_beyond_the_picture_have_no_triangles(assembly: trimray.Model) -> None:
    camera = assembly.camera((100, 100), view="front", zoom=8.0)
    # Between the boxes, at z from 30 to 100, there is nothing to see.
    assert (assembly.render(view=camera, aovs="face", samples=1)["face"] < 0).all()
    assert len(assembly.tessellate(view=camera).triangles) == 0
    whole = assembly.tessellate(view="front")
    assert whole.asked_px == 0.3 and set(whole.instance.tolist()) == {0, 1}
    assert whole.check().watertight
    assert whole.normals().shape == (len(whole.triangles), 3, 3)


def test_what_pixels_need(sphere: trimray.Model) -> None:
    with pytest.raises(trimray.UsageError, match="need a view"):
        sphere.tessellate("0.3px")
    for deviation in (0.3, "0.3mm", "1%"):
        with pytest.raises(trimray.UsageError, match="in pixels"):
            sphere.tessellate(deviation, view="iso")
    with pytest.raises(trimray.UsageError, match="angle"):
        sphere.tessellate(view="iso", angle=-1.0)
    with pytest.raises(trimray.UsageError, match="view"):
        sphere.tessellate(view="ios")


def test_an_angle_makes_a_mesh_for_a_view_finer(sphere: trimray.Model) -> None:
    coarse = sphere.tessellate("2px", view="iso")
    assert len(sphere.tessellate("2px", view="iso", angle=0.05).triangles) > 4 * len(coarse.triangles)


def test_any_number_of_threads_gives_the_same_mesh(box_file: Path) -> None:
    meshes = []
    for threads in (1, 4):
        model = trimray.load(box_file)
        camera = model.camera(zoom=4.0, projection="perspective")
        meshes.append(model.tessellate("0.2px", view=camera, threads=threads))
    one, many = meshes
    assert one.vertices.tobytes() == many.vertices.tobytes()
    assert one.triangles.tobytes() == many.triangles.tobytes()
