"""trimray bench."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import trimray
from trimray import _core

from .conftest import Run

SMALL = ("--size", "64,48", "--repeat", "1")
ROOT = Path(__file__).resolve().parents[2]
MANUAL = (ROOT / "docs" / "cli.md").read_text()
BACKENDS = [name for name, there, _ in _core.raster_backends() if there]


def bench(run: Run, *arguments: object) -> Any:
    result = run("bench", *arguments, *SMALL, "--json")
    assert result.code == 0 and result.err == ""
    return json.loads(result.out)


def test_the_figures_are_those_of_the_picture(run: Run, samples_dir: Path) -> None:
    path = samples_dir / "teapot.step"
    facts = bench(run, path, "--seeds", "none")
    model = trimray.load(path)
    face = model.render((64, 48), samples=1, aovs="face")["face"]
    assert facts["size"] == [64, 48] and facts["nurbs_surfaces"] == 32
    assert facts["screen_coverage"] == pytest.approx((face >= 0).mean(), abs=1e-6)
    # The paper's teapot has 13,018 boxes.
    assert facts["bvh_boxes"]["paper"] == pytest.approx(13018, rel=0.1)
    assert facts["bvh_boxes"]["standard"] == model._scene.leaf_boxes
    assert facts["triangles"] > 32 and facts["raster"] is None
    covered = int((face >= 0).sum())
    tracers = {"paper", "standard", "hybrid"}
    assert set(facts["intersections"]) == tracers
    assert all(count >= covered for count in facts["intersections"].values())
    for threads in ("one_thread", "all_threads"):
        assert set(facts["frames_per_second"][threads]) == tracers
        assert all(rate > 0.0 for rate in facts["frames_per_second"][threads].values())
    assert 1.0 <= facts["calls_per_covered_pixel"] < 3.0
    assert facts["fallback_share"] < 0.1 and facts["seeded_share"] == 0.0
    assert {"mesh", "trace", "shade"} == set(facts["stage_seconds"])
    assert all(size > 0 for size in facts["bytes"].values())


@pytest.mark.skipif(not BACKENDS, reason="no raster backend works here")
def test_both_processes_are_measured_with_every_backend(run: Run, ball_file: Path) -> None:
    for backend in (*BACKENDS, "auto"):
        facts = bench(run, ball_file, "--seeds", backend)
        assert facts["raster"] == backend or (backend == "auto" and facts["raster"] in BACKENDS)
        names = {"paper", "standard", "hybrid", "hybrid_id", "hybrid_uv"}
        assert set(facts["frames_per_second"]["one_thread"]) == names
        assert {"raster_id", "raster_uv"} < set(facts["stage_seconds"])


def test_a_column_a_model_for_the_eye(run: Run, box_file: Path, ball_file: Path) -> None:
    result = run("bench", box_file, ball_file, *SMALL)
    lines = result.out.decode().splitlines()
    assert result.code == 0 and result.err == ""
    assert lines[0].split() == ["box.step", "ball.step"]
    row = {line[: lines[0].index("box.step")].strip(): line.split()[-2:] for line in lines[2:]}
    assert row["NURBS surfaces"] == ["6", "1"]
    for title in ("screen coverage", "BVH boxes", "fps, 1 thread, standard", "trace, ms", "store, MB"):
        assert len(row[title]) == 2, title


def test_an_input_that_cannot_be_read_is_named_and_the_others_are_measured(
    run: Run, box_file: Path, tmp_path: Path
) -> None:
    result = run("bench", tmp_path / "no.step", box_file, *SMALL, "--json")
    facts = json.loads(result.out)
    assert result.code == 1 and "no.step" in result.err
    assert "no.step" in facts[0]["error"] and facts[1]["nurbs_surfaces"] == 6
    result = run("bench", tmp_path / "no.step", *SMALL)
    assert result.code == 3 and result.out == b""


@pytest.mark.parametrize("arguments", [("--repeat", "0"), ("--repeat", "x"), ("--seeds", "vulkan")])
def test_wrong_usage(run: Run, box_file: Path, arguments: tuple[str, str]) -> None:
    result = run("bench", box_file, *arguments)
    assert result.code == 2 and arguments[0].lstrip("-") in result.err


def test_every_key_is_explained(run: Run, ball_file: Path, tmp_path: Path) -> None:
    def keys(value: object) -> set[str]:
        if isinstance(value, list):
            return set().union(*(keys(x) for x in value))
        if not isinstance(value, dict):
            return set()
        return set(value).union(*(keys(v) for v in value.values()))

    found = keys(json.loads(run("bench", ball_file, tmp_path / "no.step", *SMALL, "--json").out))
    assert {"frames_per_second", "standard", "error"} <= found
    for key in found:
        assert f"`{key}`" in MANUAL, key
