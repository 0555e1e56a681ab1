"""Model.turntable: one framing, the right views, the pictures of render."""

from __future__ import annotations

import io
import threading
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest

import trimray
from trimray import _core
from trimray.animation import encode_animation
from trimray.formats import numbered, sequence_format_of
from trimray.turntable import cameras

SAMPLES = Path(__file__).resolve().parents[2] / "samples"


@pytest.fixture(scope="module")
def bracket() -> trimray.Model:
    return trimray.load(SAMPLES / "bracket.step")


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
@pytest.mark.parametrize("up", ["z", "-y"])
def test_every_frame_has_the_same_framing_and_nothing_is_cut_off(
    bracket: trimray.Model, projection: str, up: str
) -> None:
    views = cameras(bracket, 7, (90, 70), (10.0, 30.0), projection, up)
    middle = bracket.bounds.mean(axis=0)
    assert len({c.pixel for c in views}) == 1
    away = [np.linalg.norm(c.eye - middle) for c in views]
    assert np.ptp(away) < 1e-9 * away[0]
    touched = []
    for camera in views:
        frame = bracket.render(view=trimray.Camera(camera), samples=1, aovs="face")["face"] >= 0
        rows, columns = np.nonzero(frame)
        touched.append([columns.min(), 89 - columns.max(), rows.min(), 69 - rows.max()])
    assert (np.array(touched) >= 2).all()  # the margin is 4 % of 70 px
    assert np.array(touched).min() <= 4


def test_frames_are_the_pictures_of_their_cameras(bracket: trimray.Model) -> None:
    views = cameras(bracket, 5, (50, 40), (30.0, 20.0), "orthographic", "z")
    words: dict[str, Any] = {"aovs": ("color", "face"), "samples": 2, "shadows": True, "background": "blue"}
    frames = list(bracket.turntable(5, (50, 40), view=(30.0, 20.0), **words))
    assert len(frames) == 5
    for camera, frame in zip(views, frames, strict=True):
        want = bracket.render(view=trimray.Camera(camera), **words)
        assert all(want[name].tobytes() == frame[name].tobytes() for name in want)
    assert len({frame["color"].tobytes() for frame in frames}) == 5


def test_the_camera_goes_round_counter_clockwise(box: trimray.Model) -> None:
    a, b, c, d = (v.forward.round(12).tolist() for v in cameras(box, 4, (9, 9), "front", "orthographic", "z"))
    assert (a, b, c, d) == ([0, 1, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0])


def test_a_turned_part_stands_still() -> None:
    model = trimray.load(
        cq.Workplane().circle(3.0).extrude(8.0).faces(">Z").workplane().circle(5.0).extrude(1.0)
    )
    depths = [f["depth"] for f in model.turntable(3, (40, 40), aovs="depth", samples=1)]
    for other in depths[1:]:
        both = np.isfinite(depths[0]) & np.isfinite(other)
        assert both.sum() > 300 and (np.isfinite(depths[0]) != np.isfinite(other)).sum() < 4
        assert np.abs(depths[0][both] - other[both]).max() < 1e-9


def test_seeds_of_the_next_frame_are_made_while_one_is_traced(
    bracket: trimray.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not any(there for _, there, _ in _core.raster_backends()):
        pytest.skip("no raster backend on this machine")
    backend = next(name for name, there, _ in _core.raster_backends() if there)
    made: list[str] = []
    kind = type(bracket._seeder)
    make = kind.make

    def watched(self: Any, *arguments: Any) -> Any:
        made.append(threading.current_thread().name)
        return make(self, *arguments)

    monkeypatch.setattr(kind, "make", watched)
    want = [f["color"].tobytes() for f in bracket.turntable(4, (40, 30))]
    assert made == []
    frames = bracket.turntable(4, (40, 30), seeds=backend)
    assert next(frames)["color"].tobytes() == want[0]
    assert len(made) >= 1 and all(name.startswith("trimray-seeds") for name in made)
    assert [f["color"].tobytes() for f in frames] == want[1:]
    assert len(made) == 4


def test_frames_can_be_left(sphere: trimray.Model) -> None:
    before = threading.active_count()
    frames = sphere.turntable(1000, (20, 20))
    next(frames)
    frames.close()  # type: ignore[attr-defined]
    assert threading.active_count() == before


def test_time_is_limited_and_progress_told(sphere: trimray.Model) -> None:
    with pytest.raises(trimray.TimeLimitError):
        list(sphere.turntable(5000, (200, 200), time_limit=0.3))
    told: list[tuple[str, float | None]] = []
    list(sphere.turntable(3, (20, 20), progress=lambda stage, part: told.append((stage, part))))
    assert {stage for stage, _ in told} == {"turn"}
    parts = [part for _, part in told]
    assert parts == sorted(parts) and parts[-1] >= 2 / 3  # type: ignore[type-var,operator]


def test_wrong_arguments_are_told_at_once(sphere: trimray.Model) -> None:
    for wrong in ({"frames": 0}, {"frames": "many"}, {"up": "w"}, {"view": "frnot"}, {"mode": "fast"}):
        with pytest.raises(trimray.UsageError, match=next(iter(wrong))):
            sphere.turntable(**wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("format", ["webp", "gif"])
@pytest.mark.parametrize("fps", [12.0, 30.0])
def test_moving_pictures_hold_every_frame(bracket: trimray.Model, format: str, fps: float) -> None:
    from PIL import Image

    frames = list(bracket.turntable(6, (40, 30), samples=1))
    data = encode_animation(frames, format, fps)
    assert data == encode_animation(iter(frames), format, fps)
    image = Image.open(io.BytesIO(data))
    assert image.n_frames == 6 and image.size == (40, 30) and image.info["loop"] == 0  # type: ignore[attr-defined]
    total = 0.0
    for k, frame in enumerate(frames):
        image.seek(k)
        image.load()
        total += image.info["duration"]
        got = np.asarray(image.convert("RGB")).astype(float) / 255
        error = np.abs(got - frame["color"][..., :3])
        assert error.max() < (0.003 if format == "webp" else 0.05)
    assert abs(total - 6000 / fps) <= (5 if format == "gif" else 1)


def test_transparency(bracket: trimray.Model) -> None:
    from PIL import Image

    frames = list(bracket.turntable(2, (30, 30), background="transparent"))
    image = Image.open(io.BytesIO(encode_animation(frames, "webp", 10)))
    assert np.asarray(image.convert("RGBA"))[0, 0, 3] == 0
    with pytest.raises(trimray.UsageError, match="soft transparency"):
        encode_animation(frames, "gif", 10)


def test_paths_with_numbers() -> None:
    path = numbered("a/b%04d.png")
    assert path is not None and path(7) == "a/b0007.png"
    path = numbered("%d.exr")
    assert path is not None and path(12) == "12.exr"
    assert numbered("a%.png") is None
    with pytest.raises(trimray.UsageError, match="one number only"):
        numbered("%d-%d.png")
    assert sequence_format_of("a.gif") == "gif" and sequence_format_of("%d.tif") == "tiff"
    with pytest.raises(trimray.UsageError, match="holds no frames"):
        sequence_format_of("a.png")
