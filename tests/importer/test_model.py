"""The record itself."""

import dataclasses
import json

import make
import numpy as np
import pytest

from trimray.importer import read_model, wire


@pytest.fixture
def model():
    return read_model(make.box(), name="box")


def test_meta_is_json_with_the_agreed_keys(model):
    meta = json.loads(model.meta_json())
    assert set(meta) == {
        "unit",
        "unit_mm",
        "prototypes",
        "instances",
        "tree",
        "face_names",
        "layers",
        "report",
        "source",
    }
    assert meta["prototypes"] == [{"name": "box"}]
    assert meta["instances"] == [{"name": "box", "path": ["box"], "node": 0}]
    assert set(meta["tree"][0]) == {"name", "parent", "prototype", "placement"}


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("brep", b""),
        ("prototype_shapes", np.array([0], dtype=np.int32)),
        ("prototype_shapes", np.array([1], dtype=np.int64)),
        ("instance_prototypes", np.array([1], dtype=np.int32)),
        ("instance_placements", np.full((1, 12), np.nan)),
        ("instance_colors", np.zeros((1, 3), dtype=np.float32)),
        ("prototype_names", ()),
    ],
)
def test_validate_rejects(model, field, value):
    model.validate()
    with pytest.raises(ValueError):
        dataclasses.replace(model, **{field: value}).validate()


@pytest.mark.parametrize("piece", [1, 7, 1000, 1 << 20])
def test_wire_carries_a_model_in_pieces(model, piece):
    import io

    pipe = io.BytesIO()
    wire.send(pipe, {"stage": "parse", "fraction": None})
    wire.send_model(pipe, model)
    data, inbox, messages = pipe.getvalue(), wire.Inbox(), []
    for start in range(0, len(data), piece):
        messages += inbox.feed(data[start : start + piece])
    assert [next(iter(message)) for message, _ in messages] == ["stage", "model"]
    again = wire.model_of(messages[1][0]["model"], messages[1][1])
    for f in dataclasses.fields(model):
        assert np.array_equal(getattr(again, f.name), getattr(model, f.name)), f.name
