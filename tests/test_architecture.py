"""Who may import whom (docs/architecture.md): anything not listed here is forbidden."""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

# Folder of core/ -> what its files may include from core/, as prefixes.
CORE_RULES: dict[str, tuple[str, ...]] = {
    "base": ("core/base/",),
    "brep": ("core/base/", "core/brep/"),
    "nurbs": ("core/base/", "core/brep/", "core/nurbs/"),
    "view": ("core/base/", "core/view/"),
    "tess": ("core/base/", "core/nurbs/", "core/view/", "core/tess/"),
    "trace": ("core/base/", "core/nurbs/", "core/view/", "core/trace/"),
    "hybrid": (
        "core/base/",
        "core/nurbs/",
        "core/view/",
        "core/trace/",
        "core/hybrid/",
        "raster/seed_buffers.h",
    ),
    "distance": ("core/base/", "core/nurbs/", "core/trace/", "core/distance/"),
    "mass": ("core/base/", "core/nurbs/", "core/mass/"),
    "reference": ("core/base/", "core/nurbs/store.h", "core/trace/ray.h", "core/reference/"),
    "bind": ("core/", "raster/rasterizer.h", "raster/seed_buffers.h"),
}

# raster/ stands beside core/ and uses it.
RASTER_RULES = ("core/base/", "core/nurbs/store.h", "core/tess/", "core/view/", "raster/")


# Libraries that only some folders may name.
LIBRARY_RULES: dict[str, tuple[str, ...]] = {
    "tbb/": ("base",),
    "hwy/": ("base", "trace", "hybrid"),
    "OpenMesh/": ("tess",),
    "CDT": ("tess",),
    "nanobind/": ("bind",),
    "Python.h": ("bind",),
    # Of the graphics libraries nobody includes a header: raster/ declares the functions that it loads.
    "GL/": (),
    "EGL/": (),
    "embree": (),
    "dlfcn.h": ("raster",),
}

# Python folder -> third-party and project modules that it may import.
PYTHON_RULES: dict[str, tuple[str, ...]] = {
    "importer": ("numpy", "OCP", "trimray.importer", "trimray._core"),
    "exporter": ("numpy", "OCP", "trimray.importer", "trimray._core"),
    "api": ("numpy", "OpenImageIO", "PIL", "trimesh", "trimray", "trimray.importer"),
    "fidelity": ("numpy", "pytest", "trimray"),
    "batch": ("numpy", "distributed", "trimray"),
    "desktop": ("numpy", "trimray"),
    "cli": ("click", "rich", "numpy", "trimray"),
}

_INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def _core_files() -> list[Path]:
    return sorted(p for p in (ROOT / "core").rglob("*") if p.suffix in (".h", ".cpp"))


def _raster_files() -> list[Path]:
    return sorted(p for p in (ROOT / "raster").rglob("*") if p.suffix in (".h", ".cpp"))


def _includes(path: Path) -> list[str]:
    return _INCLUDE.findall(path.read_text(encoding="utf-8"))


def test_there_is_something_to_check() -> None:
    assert len(_core_files()) > 10
    assert {p.parent.name for p in _core_files()} >= set(CORE_RULES)


@pytest.mark.parametrize("folder", sorted(CORE_RULES))
def test_core_includes_only_what_its_folder_may_use(folder: str) -> None:
    wrong = [
        f"{path.relative_to(ROOT)} includes {name}"
        for path in _core_files()
        if path.parent.name == folder
        for name in _includes(path)
        if name.startswith(("core/", "raster/")) and not name.startswith(CORE_RULES[folder])
    ]
    assert wrong == []


def test_raster_includes_only_what_it_may_use() -> None:
    wrong = [
        f"{path.relative_to(ROOT)} includes {name}"
        for path in _raster_files()
        for name in _includes(path)
        if name.startswith(("core/", "raster/")) and not name.startswith(RASTER_RULES)
    ]
    assert len(_raster_files()) > 5
    assert wrong == []


def test_only_two_files_name_the_libraries_that_make_contexts() -> None:
    naming = {
        p.name for p in _raster_files() if re.search(r"\blibOSMesa|\blibEGL", p.read_text(encoding="utf-8"))
    }
    assert naming == {"gl_context_osmesa.cpp", "gl_context_egl.cpp"}


def test_libraries_stay_where_they_belong() -> None:
    wrong = [
        f"{path.relative_to(ROOT)} includes {name}"
        for path in [*_core_files(), *_raster_files()]
        for name in _includes(path)
        for library, folders in LIBRARY_RULES.items()
        if name.startswith(library) and path.parent.name not in folders
    ]
    assert wrong == []


def test_no_opencascade_header_in_core() -> None:
    opencascade = re.compile(r"^(BRep|Geom|Top|TopoDS|gp_|Standard_|BinTools_)\w*\.hxx$")
    wrong = [str(p) for p in _core_files() for name in _includes(p) if opencascade.match(name)]
    assert wrong == []


def _imports(path: Path, package: str) -> set[str]:
    """Absolute dotted names of everything the file imports, relative imports resolved."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")
                parents = parents[: len(parents) - (node.level - 1)]
                base = ".".join([*parents, base]).rstrip(".")
                found |= {f"{base}.{alias.name}" for alias in node.names}
            else:
                found.add(base)
    return found


@pytest.mark.parametrize("folder", sorted(PYTHON_RULES))
def test_python_imports_only_what_its_folder_may_use(folder: str) -> None:
    package = "trimray" if folder == "api" else f"trimray.{folder}"
    allowed = (*PYTHON_RULES[folder], package)
    wrong = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        for name in _imports(path, package):
            top = name.split(".")[0]
            if top in sys.stdlib_module_names:
                continue
            inside = any(name == a or name.startswith(f"{a}.") for a in allowed)
            if not inside:
                wrong.append(f"{path.relative_to(ROOT)} imports {name}")
    assert wrong == []


def test_only_importer_and_exporter_know_opencascade_and_only_image_io_knows_openimageio() -> None:
    wrong = []
    for folder in PYTHON_RULES:
        for path in (ROOT / folder).rglob("*.py"):
            package = "trimray" if folder == "api" else f"trimray.{folder}"
            for name in _imports(path, package):
                top = name.split(".")[0]
                if top == "OCP" and folder not in ("importer", "exporter"):
                    wrong.append(f"{path} imports {name}")
                if top == "OpenImageIO" and path.name != "image_io.py":
                    wrong.append(f"{path} imports {name}")
    assert wrong == []


def test_only_one_file_knows_dask() -> None:
    knowing = [
        str(path.relative_to(ROOT))
        for folder in PYTHON_RULES
        for path in sorted((ROOT / folder).rglob("*.py"))
        if any(name.split(".")[0] in ("dask", "distributed") for name in _imports(path, f"trimray.{folder}"))
    ]
    assert knowing == ["batch/cluster.py"]


def test_of_the_importer_only_a_few_files_know_the_core() -> None:
    knowing = [
        path.name
        for path in sorted((ROOT / "importer").rglob("*.py"))
        if any(name.startswith("trimray._core") for name in _imports(path, "trimray.importer"))
    ]
    assert knowing == ["build_store.py", "inspect_mass.py", "inspect_scene.py", "read_triangles.py"]


def test_the_command_line_uses_the_public_package_only() -> None:
    wrong = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in sorted((ROOT / "cli").rglob("*.py"))
        for name in _imports(path, "trimray.cli")
        if name.startswith(("trimray.importer", "trimray._core"))
    ]
    assert wrong == []
