"""The hybrid tracer against the standard one: the same bits of face, instance, depth, uv and normal at every
pixel, whatever seeds it is given.

Views: 26 directions, every third in perspective, every fourth zoomed in so that the model leaves the picture.
Seeds: none; those of every backend, both processes, 1 and 2 threads; of meshes that are far too coarse; and
nonsense of every kind that a buffer can hold (FUZZ).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

import trimray
from trimray import _core

PLANES = ("face", "instance", "depth", "uv", "normal")
PROCESSES = ("id", "uv")
COARSE_PX = 30.0
DIRECTIONS = (*((45.0 * a, e) for e in (-45.0, 0.0, 45.0) for a in range(8)), (0.0, 90.0), (0.0, -90.0))

_WHITE = np.ones((2, 4), np.float32)
Frame = dict[str, npt.NDArray[np.generic]]


@dataclass
class Drawn:
    """What Rasterizer.draw tells."""

    id: npt.NDArray[np.uint32]
    uv: npt.NDArray[np.float32]
    targets: npt.NDArray[np.int32]  # (n, 2): instance, face

    def seeds(self, process: str) -> _core.Seeds:
        if process == "uv":
            return _core.Seeds.from_arrays(self.id, self.uv, self.targets, _middle(len(self.targets)))
        # One target a pixel, with the pixel's uv as the mean of its triangle's corners.
        seen = self.id.ravel() > 0
        number = np.where(seen, np.arange(1, self.id.size + 1), 0).reshape(self.id.shape)
        number = np.where(self.id > len(self.targets), self.id, number).astype(np.uint32)
        known = np.minimum(self.id.ravel(), len(self.targets))
        targets = np.where(seen[:, None], _padded(self.targets)[known], -1)
        none = np.empty((0, 0, 2), np.float32)
        return _core.Seeds.from_arrays(
            number,
            none,
            np.ascontiguousarray(targets, np.int32),
            np.ascontiguousarray(self.uv.reshape(-1, 2)),
        )


def _middle(count: int) -> npt.NDArray[np.float32]:
    return np.full((count, 2), 0.5, np.float32)


def _padded(targets: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    return np.concatenate([np.full((1, 2), -1, np.int32), targets])


Fuzz = Callable[[Drawn, np.random.Generator], Drawn]


def _random_ids(d: Drawn, rng: np.random.Generator) -> Drawn:
    ids = rng.integers(0, len(d.targets) + 1, d.id.shape).astype(np.uint32)
    return Drawn(ids, rng.random(d.uv.shape, np.float32), d.targets)


def _beyond_ids(d: Drawn, rng: np.random.Generator) -> Drawn:
    ids = rng.integers(0, 2**32, d.id.shape, np.uint32)
    return Drawn(np.where(rng.random(d.id.shape) < 0.5, d.id, ids).astype(np.uint32), d.uv, d.targets)


def _shifted(d: Drawn, rng: np.random.Generator) -> Drawn:
    return Drawn(np.roll(d.id, 9, (0, 1)), np.roll(d.uv, 9, (0, 1)), d.targets)


def _noisy_uv(d: Drawn, rng: np.random.Generator) -> Drawn:
    return Drawn(d.id, d.uv + rng.normal(0.0, 0.3, d.uv.shape).astype(np.float32), d.targets)


def _no_numbers(d: Drawn, rng: np.random.Generator) -> Drawn:
    odd = np.array([np.nan, np.inf, -np.inf, 1e38, -1e38, 1e-45, 7.0], np.float32)
    return Drawn(d.id, rng.choice(odd, d.uv.shape), d.targets)


def _swapped(d: Drawn, rng: np.random.Generator) -> Drawn:
    return Drawn(d.id, d.uv, np.ascontiguousarray(rng.permutation(d.targets)))


def _other_instance(d: Drawn, rng: np.random.Generator) -> Drawn:
    mixed = np.stack([rng.permutation(d.targets[:, 0]), d.targets[:, 1]], axis=1)
    return Drawn(d.id, d.uv, np.ascontiguousarray(mixed))


def _no_targets(d: Drawn, rng: np.random.Generator) -> Drawn:
    odd = np.array([-(2**31), -1, 0, 2**31 - 1], np.int64)
    targets = np.where(rng.random(d.targets.shape) < 0.5, d.targets, rng.choice(odd, d.targets.shape))
    return Drawn(d.id, d.uv, targets.astype(np.int32))


FUZZ: dict[str, Fuzz] = {
    "random ids": _random_ids,
    "ids beyond": _beyond_ids,
    "shifted": _shifted,
    "noisy uv": _noisy_uv,
    "no numbers": _no_numbers,
    "swapped": _swapped,
    "instances": _other_instance,
    "no targets": _no_targets,
}


def render(
    scene: _core.Scene, camera: _core.Camera, mode: str, seeds: _core.Seeds | None, threads: int
) -> Frame:
    return scene.render(camera, list(PLANES), 1, _WHITE, False, mode, threads, _core.Progress(), seeds)


def differing(a: Frame, b: Frame) -> dict[str, int]:
    """Pixels that are not the same to the bit, by plane."""
    counts = {}
    for name in PLANES:
        bits = np.uint64 if a[name].dtype.itemsize == 8 else np.uint32
        other = a[name].view(bits) != b[name].view(bits)
        counts[name] = int(other.reshape(*other.shape[:2], -1).any(axis=-1).sum())
    return counts


@dataclass
class Result:
    pictures: int = 0
    pixels: int = 0
    covered: int = 0
    differ: Counter[str] = field(default_factory=Counter)  # by plane
    by_seeds: Counter[str] = field(default_factory=Counter)  # pictures that differ
    first: str = ""  # that differs

    def add(self, seeds: str, view: object, frame: Frame, expected: Frame) -> None:
        counts = differing(frame, expected)
        self.pictures += 1
        self.pixels += frame["face"].size
        self.covered += int((np.asarray(expected["face"]) >= 0).sum())
        self.differ.update(counts)
        if any(counts.values()):
            self.by_seeds[seeds] += 1
            self.first = self.first or f"{seeds}, view {view}: {counts}"


def cameras(model: trimray.Model, size: int, count: int) -> Iterator[tuple[str, _core.Camera]]:
    for k in range(0, len(DIRECTIONS), max(1, len(DIRECTIONS) // count)):
        projection = "perspective" if k % 3 == 1 else "orthographic"
        zoom = 3.0 if k % 4 == 2 else 1.0
        camera = model.camera((size, size), view=DIRECTIONS[k], projection=projection, zoom=zoom)
        yield f"{DIRECTIONS[k]} {projection} x{zoom:g}", camera._core


def backends() -> list[str]:
    return [name for name, there, _ in _core.raster_backends() if there]


def check(
    model: trimray.Model,
    size: int = 192,
    views: int = len(DIRECTIONS),
    fuzz_every: int = 4,
    seed: int = 1,
) -> Result:
    """fuzz_every: of so many views one is tried with coarse meshes and with every kind of nonsense."""
    scene, store = model._scene, model._core
    rasterizers = [_core.Rasterizer(name) for name in backends()]
    levels, rng, result = _core.MeshLevels(store, math.inf), np.random.default_rng(seed), Result()
    for k, (view, camera) in enumerate(cameras(model, size, views)):
        expected = render(scene, camera, "standard", None, 0)

        def add(
            name: str,
            seeds: _core.Seeds | None,
            threads: int,
            view: str = view,
            camera: _core.Camera = camera,
            expected: Frame = expected,
        ) -> None:
            result.add(name, view, render(scene, camera, "hybrid", seeds, threads), expected)

        for threads in (1, 2):
            add("none", None, threads)
        for r in rasterizers:
            for process in PROCESSES:
                for threads in (1, 2):
                    seeds = r.seeds(levels, store, camera, process=process, threads=threads)
                    add(f"{r.name} {process}", seeds, threads)
        if k % fuzz_every or not rasterizers:
            continue
        r = rasterizers[k // fuzz_every % len(rasterizers)]
        for process in PROCESSES:
            coarse = r.seeds(_core.MeshLevels(store, math.inf), store, camera, COARSE_PX, process)
            add(f"coarse {process}", coarse, 2)
        ids, uv, instance, face = r.draw(levels, store, camera)
        drawn = Drawn(ids, uv, np.stack([instance, face], axis=1))
        if len(drawn.targets) == 0:
            continue
        for name, spoil in FUZZ.items():
            spoilt = spoil(drawn, rng)
            for process in PROCESSES:
                add(f"{name}, {process}", spoilt.seeds(process), 2)
    return result
