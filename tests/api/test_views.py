"""What the words of render() mean, and what is said about wrong ones."""

from __future__ import annotations

import math

import pytest

from trimray import UsageError
from trimray.views import VIEWS, parse_aovs, parse_background, parse_samples, parse_size, parse_view


def test_named_views() -> None:
    assert set(VIEWS) == {"iso", "front", "back", "left", "right", "top", "bottom"}
    assert parse_view("front") == (0.0, 0.0)
    azimuth, elevation = parse_view("iso")
    assert azimuth == 45.0
    # The isometric view looks along (1, 1, 1): each axis keeps the same length.
    assert math.tan(math.radians(elevation)) == pytest.approx(1 / math.sqrt(2), abs=1e-15)


@pytest.mark.parametrize("view", ["30,-20", (30, -20), [30.0, -20.0], " 30 , -20 "])
def test_view_by_angles(view: object) -> None:
    assert parse_view(view) == (30.0, -20.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("view", ["tpo", "30", "1,2,3", "a,b", "0,91", "nan,0", (1, 2, 3), 5, None, ""])
def test_wrong_views(view: object) -> None:
    with pytest.raises(UsageError, match="view"):
        parse_view(view)  # type: ignore[arg-type]


def test_did_you_mean() -> None:
    with pytest.raises(UsageError, match="did you mean 'top'"):
        parse_view("tpo")
    with pytest.raises(UsageError, match="did you mean 'depth'"):
        parse_aovs("color,dpeth")
    with pytest.raises(UsageError, match="did you mean 'orange'"):
        parse_background("ornage")


def test_size() -> None:
    assert parse_size((640, 480)) == (640, 480)
    assert parse_size("640,480") == parse_size("640x480") == (640, 480)
    assert parse_size("256") == (256, 256)
    assert parse_size((640.0, 480.0)) == (640, 480)  # type: ignore[arg-type]


@pytest.mark.parametrize("size", ["", "0,5", "-3,4", "1,2,3", "a,b", (1.5, 2), (1,), 40000, "40000,1", None])
def test_wrong_sizes(size: object) -> None:
    with pytest.raises(UsageError, match="size"):
        parse_size(size)  # type: ignore[arg-type]


@pytest.mark.parametrize("samples", [0, -1, 1.5, "x", 5000, None])
def test_wrong_samples(samples: object) -> None:
    with pytest.raises(UsageError, match="samples"):
        parse_samples(samples)  # type: ignore[arg-type]


def test_background() -> None:
    white, red = (1.0, 1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 1.0)
    assert parse_background("white") == (white, white)
    assert (
        parse_background("#f00") == parse_background("#ff0000") == parse_background("#FF0000FF") == (red, red)
    )
    assert parse_background("transparent")[0][3] == 0.0
    assert parse_background("white,red") == parse_background(("white", "#f00")) == (white, red)
    assert parse_background((1, 0, 0)) == (red, red)
    assert parse_background((1.0, 0.0, 0.0, 0.5))[0] == (1.0, 0.0, 0.0, 0.5)
    assert parse_background("#80808080")[0] == (128 / 255,) * 4


@pytest.mark.parametrize(
    "background", ["", "#12", "#12345", "a,b,c", (1, 2), (0.0, 0.0, 2.0), "white,nope", (1,)]
)
def test_wrong_backgrounds(background: object) -> None:
    with pytest.raises(UsageError, match="background"):
        parse_background(background)  # type: ignore[arg-type]


def test_aovs_come_once_and_in_order() -> None:
    assert parse_aovs(("uv", "color", "uv")) == ("color", "uv")
    assert parse_aovs("face, depth") == ("depth", "face")
    for wrong in ((), "", "colour"):
        with pytest.raises(UsageError, match="aov"):
            parse_aovs(wrong)
