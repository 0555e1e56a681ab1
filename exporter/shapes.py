"""Small things that several modules do with shapes."""

from collections.abc import Sequence

from OCP.BRep import BRep_Builder
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shape


def compound_of(shapes: Sequence[TopoDS_Shape]) -> TopoDS_Shape:
    """One shape that holds all; the only one itself."""
    if len(shapes) == 1:
        return shapes[0]
    compound = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape)
    return compound
