"""load, cast, count_hits and render against closed forms."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import trimray
from trimray.views import VIEWS

from .conftest import BOX, CENTER, RADIUS

GEOMETRIC = ("depth", "position", "normal", "uv", "face", "instance")


def sphere_hits(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """First hit distance of unit rays on the sphere, inf for a miss."""
    m = o - np.array(CENTER)
    b = np.einsum("ij,ij->i", m, d)
    disc = b * b - np.einsum("ij,ij->i", m, m) + RADIUS**2
    return np.where(disc > 0, -b - np.sqrt(np.maximum(disc, 0)), np.inf)


def random_rays(n: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    d = rng.normal(size=(n, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    return np.array(CENTER) + 12 * rng.uniform(-1, 1, (n, 3)) - 60 * d, d


def test_bounds_are_tight(sphere: trimray.Model, box: trimray.Model) -> None:
    expected = np.array(CENTER) + np.array([[-RADIUS], [RADIUS]])
    assert sphere.bounds.shape == (2, 3) and sphere.bounds.dtype == np.float64
    assert np.abs(sphere.bounds - expected).max() <= 1e-9
    assert np.abs(box.bounds - np.array([(0, 0, 0), BOX])).max() <= 1e-12


def test_bounds_of_turned_and_free_form_solids_are_tight() -> None:
    cq = pytest.importorskip("cadquery")
    torus = cq.Workplane(obj=cq.Solid.makeTorus(20, 5, cq.Vector(1, 2, 3), cq.Vector(1, 1, 1)))
    bounds = trimray.load(torus).bounds
    # Reach of a torus along an axis that makes the angle a with its own: R sin a + r.
    reach = 20 * math.sqrt(1 - 1 / 3) + 5
    assert np.abs(bounds - np.array([[1, 2, 3]]) - [[-reach], [reach]]).max() <= 1e-8
    points = [(0, 0), (10, 5), (20, -7), (30, 4)]
    spline = (
        cq.Workplane().spline(points).lineTo(30, -20).lineTo(0, -20).close().revolve(200, (0, -20), (1, -20))
    )
    model = trimray.load(spline)
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    judge = Bnd_Box()
    BRepBndLib.AddOptimal_s(spline.val().wrapped, judge, False, False)
    assert np.abs(model.bounds.ravel() - judge.Get()).max() <= 2e-5


def test_sphere_casts_to_the_closed_form(sphere: trimray.Model) -> None:
    o, d = random_rays(20000)
    hits = sphere.cast(o, d)
    t = sphere_hits(o, d)
    assert np.array_equal(np.isinf(t), np.isinf(hits.t))
    hit = hits.hit
    assert 5000 < hit.sum() < 20000
    assert np.abs(hits.t[hit] - t[hit]).max() <= 1e-9 * 2 * RADIUS * math.sqrt(3)
    normal = (o + t[:, None] * d)[hit] - CENTER
    assert np.abs(hits.normal[hit] - normal / RADIUS).max() <= 1e-9
    assert set(hits.face[hit]) == {0} and set(hits.instance[hit]) == {0}
    assert set(hits.face[~hit]) == {-1} and set(hits.instance[~hit]) == {-1}
    assert not hits.normal[~hit].any() and not hits.uv[~hit].any()
    u, v = hits.uv[hit].T
    sphere_point = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], 1)
    assert np.abs(sphere_point - normal / RADIUS).max() <= 1e-9


def test_reference_mode_gives_the_same(sphere: trimray.Model, box: trimray.Model) -> None:
    o, d = random_rays(60)
    for model in (sphere, box):
        fast, slow = model.cast(o, d), model.cast(o, d, mode="reference")
        assert np.array_equal(fast.face, slow.face)
        assert np.allclose(fast.t[fast.hit], slow.t[fast.hit], rtol=0, atol=1e-8)
        assert np.array_equal(model.count_hits(o, d), model.count_hits(o, d, mode="reference"))


def test_t_counts_in_lengths_of_the_direction(sphere: trimray.Model) -> None:
    o, d = random_rays(200)
    t = sphere.cast(o, d).t
    assert np.allclose(sphere.cast(o, 4.0 * d).t, t / 4, rtol=1e-12)
    hit = np.isfinite(t)
    # Beyond the first hit lies the second; before it, nothing.
    second = sphere.cast(o, 4.0 * d, tmin=t / 4 * (1 + 1e-9)).t
    assert (second[hit] > t[hit] / 4).all()
    assert np.isinf(sphere.cast(o, 4.0 * d, tmax=np.where(hit, t, 1.0) / 4 * (1 - 1e-9)).t).all()


def test_any_number_of_threads_gives_the_same_bits(sphere: trimray.Model) -> None:
    o, d = random_rays(5000)
    one, two = sphere.cast(o, d, threads=1), sphere.cast(o, d, threads=2)
    for name in ("t", "face", "instance", "uv", "normal"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()


def test_counts_are_the_crossings(box: trimray.Model) -> None:
    o = np.array([[5.0, 5, -10], [5, 5, 15], [50, 5, -10], [5, 5, 40]])
    assert box.count_hits(o, (0, 0, 1)).tolist() == [2, 1, 0, 0]
    assert box.count_hits(o, (0, 0, 1), tmax=20).tolist() == [1, 1, 0, 0]


def test_rays_broadcast_and_may_be_none(sphere: trimray.Model) -> None:
    hits = sphere.cast(CENTER, np.eye(3))
    assert np.allclose(hits.t, RADIUS)
    assert len(sphere.cast(CENTER, (0, 0, 2))) == 1
    empty = sphere.cast(np.zeros((0, 3)), np.zeros((0, 3)))
    assert empty.t.shape == (0,) and empty.normal.shape == (0, 3)
    assert sphere.count_hits(np.zeros((0, 3)), (0, 0, 1)).shape == (0,)


@pytest.mark.parametrize(
    ("o", "d", "match"),
    [
        (np.zeros((2, 3)), np.ones((3, 3)), "do not fit"),
        (np.zeros((2, 2)), np.ones((2, 3)), "origins: shape"),
        (np.zeros((2, 3)), np.ones(4), "directions: shape"),
        ("abc", np.ones(3), "not an array of numbers"),
        (np.zeros(3, complex), np.ones(3), "not an array of numbers"),
        (np.zeros((2, 3)), [[1, 1, 1], [0, 0, 0]], "ray 1 has a direction of length 0"),
        ((0, 0, math.nan), (0, 0, 1), "ray 0 is not finite"),
        ((0, 0, 0), (0, 0, math.inf), "ray 0 is not finite"),
    ],
)
def test_wrong_rays(sphere: trimray.Model, o: object, d: object, match: str) -> None:
    for function in (sphere.cast, sphere.count_hits):
        with pytest.raises(trimray.UsageError, match=match):
            function(o, d)  # type: ignore[operator]


def test_wrong_words(sphere: trimray.Model) -> None:
    with pytest.raises(trimray.UsageError, match="did you mean 'reference'"):
        sphere.cast(CENTER, (0, 0, 1), mode="refrence")  # type: ignore[arg-type]
    for word in ("view", "projection", "up", "mode", "background", "aovs", "size", "samples"):
        with pytest.raises(trimray.UsageError):
            sphere.render((8, 8), **{word: "nonsense"}) if word != "size" else sphere.render("nonsense")


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
@pytest.mark.parametrize("view", [*VIEWS, (17, 33)])
def test_aovs_of_a_sphere_are_its_closed_form(sphere: trimray.Model, view: object, projection: str) -> None:
    frame = sphere.render((48, 40), view=view, projection=projection, aovs=GEOMETRIC)  # type: ignore[arg-type]
    camera = sphere._camera((48, 40), view, projection, "z")  # type: ignore[arg-type]
    o, d = camera.rays()
    t = sphere_hits(o, d).reshape(40, 48)
    hit = np.isfinite(t)
    assert np.array_equal(np.isfinite(frame["depth"]), hit)
    assert np.abs(frame["depth"][hit] - t[hit]).max() <= 1e-8
    p = (o + np.where(hit, t, 0).ravel()[:, None] * d).reshape(40, 48, 3)
    assert np.abs(frame["position"][hit] - p[hit]).max() <= 1e-8
    assert np.abs(frame["normal"][hit] - (p[hit] - CENTER) / RADIUS).max() <= 1e-8
    assert np.array_equal(frame["face"], np.where(hit, 0, -1))
    assert np.array_equal(frame["instance"], np.where(hit, 0, -1))
    for name in ("position", "normal", "uv"):
        assert not frame[name][~hit].any()
    # Fitted: the disc fills the picture up to the margin of 4 %, and no more.
    rows = np.flatnonzero(hit.any(1))
    assert rows[0] in (1, 2) and rows[-1] in (37, 38)


def test_planes_have_the_promised_types(box: trimray.Model) -> None:
    frame = box.render((20, 10), aovs=trimray.AOVS)
    assert frame.aovs == trimray.AOVS
    types = {"color": ("f4", 4), "depth": ("f8", 0), "position": ("f8", 3), "normal": ("f8", 3)}
    types |= {"uv": ("f8", 2), "face": ("i4", 0), "instance": ("i4", 0)}
    for name, (dtype, channels) in types.items():
        assert frame[name].dtype == np.dtype(dtype)
        assert frame[name].shape == ((10, 20, channels) if channels else (10, 20))


def test_named_views_show_the_side_they_name(box: trimray.Model) -> None:
    for view, axis, sign in [
        ("front", 1, -1),
        ("back", 1, 1),
        ("left", 0, -1),
        ("right", 0, 1),
        ("top", 2, 1),
        ("bottom", 2, -1),
    ]:
        normal = box.render((9, 9), view=view, aovs=("normal",))["normal"][4, 4]
        assert normal.tolist() == [sign * float(axis == i) for i in range(3)]
    # Up follows the axis asked for.
    assert box.render((9, 9), view="front", up="y", aovs=("normal",))["normal"][4, 4].tolist() == [0, 0, 1]
    assert box.render((9, 9), view="top", up="-x", aovs=("normal",))["normal"][4, 4].tolist() == [-1, 0, 0]
    # The silhouette of the front view is the box's own: 10 wide, 30 high.
    seen = box.render((60, 60), view="front", aovs=("face",))["face"] >= 0
    rows, columns = np.flatnonzero(seen.any(1)), np.flatnonzero(seen.any(0))
    assert (len(rows) - 1) / 30 <= (len(columns) + 1) / 10 and (len(columns) - 1) / 10 <= (len(rows) + 1) / 30


def test_three_visible_sides_of_a_box_differ(box: trimray.Model) -> None:
    frame = box.render((64, 64), aovs=("color", "face"), samples=1)
    sides = [frame["color"][frame["face"] == n][:, 0] for n in np.unique(frame["face"]) if n >= 0]
    assert len(sides) == 3
    levels = sorted(float(np.median(s)) for s in sides)
    assert (
        levels[0] > 0.2 and levels[1] - levels[0] > 0.05 and levels[2] - levels[1] > 0.05 and levels[2] < 0.97
    )


def test_pictures_are_the_same_for_any_number_of_threads(sphere: trimray.Model) -> None:
    frames = [sphere.render((70, 50), aovs=trimray.AOVS, threads=n) for n in (1, 2, 5)]
    for frame in frames[1:]:
        for name in trimray.AOVS:
            assert frame[name].tobytes() == frames[0][name].tobytes()


def test_samples_filter_the_colour_and_nothing_else(sphere: trimray.Model) -> None:
    one, many = (sphere.render((40, 40), samples=n, aovs=trimray.AOVS) for n in (1, 9))
    for name in GEOMETRIC:
        assert one[name].tobytes() == many[name].tobytes()
    rim = np.isfinite(one["depth"]) ^ np.roll(np.isfinite(one["depth"]), 1, 1)
    assert np.abs(one["color"] - many["color"])[rim].max() > 0.05
    inside = np.isfinite(one["depth"]) & (np.abs(one["color"] - many["color"]).max(-1) < 0.05)
    assert inside.sum() > 800


def test_coverage_of_the_alpha_channel_is_the_area_of_the_disc(sphere: trimray.Model) -> None:
    frame = sphere.render((100, 100), samples=64, background="transparent")
    alpha = frame["color"][..., 3].astype(float)
    radius_px = 0.5 * 100 - 0.04 * 100
    assert alpha.sum() == pytest.approx(math.pi * radius_px**2, rel=1e-2)
    assert alpha[0, 0] == 0.0 and alpha[50, 50] == 1.0
    assert not frame["color"][0, 0].any()


def test_backgrounds(sphere: trimray.Model) -> None:
    corner = sphere.render((20, 20), background="#336699")["color"][0, 0]
    assert np.allclose(corner, [0x33 / 255, 0x66 / 255, 0x99 / 255, 1], atol=1e-6)
    column = sphere.render((20, 20), background="white,black")["color"][:, 0, 0]
    assert (np.diff(column) < 0).all() and column[0] > 0.95 and column[-1] < 0.05


def test_colours_names_and_instances(assembly: trimray.Model) -> None:
    assert len(assembly.instances) == 2
    low, high = sorted(assembly.instances, key=lambda i: float(i.placement[2, 3]))
    assert high.placement[2, 3] == 100.0 and high.placement.shape == (3, 4)
    assert low.color == (1.0, 0.0, 0.0, 1.0)
    assert high.color is not None and high.color[1] > high.color[0] == 0.0
    assert len(assembly.faces) in (6, 12)
    assert {f.kind for f in assembly.faces} == {"plane"}
    assert {f.status for f in assembly.faces} == {"ok"}
    assert [f.number for f in assembly.faces] == list(range(len(assembly.faces)))
    assert np.allclose(assembly.bounds, [(0, 0, 0), (10, 20, 130)], atol=1e-12)
    frame = assembly.render((40, 80), view="front", aovs=("color", "instance"), samples=1)
    for instance, channel in ((low, 0), (high, 1)):
        pixels = frame["color"][frame["instance"] == instance.number][:, :3]
        assert len(pixels) > 50
        assert (pixels.argmax(1) == channel).all()


def test_faces_are_a_sequence(box: trimray.Model) -> None:
    assert len(box.faces) == 6
    assert box.faces[-1] == box.faces[5] and len(box.faces[1:3]) == 2
    with pytest.raises(IndexError):
        _ = box.faces[6]
    assert box.unit == "mm"


def test_report(box_file: Path) -> None:
    model = trimray.load(box_file, cache=False)
    report = model.report
    assert (report.faces, report.drawn, report.not_drawn, report.complete) == (6, 6, (), True)
    assert report.faces_in_file == 6
    assert report.problems() == []
    assert report.peak_memory > 50e6
    assert {"store"} < set(report.seconds) and all(s >= 0 for s in report.seconds.values())
    model.render((8, 8))
    assert {"hierarchy", "trace"} <= set(model.report.seconds)
    assert model.report.as_dict()["complete"] is True


def _linear(encoded: np.ndarray) -> np.ndarray:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def test_translucent_faces_show_what_is_behind() -> None:
    cq = pytest.importorskip("cadquery")

    def picture(alpha: float, block: bool) -> np.ndarray:
        """A pane of one face before a red block; the pane alone sets the frame."""
        a = cq.Assembly()
        pane = cq.Workplane(obj=cq.Face.makePlane(20, 20, (0, -20, 0), (0, -1, 0)))
        a.add(pane, color=cq.Color(0.2, 0.8, 0.4, alpha))
        if block:
            a.add(cq.Workplane().box(10, 10, 10), color=cq.Color(1, 0, 0))
        return trimray.load(a).render((41, 41), view="front", samples=1, background="black")["color"]

    pane, both = picture(1.0, False), picture(0.25, True)
    red = trimray.load(cq.Assembly().add(cq.Workplane().box(10, 10, 10), color=cq.Color(1, 0, 0)))
    block = red.render((41, 41), view="front", samples=1)["color"]
    mixed = 0.25 * _linear(pane[20, 20].astype(float)) + 0.75 * _linear(block[20, 20].astype(float))
    assert np.abs(_linear(both[20, 20].astype(float)) - mixed)[:3].max() < 5e-3
    assert (
        np.abs(_linear(both[20, 3].astype(float)) - 0.25 * _linear(pane[20, 3].astype(float)))[:3].max()
        < 5e-3
    )


def test_an_absurd_face_does_not_blank_the_model() -> None:
    """Bounds and picture are of the rest."""
    cq = pytest.importorskip("cadquery")
    block = cq.Workplane().box(10, 20, 30, centered=False).val()
    for huge in (cq.Face.makePlane(1e13, 1e13), cq.Face.makePlane(1, 1).translate(cq.Vector(0, 0, 1e14))):
        model = trimray.load(cq.Compound.makeCompound([block, huge]))
        assert model.bounds == pytest.approx(np.array([(0, 0, 0), BOX]), abs=1e-6)
        face = model.render((48, 48), samples=1, aovs=("face",))["face"]
        assert set(range(6)) & set(face.ravel().tolist()) and np.isin(face, range(6)).mean() > 0.3


def test_time_limit_of_a_render(sphere: trimray.Model) -> None:
    with pytest.raises(trimray.TimeLimitError, match="took longer"):
        sphere.render((2000, 2000), samples=64, time_limit=0.1)


def test_progress_is_told(box_file: Path) -> None:
    stages: list[tuple[str, float | None]] = []
    model = trimray.load(box_file, cache=False, progress=lambda stage, share: stages.append((stage, share)))
    assert "store" in {stage for stage, _ in stages}
    stages.clear()
    model.render((400, 400), samples=16, progress=lambda stage, share: stages.append((stage, share)))
    assert stages[-1] == ("trace", 1.0)
    assert all(share is None or 0 <= share <= 1 for _, share in stages)
