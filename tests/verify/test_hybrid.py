"""A small version of `scripts/verify hybrid`: its pictures equal the standard ones, bit by bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trimray

from . import hybrid

SAMPLES = Path(__file__).resolve().parents[2] / "samples"


@pytest.mark.parametrize(
    "name", ["teapot.step", "assembly.step", "cornell_box.step", "torture/pole_cut.step"]
)
def test_hybrid_pictures_equal_standard_ones_whatever_the_seeds(name: str) -> None:
    result = hybrid.check(trimray.load(SAMPLES / name), size=80, views=4, fuzz_every=2)
    kinds = 1 + 2 * len(hybrid.backends())
    assert result.pictures >= 2 * 4 * kinds
    assert result.covered > 0.1 * result.pixels
    assert result.first == ""
    assert sum(result.differ.values()) == 0


def test_differing_counts_pixels_and_sees_the_last_bit() -> None:
    model = trimray.load(SAMPLES / "bracket.step")
    camera = model.camera((40, 30))._core
    frame = hybrid.render(model._scene, camera, "standard", None, 1)
    other = {name: plane.copy() for name, plane in frame.items()}
    assert hybrid.differing(frame, other) == dict.fromkeys(hybrid.PLANES, 0)
    y, x = np.argwhere(np.asarray(frame["face"]) >= 0)[0]
    other["uv"][y, x, 1] = np.nextafter(other["uv"][y, x, 1], np.inf)
    other["depth"][y, x] = np.nextafter(other["depth"][y, x], 0.0)
    other["depth"][0, 0] = -np.inf
    other["face"][y, x] += 1
    assert hybrid.differing(frame, other) == {"face": 1, "instance": 0, "depth": 2, "uv": 1, "normal": 0}


@pytest.mark.parametrize("kind", hybrid.FUZZ)
def test_every_kind_of_nonsense_spoils_the_seeds(kind: str) -> None:
    rng = np.random.default_rng(3)
    ids = rng.integers(0, 4, (12, 16)).astype(np.uint32)
    drawn = hybrid.Drawn(
        ids, rng.random((12, 16, 2), np.float32), np.array([[0, 0], [1, 2], [2, 1]], np.int32)
    )
    before = drawn.seeds("uv"), drawn.seeds("id")
    spoilt = hybrid.FUZZ[kind](drawn, rng)
    assert not (
        np.array_equal(spoilt.id, drawn.id)
        and np.array_equal(spoilt.uv, drawn.uv)
        and np.array_equal(spoilt.targets, drawn.targets)
    )
    for process, seeds in zip(("uv", "id"), before, strict=True):
        assert seeds.targets > 0
        assert spoilt.seeds(process).targets > 0
