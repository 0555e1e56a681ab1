"""Public names and signatures, pinned: scripts rely on them."""

from __future__ import annotations

import inspect
import math
import subprocess
import sys

import pytest

import trimray


def test_exported_names() -> None:
    assert sorted(trimray.__all__) == [
        "AOVS",
        "Camera",
        "Distances",
        "EdgeSamples",
        "EmptyError",
        "Error",
        "Face",
        "Frame",
        "Hits",
        "InputError",
        "Inspection",
        "Instance",
        "Issue",
        "Layer",
        "LimitError",
        "MassProperties",
        "MemoryLimitError",
        "MeshCheck",
        "MeshIssue",
        "Model",
        "OutputError",
        "Report",
        "Samples",
        "TimeLimitError",
        "TriMesh",
        "UsageError",
        "__version__",
        "compare",
        "inspect",
        "load",
        "merge",
    ]
    for name in trimray.__all__:
        assert getattr(trimray, name) is not None
    with pytest.raises(AttributeError):
        _ = trimray.nothing_of_the_kind  # type: ignore[attr-defined]


def _defaults(function: object) -> dict[str, object]:
    parameters = inspect.signature(function).parameters  # type: ignore[arg-type]
    return {name: p.default for name, p in parameters.items() if p.default is not inspect.Parameter.empty}


def test_defaults_of_load() -> None:
    defaults = _defaults(trimray.load)
    expected = {"cache": True, "heal": "default", "precision": None, "time_limit": None, "memory_limit": None}
    assert expected.items() <= defaults.items()


def test_defaults_of_cast_and_render() -> None:
    assert {"tmin": 0.0, "tmax": math.inf, "mode": "standard"}.items() <= _defaults(
        trimray.Model.cast
    ).items()
    expected = {
        "size": (512, 512),
        "view": "iso",
        "projection": "orthographic",
        "up": "z",
        "samples": 4,
        "mode": "hybrid",
        "aovs": ("color",),
    }
    assert expected.items() <= _defaults(trimray.Model.render).items()


def test_error_tree_and_exit_codes() -> None:
    codes = {
        "Error": 70,
        "UsageError": 2,
        "InputError": 3,
        "EmptyError": 3,
        "OutputError": 4,
        "LimitError": 5,
    }
    codes |= {"TimeLimitError": 5, "MemoryLimitError": 5}
    for name, code in codes.items():
        error = getattr(trimray, name)
        assert issubclass(error, trimray.Error)
        assert error.exit_code == code
    assert issubclass(trimray.EmptyError, trimray.InputError)
    assert issubclass(trimray.TimeLimitError, trimray.LimitError)
    assert issubclass(trimray.MemoryLimitError, trimray.LimitError)


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = (
        "import sys, trimray; print([m for m in ('numpy', 'OCP', 'OpenImageIO', 'rich') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_version_is_the_one_of_the_installed_package() -> None:
    import importlib.metadata

    try:
        installed = importlib.metadata.version("trimray")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("not installed as a package")
    assert trimray.__version__ == installed
