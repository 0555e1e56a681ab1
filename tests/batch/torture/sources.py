"""The models that the library is made of: the samples, and the real models where they are at hand."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SUFFIXES = (".step", ".stp", ".stpz", ".igs", ".iges", ".brep", ".stl")


@dataclass(frozen=True)
class Source:
    """name: "samples/patch.step", or "models/..."."""

    name: str
    path: Path
    size: int

    def read(self) -> bytes:
        return self.path.read_bytes()


def models_folder() -> Path | None:
    folder = Path(os.environ.get("TRIMRAY_MODELS", ROOT.parent / "shared" / "models"))
    return folder if folder.is_dir() else None


def all_sources(models: bool = True) -> list[Source]:
    """In the order of their names."""
    folders = [("samples", ROOT / "samples")]
    found = models_folder() if models else None
    if found is not None:
        folders.append(("models", found))
    sources = []
    for word, folder in folders:
        for path in sorted(folder.rglob("*")):
            if path.suffix.lower() in SUFFIXES and path.is_file():
                name = f"{word}/{path.relative_to(folder)}"
                sources.append(Source(name, path, path.stat().st_size))
    return sources
