"""Distances and samples: known ones, OpenCascade's, and those of real models from themselves."""

from __future__ import annotations

from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.gp import gp_Pnt

import trimray

from .conftest import BOX, CENTER, RADIUS


def around(model: trimray.Model, count: int, seed: int = 0, widen: float = 0.5) -> np.ndarray:
    """Random points in the model's bounds, widened."""
    low, high = model.bounds
    size = high - low
    return np.random.default_rng(seed).uniform(low - widen * size, high + widen * size, (count, 3))


def diagonal(model: trimray.Model) -> float:
    return float(np.linalg.norm(np.diff(model.bounds, axis=0)))


def test_sphere(sphere: trimray.Model) -> None:
    points = around(sphere, 2000)
    found = sphere.distance(points)
    centre = np.asarray(CENTER)
    expected = np.abs(np.linalg.norm(points - centre, axis=1) - RADIUS)
    assert np.abs(found.distance - expected).max() <= 1e-12 * diagonal(sphere)
    assert np.abs(np.linalg.norm(found.point - centre, axis=1) - RADIUS).max() < 1e-12 * diagonal(sphere)
    assert (found.gap == 0).all() and (found.instance == 0).all()


def test_box_inside_beside_and_at_corners(box: trimray.Model) -> None:
    size = np.asarray(BOX)
    points = around(box, 4000)
    found = box.distance(points)
    outside = np.maximum(np.maximum(-points, points - size), 0)
    inner = np.minimum(points, size - points).min(axis=1)
    expected = np.where(inner > 0, inner, np.linalg.norm(outside, axis=1))
    assert np.abs(found.distance - expected).max() <= 1e-12 * diagonal(box)
    on_edge = (outside > 0).sum(axis=1) > 1
    assert (found.on_edge == on_edge).all() and on_edge.any() and not on_edge.all()
    assert (found.band[~found.on_edge] == 0).all() and (found.band[found.on_edge] > 0).all()


def test_edges_alone(box: trimray.Model) -> None:
    middle = np.asarray(BOX) / 2
    found = box.distance(middle, edges=True)
    assert found.distance[0] == pytest.approx(np.hypot(BOX[0], BOX[1]) / 2, rel=1e-14)
    assert found.on_edge.all() and len(found) == 1


def test_instances(assembly: trimray.Model) -> None:
    found = assembly.distance([[5, 10, -3], [5, 10, 97], [5, 10, 133]])
    np.testing.assert_allclose(found.distance, [3, 3, 3], atol=1e-12)
    assert found.instance.tolist() == [0, 1, 1]
    samples = assembly.sample(5, seed=2)
    assert len(samples) == 5 * 2 * 6
    assert assembly.distance(samples.point).distance.max() < 1e-12 * diagonal(assembly)


def test_same_for_any_number_of_threads(box: trimray.Model) -> None:
    points = around(box, 3000, seed=3)
    one, many = box.distance(points, threads=1), box.distance(points, threads=3)
    for name in ("distance", "point", "face", "edge", "uv"):
        assert getattr(one, name).tobytes() == getattr(many, name).tobytes()
    assert (
        box.sample(9, seed=4, threads=1).point.tobytes() == box.sample(9, seed=4, threads=3).point.tobytes()
    )
    assert box.sample(9, seed=4).point.tobytes() != box.sample(9, seed=5).point.tobytes()


def test_what_cannot_be_asked(box: trimray.Model) -> None:
    with pytest.raises(trimray.UsageError, match="points: shape"):
        box.distance([1.0, 2.0])
    with pytest.raises(trimray.UsageError, match="number 1 is not finite"):
        box.distance([[0, 0, 0], [0, np.nan, 0]])
    with pytest.raises(trimray.UsageError, match="points"):
        box.distance("here")  # type: ignore[arg-type]
    with pytest.raises(trimray.UsageError, match="count"):
        box.sample(-1)
    with pytest.raises(trimray.UsageError, match="seed"):
        box.sample_edges(1, seed=-1)
    assert len(box.distance(np.empty((0, 3)))) == 0
    assert len(box.sample(0)) == 0


def shapes() -> dict[str, cq.Workplane]:
    plate = cq.Workplane().box(20, 30, 4).faces(">Z").workplane().hole(8).edges("|Z").fillet(3)
    spline = (
        cq.Workplane("XZ")
        .spline([(4, 0), (7, 3), (3, 7), (5, 10)])
        .lineTo(0, 10)
        .lineTo(0, 0)
        .close()
        .revolve(270, (0, 0), (0, 1))
    )
    loft = cq.Workplane().rect(10, 6).workplane(offset=8).circle(3).loft()
    cone = cq.Workplane(obj=cq.Solid.makeCone(5, 2, 8)).cut(cq.Workplane().box(3, 20, 4))
    return {"plate": plate, "revolved spline": spline, "loft": loft, "cut cone": cone}


@pytest.mark.parametrize("name", sorted(shapes()))
def test_agrees_with_opencascade(name: str) -> None:
    """OpenCascade may miss the nearest solution, so it may be farther, never nearer."""
    shape = shapes()[name].val()
    model = trimray.load(shapes()[name])
    points = around(model, 150, seed=1)
    found = model.distance(points)
    theirs = np.empty(len(points))
    for i, p in enumerate(points):
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex()
        theirs[i] = min(
            BRepExtrema_DistShapeShape(vertex, face.wrapped).Value() for face in shape.Faces()
        )  # of the faces: inside of a solid its own distance is 0
    difference = theirs - found.distance
    assert difference.min() >= -2e-7, f"OpenCascade is nearer by {-difference.min()}"
    assert (np.abs(difference) <= 2e-7).mean() >= 0.95


def test_samples_lie_on_their_models(models_dir: Path) -> None:
    """Samples of faces and edges are at no distance, on small models of every kind."""
    names = [
        "yuechen-li-dev+Aetheris/nist_ctc_01_asme1_ap242-e1.stp",
        "mikedh+trimesh/base_interface_AP214.STEP",
        "stepcode+stepcode/as1-oc-214.stp",
        "vrsys+gpucast/teapot.igs",
        "dodgy-step-files/Gs037.stp",
        "gumyr+build123d/M6-1x12-countersunk-screw.step",
    ]
    for name in names:
        model = trimray.load(models_dir / name)
        samples = model.sample(6, seed=1)
        found = model.distance(samples.point)
        assert found.distance.max() <= 1e-9 * diagonal(model), name
        drawn = [f.number for f in model.faces if f.status == "ok"]
        assert set(samples.face.tolist()) <= set(drawn), name
        assert len(np.unique(samples.face)) >= 0.98 * len(drawn), name
        edges = model.sample_edges(3)
        assert model.distance(edges.point, edges=True).distance.max() <= 1e-9 * diagonal(model), name
