"""Seeds decide about time, never about the picture."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import trimray
from trimray import _core

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
BACKENDS = [name for name, there, _ in _core.raster_backends() if there]
SIZE = (75, 64)

needs_a_backend = pytest.mark.skipif(not BACKENDS, reason="no raster backend on this machine")


@pytest.fixture(scope="module", params=["teapot.igs", "bracket.step", "stand.stl"])
def model(request: pytest.FixtureRequest) -> trimray.Model:
    return trimray.load(SAMPLES / request.param)


def picture(model: trimray.Model, camera: trimray.Camera, seeds: _core.Seeds | None, n: int = 1) -> bytes:
    planes = model._scene.render(
        camera._core, list(trimray.AOVS), n, np.ones((2, 4), np.float32), False, "hybrid", 2,
        _core.Progress(), seeds,
    )  # fmt: skip
    return b"".join(planes[name].tobytes() for name in trimray.AOVS)


@pytest.mark.parametrize("process", ["uv", "id"])
def test_wrong_seeds_change_nothing(model: trimray.Model, process: str) -> None:
    rng = np.random.default_rng(3)
    for projection in ("orthographic", "perspective"):
        camera = model.camera(SIZE, projection=projection)
        want = model.render(view=camera, mode="standard", samples=1, aovs=trimray.AOVS)
        expected = b"".join(want[name].tobytes() for name in trimray.AOVS)
        faces = len(model.faces)
        targets = np.stack([np.zeros(50, np.int32), rng.integers(-2, faces + 3, 50, np.int32)], axis=-1)
        targets[::7, 0] = rng.integers(-3, 5, len(targets[::7]))
        target_uv = rng.choice([0.5, 0.1, -3.0, 1e30, math.nan, math.inf], (50, 2)).astype(np.float32)
        for ids in (rng.integers(0, 51, SIZE[::-1]), rng.integers(0, 2**32, SIZE[::-1])):
            uv = rng.random((*SIZE[::-1], 2), np.float32)
            uv[rng.random(SIZE[::-1]) < 0.2] = math.nan
            seeds = _core.Seeds.from_arrays(
                ids.astype(np.uint32),
                uv if process == "uv" else np.zeros((0, 0, 2), np.float32),
                np.ascontiguousarray(targets, np.int32),
                target_uv,
            )
            assert picture(model, camera, seeds) == expected


def test_seeds_of_another_size_are_refused(model: trimray.Model) -> None:
    camera = model.camera(SIZE)
    seeds = _core.Seeds.from_arrays(
        np.ones((3, 5), np.uint32),
        np.zeros((3, 5, 2), np.float32),
        np.zeros((1, 2), np.int32),
        np.zeros((1, 2), np.float32),
    )
    with pytest.raises(_core.CoreError, match="another size"):
        picture(model, camera, seeds)


@pytest.mark.parametrize("process", ["uv", "id"])
@pytest.mark.parametrize("backend", ["osmesa", "egl", "embree"])
def test_every_backend_gives_the_same_picture(model: trimray.Model, backend: str, process: str) -> None:
    if backend not in BACKENDS:
        pytest.skip(f"{backend} does not work here")
    for samples, threads in ((1, 1), (4, 2)):
        want, got = (
            model.render(
                SIZE, samples=samples, threads=threads, aovs=trimray.AOVS, seeds=seeds, seed_process=process
            )
            for seeds in ("none", backend)
        )
        assert all(want[name].tobytes() == got[name].tobytes() for name in want)
    assert "seeds" in model.report.seconds


@needs_a_backend
@pytest.mark.parametrize("mode", ["hybrid", "standard"])
def test_planes_of_seeds(sphere: trimray.Model, mode: str) -> None:
    aovs = ("uv", "face", "seed_id", "seed_uv")
    frame = sphere.render((80, 60), samples=1, mode=mode, aovs=aovs)  # type: ignore[arg-type]
    ids, uv, covered = frame["seed_id"], frame["seed_uv"], frame["face"] >= 0
    assert frame.aovs == aovs
    assert (ids.dtype, ids.shape) == (np.uint32, (60, 80)) and (uv.dtype, uv.shape) == (
        np.float32,
        (60, 80, 2),
    )
    assert ((ids > 0) == covered).mean() > 0.96  # its mesh is coarse
    assert len(np.unique(ids[ids > 0])) == 1  # one surface
    assert (uv[ids == 0] == 0).all() and uv.min() >= 0 and uv.max() <= 1
    # A sphere's v is its latitude.
    both = covered & (ids > 0)
    latitude = (frame["uv"][both][:, 1] + math.pi / 2) / math.pi
    assert np.abs(uv[both][:, 1] - latitude).max() < 0.1
    by_triangle = sphere.render((80, 60), samples=1, aovs=("seed_id",), seed_process="id")["seed_id"]
    assert len(np.unique(by_triangle)) > 20


def test_without_a_backend_pictures_are_made_and_a_warning_says_so(
    sphere: trimray.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(name: str) -> None:
        raise _core.CoreError("no such\nlibrary")

    monkeypatch.setattr(_core, "Rasterizer", fails)
    monkeypatch.setattr(sphere, "_seeder", type(sphere._seeder)(), raising=False)
    want = sphere.render(SIZE, seeds="none")["color"]
    with pytest.warns(RuntimeWarning, match=r"no raster pass \(osmesa\): no such library; rendering without"):
        got = sphere.render(SIZE, seeds="osmesa")["color"]
    assert (want == got).all()
    with pytest.raises(trimray.UsageError, match="no such library"):
        sphere.render(SIZE, seeds="egl", aovs="seed_id")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sphere.render(SIZE)
        sphere.render(SIZE, seeds="osmesa", mode="standard")  # nobody would look at them


def test_wrong_words(sphere: trimray.Model) -> None:
    with pytest.raises(trimray.UsageError, match="did you mean 'osmesa'"):
        sphere.render(SIZE, seeds="mesa")
    with pytest.raises(trimray.UsageError, match="seed_process: unknown 'uw'"):
        sphere.render(SIZE, seed_process="uw")
    with pytest.raises(trimray.UsageError, match="seed_uv: there are no seeds"):
        sphere.render(SIZE, seeds="none", aovs="seed_uv")
