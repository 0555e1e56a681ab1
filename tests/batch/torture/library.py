"""Puts the library together: the same files for the same seed and size."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from . import crashers, junk, places
from .entry import Entry, Expect, write
from .mutate import OPERATIONS, Recipe
from .sources import Source, all_sources

SPHERE = "samples/torture/sphere.step"
# Mutants of larger models would take most of the time and show nothing else.
_MUTANT_BYTES = 330_000
# Models that are known to be broken, or hold what no reader of ours knows: as `trimray render` says.
_DODGY = ("models/dodgy-step-files/", "models/BRL-CAD+brlcad/ge6.igs")
# Refers to files beside it.
_NOT_ALONE = ("models/stepcode+stepcode/TAIL.stp",)
_CUTS = (0.02, 0.2, 0.5, 0.8, 0.95)


def build(root: Path, *, mutants: int, seed: int = 1, small: bool = False) -> list[Entry]:
    """Fills the empty folder ``root``; returns what is in it, in the order of the paths.

    small: samples alone, one or two files of a kind; for the tests of every day.
    """
    root.mkdir(parents=True, exist_ok=True)
    sources = all_sources(models=not small)
    by_name = {source.name: source for source in sources}
    sphere = by_name[SPHERE].read()
    if small:
        sources = [source for source in sources if source.size < 20_000]
    words = random.Random(f"library {seed}")
    entries = [*_good(root, sources), *_cut(root, sources, 6 if small else len(sources))]
    entries += _mutants(root, sources, mutants, words)
    entries += _from_recipes(root, by_name, "crash", crashers.CRASHES[: 4 if small else None])
    # The tests of every day set no time limit that a busy machine could reach: one that ends by itself.
    hangs = (
        [h for h in crashers.HANGS if h[1] == "nan" and "helix" in h[0]][:1] if small else crashers.HANGS[::5]
    )
    entries += _from_recipes(root, by_name, "hang", hangs)
    for name, data in junk.not_models().items():
        entries.append(write(root, _entry(f"junk/{name}", "junk", "bad"), data))
    entries += [] if small else _hungry(root, sphere)
    entries += places.odd_names(root, SPHERE, sphere)
    entries += places.links(root, SPHERE, sphere)
    entries += places.no_files(root)
    for name in ("readme.txt", "drawing.dxf", "picture.png", "part.step.bak", "part.FCStd", "step", ".step"):
        entries.append(write(root, _entry(f"others/{name}", "other types", "absent"), sphere))
    return sorted(entries, key=lambda entry: entry.path)


def save(entries: list[Entry], file: Path) -> None:
    rows = [asdict(entry) | {"path": entry.shown} for entry in entries]
    file.write_text(json.dumps(rows, indent=1))


def _entry(path: str, kind: str, expect: Expect, reason: str = "", alias: str = "") -> Entry:
    return Entry(path.encode(), kind, expect, reason, alias)


def _good(root: Path, sources: list[Source]) -> list[Entry]:
    """Every model, and twice again the small ones under other names."""
    entries = []
    for source in sources:
        data = source.read()
        expect: Expect = "either" if source.name.startswith(_DODGY) else "good"
        kind = "dodgy" if expect == "either" else "good"
        entries.append(write(root, _entry(f"good/{source.name}", kind, expect, alias=source.name), data))
        for copy in range(2 if source.size < 50_000 and source.name not in _NOT_ALONE else 0):
            path = f"duplicates/{copy}/{source.name.replace('/', '_')}"
            kind = "dodgy" if expect == "either" else "duplicates"
            entries.append(write(root, _entry(path, kind, expect, alias=source.name), data))
    return entries


def _cut(root: Path, sources: list[Source], count: int) -> list[Entry]:
    """Broken off in the middle, as by a download. What is cut within the records of a STEP file must fail."""
    entries = []
    for source in sources[:count]:
        data = source.read()
        for share in _CUTS:
            end = int(len(data) * share)
            path = f"cut/{int(share * 100)}/{source.name}"
            step = re.match(rb"\s*ISO-10303-21;", data) is not None
            sure = (step and b"ENDSEC;" in data[end + 20 :]) or source.name.lower().endswith(
                (".stpz", ".stl")
            )
            entries.append(write(root, _entry(path, "cut", "bad" if sure else "either"), data[:end]))
    return entries


def _mutants(root: Path, sources: list[Source], count: int, words: random.Random) -> list[Entry]:
    small = [source for source in sources if source.size < _MUTANT_BYTES]
    names = list(OPERATIONS)
    entries = []
    for i in range(count):
        source = words.choice(small)
        recipe = Recipe(source.name, names[i % len(names)], words.randrange(1_000_000))
        path = f"mutants/{recipe.operation}/{i:04}-{recipe.name}"
        entry = _entry(path, f"mutant: {recipe.operation}", "either")
        entries.append(write(root, entry, recipe.make(source.read())))
    return entries


def _from_recipes(
    root: Path, by_name: dict[str, Source], kind: str, recipes: Sequence[tuple[str, str, int]]
) -> list[Entry]:
    entries = []
    for model, operation, seed in recipes:
        recipe = Recipe(f"samples/{model}", operation, seed)
        entry = _entry(f"{kind}/{recipe.name}", kind, "bad" if kind == "crash" else "either")
        entries.append(write(root, entry, recipe.make(by_name[recipe.model].read())))
    return entries


def _hungry(root: Path, sphere: bytes) -> list[Entry]:
    """Small files that want all memory."""
    files = {**junk.bombs(), **{f"laughs-{n}.step": junk.laughs(sphere, n) for n in (6, 20)}}
    return [write(root, _entry(f"hungry/{name}", "hungry", "bad"), data) for name, data in files.items()]
