"""What child and parent say to each other through one pipe.

A message is a JSON line; a line with "blobs": [n, ...] is followed by that many raw blocks. Messages:
    {"stage": name, "fraction": null}       reading has reached a stage
    {"error": class name, "message": ..}    it failed
    {"model": {...}, "blobs": [...]}        it is done
"""

import json
from typing import Any, BinaryIO

import numpy as np

from .mesh_model import MeshModel
from .model import BrepModel, Instance, TreeNode

_ARRAYS: dict[str, tuple[type[np.generic], tuple[int, ...]]] = {
    "prototype_shapes": (np.int32, (-1,)),
    "prototype_colors": (np.float32, (-1, 4)),
    "face_color_shapes": (np.int32, (-1,)),
    "face_colors": (np.float32, (-1, 4)),
    "instance_prototypes": (np.int32, (-1,)),
    "instance_placements": (np.float64, (-1, 12)),
    "instance_colors": (np.float32, (-1, 4)),
}


_MESH_ARRAYS: dict[str, tuple[type[np.generic], tuple[int, ...]]] = {
    "vertices": (np.float64, (-1, 3)),
    "triangles": (np.int32, (-1, 3)),
    "group_ends": (np.int32, (-1,)),
    "group_colors": (np.float32, (-1, 4)),
}


def send(pipe: BinaryIO, message: dict[str, Any], blobs: tuple[bytes, ...] = ()) -> None:
    """Writes one message and flushes."""
    if blobs:
        message = {**message, "blobs": [len(blob) for blob in blobs]}
    pipe.write(json.dumps(message, ensure_ascii=True).encode() + b"\n")
    for blob in blobs:
        pipe.write(blob)
    pipe.flush()


def send_model(pipe: BinaryIO, model: BrepModel | MeshModel) -> None:
    """Writes the "model" message."""
    if isinstance(model, MeshModel):
        mesh = {
            "group_names": model.group_names,
            "name": model.name,
            "source": model.source,
            "report": model.report,
        }
        blobs = tuple(getattr(model, name).tobytes() for name in _MESH_ARRAYS)
        send(pipe, {"model": {"mesh": mesh}}, blobs)
        return
    header = {
        "prototype_names": model.prototype_names,
        "face_names": list(model.face_names.items()),
        "layers": model.layers,
        "instances": [(i.name, i.path, i.node) for i in model.instances],
        "tree": [(n.name, n.parent, n.prototype, n.placement) for n in model.tree],
        "unit": model.unit,
        "unit_mm": model.unit_mm,
        "source": model.source,
        "report": model.report,
    }
    send(pipe, {"model": header}, (model.brep, *(getattr(model, name).tobytes() for name in _ARRAYS)))


def model_of(header: dict[str, Any], blobs: list[bytes]) -> BrepModel | MeshModel:
    """The model of a "model" message. Raises ValueError when it does not hold together."""
    if "mesh" in header:
        return _mesh_of(header["mesh"], blobs)
    arrays: dict[str, Any] = {
        name: np.frombuffer(blob, dtype=dtype).reshape(shape)
        for (name, (dtype, shape)), blob in zip(_ARRAYS.items(), blobs[1:], strict=True)
    }
    model = BrepModel(
        brep=blobs[0],
        **arrays,
        prototype_names=tuple(header["prototype_names"]),
        face_names={int(shape): name for shape, name in header["face_names"]},
        layers=header["layers"],
        instances=tuple(Instance(name, tuple(path), node) for name, path, node in header["instances"]),
        tree=tuple(TreeNode(n, parent, prototype, tuple(p)) for n, parent, prototype, p in header["tree"]),
        unit=header["unit"],
        unit_mm=header["unit_mm"],
        source=header["source"],
        report=header["report"],
    )
    model.validate()
    return model


def _mesh_of(header: dict[str, Any], blobs: list[bytes]) -> MeshModel:
    arrays: dict[str, Any] = {
        name: np.frombuffer(blob, dtype=dtype).reshape(shape)
        for (name, (dtype, shape)), blob in zip(_MESH_ARRAYS.items(), blobs, strict=True)
    }
    mesh = MeshModel(
        **arrays,
        group_names=tuple(header["group_names"]),
        name=header["name"],
        source=header["source"],
        report=header["report"],
    )
    mesh.validate()
    return mesh


class Inbox:
    """Puts messages together from whatever pieces arrive."""

    def __init__(self) -> None:
        self._pending: list[bytes] = []
        self._size = 0
        self._header: dict[str, Any] | None = None
        self._wanted = 0

    def feed(self, data: bytes) -> list[tuple[dict[str, Any], list[bytes]]]:
        """Takes bytes; returns the messages that they complete."""
        self._pending.append(data)
        self._size += len(data)
        done: list[tuple[dict[str, Any], list[bytes]]] = []
        while True:
            if self._header is not None:
                if self._size < self._wanted:
                    return done
                buffer = b"".join(self._pending)
                done.append((self._header, self._take(buffer, self._header["blobs"])))
                self._header = None
                continue
            buffer = b"".join(self._pending)
            end = buffer.find(b"\n")
            self._pending = [buffer]
            if end < 0:
                return done
            header = json.loads(buffer[:end])
            self._pending = [buffer[end + 1 :]]
            self._size = len(self._pending[0])
            if "blobs" in header:
                self._header, self._wanted = header, sum(header["blobs"])
            else:
                done.append((header, []))

    def _take(self, buffer: bytes, sizes: list[int]) -> list[bytes]:
        blobs = []
        start = 0
        for size in sizes:
            blobs.append(buffer[start : start + size])
            start += size
        self._pending = [buffer[start:]]
        self._size = len(self._pending[0])
        return blobs
