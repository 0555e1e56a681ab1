"""From a BrepModel to the native core's store of exact surfaces."""

from .. import _core
from .model import BrepModel


def build_store(read: BrepModel) -> _core.Store:
    """Raises _core.CoreError for a stream or arrays that do not hold together."""
    return _core.Store.build(
        read.brep,
        read.prototype_shapes,
        read.prototype_colors,
        read.face_color_shapes,
        read.face_colors,
        read.instance_prototypes,
        read.instance_placements,
        read.instance_colors,
        read.meta_json(),
    )
