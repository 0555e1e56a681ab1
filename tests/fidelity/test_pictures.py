"""Pictures of two models under one camera: what counts as a differing pixel, and how it is shown."""

from __future__ import annotations

import io

import cadquery as cq
import numpy as np
import pytest
from PIL import Image

from trimray.fidelity.overlay import ONLY_A, ONLY_B, boxes
from trimray.fidelity.pictures import VIEWS, compare_pictures
from trimray.fidelity.side import read
from trimray.fidelity.tolerances import PROFILES

from . import shapes


def moved(by: float) -> cq.Workplane:
    return shapes.plate().translate((by, -by, by))


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_rounding_flips_no_pixel(profile: str) -> None:
    """Models that differ by rounding alone, seen also where outlines run through the centres of pixels."""
    tolerance = PROFILES[profile].depth * shapes.DIAGONAL
    for by in (1e-16, 1e-14, 0.4 * tolerance):
        found, pictures = compare_pictures(
            read(shapes.plate()), read(moved(by)), PROFILES[profile], size=(97, 97), images=False
        )
        assert [f.difference for f in found] == [0.0] * len(VIEWS), by
        assert {sum(p.differing.values()) for p in pictures} == {0}


def test_a_small_shift_beyond_the_tolerance_is_seen_in_every_view() -> None:
    """Depths differ all over the place."""
    found, _ = compare_pictures(
        read(shapes.plate()), read(moved(1e-3)), PROFILES["default"], size=(64, 64), images=False
    )
    assert all(not f.same and f.difference > 100 for f in found)


def test_a_flipped_face_differs_in_normals_alone() -> None:
    box = cq.Workplane().box(*shapes.BOX)
    top = next(i for i, face in enumerate(box.faces().vals()) if face.normalAt().z > 0.9)
    _, (picture,) = compare_pictures(
        read(shapes.shell_of(box)),
        read(shapes.shell_of(box, turn=top)),
        PROFILES["default"],
        views=("top",),
        size=(64, 48),
        images=False,
    )
    assert picture.differing["normal"] > 500
    assert picture.differing["depth"] == picture.differing["coverage"] == 0


def test_the_overlay_shows_what_is_only_in_one() -> None:
    """A peg stands on A's right, another on B's left."""
    plate = cq.Workplane().box(40, 30, 10)
    right = plate.union(cq.Workplane().box(4, 4, 20).translate((15, 0, 10)))
    left = plate.union(cq.Workplane().box(4, 4, 20).translate((-15, 0, 10)))
    _, (picture,) = compare_pictures(
        read(right), read(left), PROFILES["default"], views=("front",), size=(200, 150)
    )
    image = np.asarray(Image.open(io.BytesIO(picture.overlay)).convert("RGB"), np.float64) / 255.0
    assert image.shape == (150, 200, 3)
    places = []
    for color in (ONLY_A, ONLY_B):
        near = np.abs(image - color).max(axis=-1) < 0.02
        assert near.sum() > 100
        places.append(np.nonzero(near)[1].mean())
    assert places[0] > 120 and places[1] < 80
    for png in (picture.a, picture.b):
        assert Image.open(io.BytesIO(png)).size == picture.size == (200, 150)


def test_boxes_group_what_is_close() -> None:
    mask = np.zeros((100, 100), bool)
    mask[3:5, 3:6] = mask[20, 18] = mask[90, 70] = True
    assert sorted(boxes(mask)) == [(3, 3, 18, 20), (70, 90, 70, 90)]
    assert boxes(np.zeros((8, 8), bool)) == []
