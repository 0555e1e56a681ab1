"""What the raster pass sees, beside what the tracer sees."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import numpy as np
import pytest

import trimray
from trimray import _core

BACKENDS = [name for name, there, _ in _core.raster_backends() if there]


def test_backends_tell_their_version_or_why_not() -> None:
    known = _core.raster_backends()
    assert [name for name, _, _ in known] == ["osmesa", "egl", "embree"]
    assert all(text for _, _, text in known)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("process", ["uv", "id"])
def test_seeds_name_what_is_seen(backend: str, process: str, assembly: trimray.Model) -> None:
    camera = assembly.camera((120, 90), view="30,20")
    frame = assembly.render(view=camera, samples=1, aovs=("face", "instance", "uv"))
    levels = _core.MeshLevels(assembly._core, math.inf)
    id, uv, instance, face = _core.Rasterizer(backend).draw(
        levels, assembly._core, camera._core, 0.3, process=process
    )
    seeds = _core.Rasterizer(backend).seeds(levels, assembly._core, camera._core, 0.3, process=process)
    np.testing.assert_array_equal(seeds.id(), id)
    np.testing.assert_array_equal(seeds.uv()[id > 0], uv[id > 0])
    assert seeds.targets == len(face) == len(instance)
    assert id.shape == (90, 120) and uv.shape == (90, 120, 2)
    seen = id > 0
    assert seen.sum() > 300
    assert np.isnan(uv[~seen]).all() and not np.isnan(uv[seen]).any()
    # Flat faces: the mesh is exact, up to pixels on an edge.
    assert (seen != (frame["face"] >= 0)).sum() <= 5
    both = seen & (frame["face"] >= 0)
    same = (face[id[both] - 1] == frame["face"][both]) & (instance[id[both] - 1] == frame["instance"][both])
    assert (~same).sum() <= 5
    assert set(instance[id[seen] - 1]) == {0, 1}
    if process == "uv":
        for f in np.unique(frame["face"][both]):
            here = both & (frame["face"] == f) & (np.append(-1, face)[id] == f)
            exact = frame["uv"][here].astype(np.float64)
            for k in range(2):  # fractions are uv, moved and scaled
                scale, shift = np.polyfit(exact[:, k], uv[here][:, k], 1)
                np.testing.assert_allclose(scale * exact[:, k] + shift, uv[here][:, k], atol=1e-3)


def test_wrong_arguments(sphere: trimray.Model) -> None:
    with pytest.raises(_core.ArgumentError, match=r"vulkan.*osmesa, egl, embree"):
        _core.Rasterizer("vulkan")
    if not BACKENDS:
        pytest.skip("no raster backend")
    levels, camera = _core.MeshLevels(sphere._core, math.inf), sphere.camera((8, 8))
    rasterizer = _core.Rasterizer(BACKENDS[0])
    with pytest.raises(_core.ArgumentError, match="process"):
        rasterizer.draw(levels, sphere._core, camera._core, process="both")
    with pytest.raises(_core.ArgumentError, match="deviation"):
        rasterizer.draw(levels, sphere._core, camera._core, 0.0)


def test_without_backends() -> None:
    code = """
from trimray import _core
assert not any(there for _, there, _ in _core.raster_backends())
try:
    _core.Rasterizer("osmesa")
except _core.CoreError as error:
    print(error)
"""
    environment = {**os.environ, "TRIMRAY_NO_RASTER": "all"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert "osmesa" in done.stdout and "TRIMRAY_NO_RASTER" in done.stdout


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_process_that_ends_after_a_draw_ends_well(backend: str) -> None:
    code = f"from trimray import _core\nr = _core.Rasterizer({backend!r})\nr.warm_up()\nprint(r.name)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, backend, "")
