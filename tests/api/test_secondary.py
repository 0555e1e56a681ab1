"""Shadows, ambient occlusion and reflections against closed forms."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import numpy.typing as npt
import pytest

import trimray

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
ALL: dict[str, Any] = {"shadows": True, "ambient_occlusion": 5, "reflections": 2}


def linear(encoded: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    x = encoded.astype(np.float64)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def test_convex_solids_neither_shade_nor_occlude_themselves() -> None:
    """Not in a single sample: no acne at grazing light, none along edges."""
    ball_far_away = cq.Workplane().sphere(0.5).translate((4000.0, -3000.0, 2000.0))
    parts = (
        cq.Workplane().sphere(10.0),
        cq.Workplane().box(10, 20, 30),
        cq.Workplane().circle(4.0).extrude(20.0),
        cq.Workplane().circle(4.0).workplane(offset=9.0).circle(1.0).loft(),
        cq.Workplane().box(30, 20, 10).edges("|Z").fillet(3.0),
        ball_far_away,
    )
    for part in parts:
        model = trimray.load(part)
        for view in ("iso", "front", (20.0, 70.0), (250.0, -10.0)):
            for projection in ("orthographic", "perspective"):
                size = (150, 120)
                plain = model.render(size, view=view, projection=projection)["color"]
                shaded = model.render(
                    size, view=view, projection=projection, shadows=True, ambient_occlusion=3
                )["color"]
                assert plain.tobytes() == shaded.tobytes(), (view, projection)


def test_a_box_on_a_plate_throws_the_shadow_of_its_closed_form() -> None:
    plate = cq.Workplane().box(100, 100, 4, centered=(True, True, False)).translate((0, 0, -4))
    lower, upper = np.array([-10.0, -6.0, 0.0]), np.array([8.0, 9.0, 15.0])
    block = cq.Workplane().box(*(upper - lower), centered=False).translate(tuple(lower))
    model = trimray.load(plate.union(block))
    camera = model.camera((240, 240), view="top")
    plain, shaded = (
        model.render(view=camera, samples=1, shadows=s, aovs=("color", "position", "normal"))
        for s in (False, True)
    )
    position = plain["position"]
    floor = (plain["normal"][..., 2] > 0.99) & (np.abs(position[..., 2]) < 1e-6)
    right, up, forward = camera._core.right, camera._core.up, camera._core.forward
    expected = np.zeros(floor.shape, bool)
    for lamp in (-0.75 * right + 0.70 * up - 0.55 * forward, 0.85 * right + 0.15 * up - 0.45 * forward):
        ends = np.stack([(corner - position) / lamp for corner in (lower, upper)])
        first, last = ends.min(0).max(-1), ends.max(0).min(-1)
        expected |= (first <= last) & (last > 0)
    dark = (plain["color"] != shaded["color"]).any(-1)
    assert floor.sum() > 30_000 and 2000 < (expected & floor).sum() < 20_000
    assert (dark == expected)[floor].all()
    assert (linear(shaded["color"]) <= linear(plain["color"]) + 1e-7).all()


def test_translucent_parts_let_light_through() -> None:
    def picture(alpha: float) -> npt.NDArray[Any]:
        both = cq.Assembly()
        both.add(cq.Workplane().box(40, 40, 2), color=cq.Color(1, 1, 1, 1))
        both.add(
            cq.Workplane().box(9, 9, 1), loc=cq.Location(cq.Vector(0, 0, 9)), color=cq.Color(1, 0, 0, alpha)
        )
        model = trimray.load(both)
        frame = model.render((90, 90), view="top", samples=1, shadows=True, aovs=("color", "position"))
        return linear(frame["color"][..., :3])[np.abs(frame["position"][..., 2] - 1.0) < 1e-6].sum(-1)  # type: ignore[no-any-return]

    solid, half, glass = (np.sort(picture(a)) for a in (1.0, 0.5, 0.02))
    assert solid[0] < half[0] < glass[0]
    # The part has two sides: a quarter of the light comes through both.
    lit, dark = solid[-1], solid[0]
    assert abs((half[0] - dark) / (lit - dark) - 0.25) < 0.02


def test_occlusion_beside_a_wall_is_its_integral() -> None:
    wall = cq.Workplane().box(10, 200, 100, centered=(False, True, False)).translate((-10, 0, 0))
    floor = cq.Workplane().box(100, 200, 10, centered=(False, True, False)).translate((0, 0, -10))
    model = trimray.load(floor.union(wall))
    reach = 60.0
    diagonal = float(np.linalg.norm(np.diff(model.bounds, axis=0)))
    common: dict[str, Any] = {"view": "top", "samples": 1, "aovs": ("color", "position", "face")}
    plain = model.render((60, 60), **common)
    shaded = model.render((60, 60), ambient_occlusion=512, occlusion_distance=reach / diagonal, **common)
    position = plain["position"]
    there = (
        (plain["face"] >= 0)
        & (np.abs(position[..., 2]) < 1e-6)
        & (np.abs(position[..., 1]) < 38)
        & (position[..., 0] < 60)
    )
    ambient = (linear(shaded["color"][..., 0]) / linear(plain["color"][..., 0]))[there]
    # Directions (theta from the normal, phi from the wall) meet the wall at x / (sin theta cos phi).
    theta = (np.arange(400) + 0.5) / 400 * math.pi / 2
    phi = ((np.arange(400) + 0.5) / 400 - 0.5) * math.pi
    sine, cosine = np.sin(theta)[:, None], np.cos(phi)[None, :]
    weight = sine * np.cos(theta)[:, None] * (math.pi / 2 / 400) * (math.pi / 400) / math.pi
    x, index = np.unique(position[there][:, 0].round(6), return_inverse=True)
    expected = np.array([1 - (weight * np.clip(1 - at / (sine * cosine) / reach, 0, None)).sum() for at in x])
    assert expected.min() < 0.65 and expected.max() > 0.999
    assert np.abs(ambient - expected[index]).max() < 0.02


def test_a_flat_mirror_shows_the_background_at_its_reflectance() -> None:
    model = trimray.load(cq.Workplane().box(10, 10, 1))
    common: dict[str, Any] = {"view": "top", "samples": 1, "background": "#408020"}
    plain, shiny = (
        linear(model.render((20, 20), reflections=n, **common)["color"][10, 10, :3]) for n in (0, 1)
    )
    back = linear(np.array([0x40, 0x80, 0x20]) / 255.0)
    assert np.abs(shiny - (0.84 * plain + 0.16 * back)).max() < 1e-6


def test_a_mirror_shows_what_stands_before_it() -> None:
    both = cq.Assembly()
    both.add(cq.Workplane().box(40, 40, 2), color=cq.Color(0, 0, 0, 1))
    both.add(cq.Workplane().box(8, 8, 8), loc=cq.Location(cq.Vector(0, 0, 15)), color=cq.Color(1, 0, 0, 1))
    model = trimray.load(both)
    frame = model.render(
        (120, 120), view=(0, 35), samples=1, reflections=1, background="white", aovs=("color", "position")
    )
    plate = np.abs(frame["position"][..., 2] - 1.0) < 1e-6
    color = linear(frame["color"][..., :3])
    red = plate & (color[..., 0] > 1.5 * color[..., 1]) & (color[..., 0] > 0.05)
    assert 40 < red.sum() < plate.sum() / 2
    # The ray turned over at the plate meets the box.
    camera = model.camera((120, 120), view=(0, 35))._core
    up = camera.forward * [1, 1, -1]
    with np.errstate(divide="ignore"):
        ends = np.stack([(c - frame["position"][red]) / up for c in ([-4, -4, 11], [4, 4, 19])])
    assert (ends.min(0).max(-1) <= ends.max(0).min(-1) + 1e-6).all()


@pytest.mark.parametrize("name", ["teapot.igs", "bracket.step", "stand.stl"])
def test_modes_and_threads_agree_to_the_byte(name: str) -> None:
    model = trimray.load(SAMPLES / name)
    frames = [
        model.render((45, 40), mode=mode, threads=threads, samples=2, **ALL)["color"].tobytes()
        for mode, threads in (("standard", 1), ("standard", 2), ("hybrid", 2))
    ]
    assert len(set(frames)) == 1
    assert frames[0] != model.render((45, 40), samples=2)["color"].tobytes()


def test_wrong_numbers(sphere: trimray.Model) -> None:
    for wrong in ({"ambient_occlusion": -1}, {"reflections": 17}, {"occlusion_distance": 0.0}):
        with pytest.raises(trimray.UsageError, match=next(iter(wrong))):
            sphere.render((4, 4), **wrong)  # type: ignore[arg-type]
