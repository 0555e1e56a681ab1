"""Layers of parts, of single faces and of single instances come back from a store by way of STEP, which knows
none of instances."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import trimray
from trimray.exporter.files import write_file
from trimray.exporter.from_store import build_parts, rebuild
from trimray.fidelity import compare
from trimray.hierarchy import Hierarchy
from trimray.importer.build_store import build_store

Layers = dict[str, dict[str, list[int]]]

# Of the sample: plates 0 and 5, screws 1 to 4 and 6 to 9, a pin 10; 0 to 4 and 5 to 9 are one assembly twice.
SCREWS = [1, 2, 3, 4, 6, 7, 8, 9]


@pytest.fixture
def there_and_back(
    read_here: Any, samples_dir: Path, tmp_path: Path
) -> Callable[[Layers], tuple[trimray.Model, trimray.Model]]:
    """The assembly with these layers, and what is read of what was written of its store."""

    def call(layers: Layers) -> tuple[trimray.Model, trimray.Model]:
        nothing: dict[str, list[int]] = {"prototypes": [], "instances": [], "shapes": []}
        read = read_here(samples_dir / "assembly.step")
        read.layers.update({name: nothing | on for name, on in layers.items()})
        store = build_store(read)
        again = tmp_path / "assembly.step"
        write_file(rebuild(store.arrays(), store.meta), str(again), "step", "ap242")
        one, other = (
            trimray.Model(Hierarchy(it), seconds={}, source="assembly.step")
            for it in (store, build_store(read_here(again)))
        )
        return one, other

    return call


def on_layers(model: trimray.Model) -> dict[str, Counter[tuple[float, ...]]]:
    """Where the faces on each layer stand, singly or with their instance."""
    arrays, found = model._core.arrays(), {}
    for name, layer in model.layers.items():
        found[name] = Counter[tuple[float, ...]]()
        for instance in model.instances:
            prototype = arrays["instances"]["prototype"][instance.number]
            faces = range(*arrays["prototypes"]["faces"][prototype].tolist())
            count = len(faces) if instance.number in layer.instances else len(set(faces) & set(layer.faces))
            place = tuple((instance.placement.round(6) + 0.0).ravel().tolist())
            found[name].update({place: count} if count else {})
    return found


@pytest.mark.parametrize(
    ("layers", "parts"),
    [
        ({"plates": {"prototypes": [0]}}, 3),
        ({"all screws": {"instances": SCREWS}}, 3),  # so is their part
        ({"some": {"instances": [1, 7]}}, 4),
        ({"one leaf": {"instances": [5, 6, 7, 8, 9]}}, 5),
        ({"both": {"prototypes": [2], "instances": [10]}}, 3),
        ({"a": {"instances": SCREWS}, "b": {"instances": [1, 2]}, "ç": {"instances": [2, 3]}}, 6),
    ],
    ids=lambda value: "+".join(value) if isinstance(value, dict) else None,
)
def test_layers_come_back(there_and_back: Any, layers: Layers, parts: int) -> None:
    """parts: how many the file has then, 3 as they were."""
    model, again = there_and_back(layers)
    assert on_layers(model) == on_layers(again) and set(again.layers) == set(layers)
    assert len(build_parts(again._core.arrays())) == parts
    found = compare(model, again, points=500, pictures=False)
    assert [(f.name, f.a, f.b, f.where) for f in found.differences()] == []
    assert {f.name: f.a for f in found.findings}["layers"] == len(layers)


def test_a_lost_layer_of_an_instance_is_found(there_and_back: Any) -> None:
    model, again = there_and_back({"some": {"instances": [1, 7]}})
    again.__dict__["layers"] = {"some": trimray.Layer((), (1,))}
    found = compare(model, again, points=500, pictures=False)
    faces = len(model.faces) and int(on_layers(model)["some"].total())
    (layer,) = [f for f in found.differences() if f.name == "layer"]
    assert (layer.a, layer.b, layer.where) == (faces, faces // 2, "some")
