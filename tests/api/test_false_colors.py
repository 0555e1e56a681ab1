"""Planes as pictures: what they tell apart."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from trimray.false_colors import false_colors


def at(aov: str, *values: object) -> list[list[int]]:
    """Colours of pixels with these values."""
    plane = np.array([values], np.uint32 if aov == "seed_id" else None)  # type: ignore[arg-type]
    picture = false_colors(aov, plane)
    assert picture.shape == (1, len(values), 3) and picture.dtype == np.uint8
    return picture[0].tolist()  # type: ignore[no-any-return]


@pytest.mark.parametrize("aov", ["face", "instance", "seed_id"])
def test_numbers_have_colours_of_their_own_and_nothing_is_black(aov: str) -> None:
    nothing = 0 if aov == "seed_id" else -1
    colors = np.array(at(aov, *range(nothing, nothing + 4001)))
    assert colors[0].tolist() == [0, 0, 0]
    assert (colors[1:].max(-1) > 140).all()
    near = [np.abs(colors[1 + i :] - colors[1 : len(colors) - i]).max(-1).min() for i in (1, 2, 3, 5)]
    assert min(near) > 20
    assert len({tuple(c) for c in colors[1:200].tolist()}) == 199


def test_parameters_are_red_and_green() -> None:
    assert at("seed_uv", (0.0, 0.0), (1.0, 0.0), (0.5, 1.0), (2.0, -1.0)) == [
        [0, 0, 0],
        [255, 0, 0],
        [128, 255, 0],
        [255, 0, 0],
    ]
    assert at("uv", (10.0, 5.0), (0.0, 0.0), (20.0, 3.0), (15.0, 4.0)) == [
        [0, 255, 0],
        [0, 0, 0],
        [255, 0, 0],
        [128, 128, 0],
    ]


def test_the_near_is_bright() -> None:
    assert at("depth", 5.0, np.inf, 7.0, 6.0) == [[255] * 3, [0] * 3, [30] * 3, [143] * 3]
    assert at("depth", 5.0, 5.0) == [[255] * 3] * 2
    assert at("depth", np.inf) == [[0] * 3]


def test_normals_and_positions() -> None:
    assert at("normal", (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)) == [
        [128, 128, 255],
        [0, 128, 128],
        [0, 0, 0],
    ]
    assert at("position", (1.0, 9.0, 4.0), (3.0, 7.0, 4.0)) == [[0, 255, 0], [255, 0, 0]]


def test_times_have_one_scale_for_all_pictures() -> None:
    times: list[float] = [0.0, 30.0, 300.0, 3000.0, 30_000.0, 1e9]
    alone = [at("time", t)[0] for t in times]
    assert alone == at("time", *times)
    light: npt.NDArray[np.int64] = np.array(alone).sum(-1)
    assert light[0] == light[1] == 0 and light[-1] == light[-2] == 3 * 255
    assert (np.diff(light[1:-1]) > 0).all()
