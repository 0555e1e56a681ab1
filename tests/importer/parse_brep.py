"""A model's stream read back by OpenCascade, to look at what the importer wrote."""

import io

from OCP.BinTools import BinTools_ShapeSet
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.TopoDS import TopoDS_Shape

from trimray.importer import BrepModel


def shapes_of(model: BrepModel) -> BinTools_ShapeSet:
    """shape_set.Shape(i) is the shape of index i."""
    shape_set = BinTools_ShapeSet()
    shape_set.Read(io.BytesIO(model.brep))
    return shape_set


def prototype(model: BrepModel, index: int) -> TopoDS_Shape:
    return shapes_of(model).Shape(int(model.prototype_shapes[index]))


def bounds(shape: TopoDS_Shape) -> tuple[float, ...]:
    """xmin, ymin, zmin, xmax, ymax, zmax."""
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    return tuple(box.Get())
