"""Makes every model of this folder with cadquery: `python samples/make_samples.py [NAME ...]`.

The files are committed, so that nobody needs cadquery to use them; run this again only to change
them. FILES says which function makes which file; what each exercises stands in README.md.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import cadquery as cq
from freeform import cornell_box, free_patch, spline_part, teapot
from OCP.IFSelect import IFSelect_RetDone
from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer
from OCP.Message import Message, Message_Gravity
from torture import TORTURE

HERE = Path(__file__).resolve().parent
Model = cq.Workplane | cq.Shape | cq.Assembly


def bracket() -> Model:
    """A filleted mounting bracket with counterbored holes and a slot."""
    base = cq.Workplane("XY").box(80, 50, 8, centered=(True, True, False))
    wall = cq.Workplane("XY").box(8, 50, 45, centered=(False, True, False)).translate((-40, 0, 0))
    part = base.union(wall)
    part = part.edges("|Y").edges(cq.NearestToPointSelector((-32, 0, 8))).fillet(10)
    part = part.edges("|Z and >X").fillet(12).edges("|X and >Z").fillet(8)
    top = part.faces(cq.NearestToPointSelector((8, 0, 8))).workplane(origin=(0, 0, 8))
    part = top.pushPoints([(26, 14), (26, -14)]).cboreHole(6.5, 11, 4)
    top = part.faces(cq.NearestToPointSelector((8, 0, 8))).workplane(origin=(0, 0, 8))
    part = top.slot2D(20, 7).cutThruAll()
    part = part.faces("<X").workplane(origin=(-40, 0, 26)).hole(16)
    return part.faces(">X").edges(">Z or <Z").chamfer(1)


def stand() -> cq.Workplane:
    """Holds bracket.step from below: a plate on four feet."""
    plate = cq.Workplane().box(110, 80, 4, centered=(True, True, False)).translate((0, 0, -4))
    plate = plate.edges("|Z").fillet(10)
    return plate.faces("<Z").workplane().rect(90, 60, forConstruction=True).vertices().circle(5).extrude(12)


def assembly() -> Model:
    """A coloured hinge: one plate and one screw prototype, placed many times, one level nested."""
    screw = cq.Workplane("XY").circle(4).extrude(3.2).faces("<Z").workplane().circle(2).extrude(12)
    screw = screw.faces(">Z").workplane().polygon(6, 3.4).cutBlind(-2)
    plate = cq.Workplane("XY").box(40, 30, 4, centered=(False, True, False)).edges("|Z").fillet(4)
    plate = plate.faces(">Z").workplane(origin=(0, 0, 4))
    plate = plate.pushPoints([(10, 8), (10, -8), (30, 8), (30, -8)]).hole(4.4)
    pin = cq.Workplane("XZ").circle(3).extrude(34).translate((0, 17, 2))
    leaf = cq.Assembly(name="leaf")
    leaf.add(plate, name="plate", color=cq.Color(0.2, 0.45, 0.7))
    for k, (x, y) in enumerate([(10, 8), (10, -8), (30, 8), (30, -8)]):
        leaf.add(screw, name=f"screw{k}", loc=cq.Location((x, y, 4)), color=cq.Color(0.8, 0.65, 0.3))
    hinge = cq.Assembly(name="hinge")
    hinge.add(leaf, name="right", loc=cq.Location((4, 0, 0)))
    hinge.add(leaf, name="left", loc=cq.Location((-4, 0, 0), (0, 0, 1), 180))
    hinge.add(pin, name="pin", color=cq.Color(0.75, 0.1, 0.1))
    return hinge


FILES: dict[str, Callable[[], Model]] = {
    "bracket.step": bracket,
    "stand.stl": stand,
    "bracket_faces.igs": bracket,
    "bracket_solid.igs": bracket,
    "bracket.brep": bracket,
    "assembly.step": assembly,
    "spline_part.step": spline_part,
    "patch.step": free_patch,
    "cornell_box.step": cornell_box,
    "teapot.step": teapot,
    "teapot.igs": teapot,
    **{f"torture/{name}.step": make for name, make in TORTURE.items()},
}


def _settle_header(path: Path) -> None:
    """Gives the file's header a fixed time stamp."""
    text = path.read_text(encoding="utf-8", errors="surrogateescape")
    if path.suffix == ".step":
        text = re.sub(r"'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d'", "'2026-01-01T00:00:00'", text)
    else:
        text = re.sub(r"15H\d{8}\.\d{6}", "15H20260101.000000", text)
    path.write_text(text, encoding="utf-8", errors="surrogateescape")


def _write(model: Model, path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    if isinstance(model, cq.Assembly):
        model.export(str(path))
    elif path.suffix == ".igs":
        IGESControl_Controller.Init_s()
        writer = IGESControl_Writer("MM", 1 if "solid" in path.stem else 0)  # 1: B-rep entities 186
        writer.AddShape(_shape(model).wrapped)
        writer.ComputeModel()
        assert writer.Write(str(path))
    elif path.suffix == ".stl":
        _shape(model).exportStl(str(path), tolerance=0.02, angularTolerance=0.2)
    elif path.suffix == ".brep":
        _shape(model).exportBrep(str(path))
    else:
        assert _shape(model).exportStep(str(path)) == IFSelect_RetDone
    if path.suffix in (".step", ".igs"):
        _settle_header(path)


def _shape(model: cq.Workplane | cq.Shape) -> cq.Shape:
    if isinstance(model, cq.Shape):
        return model
    values = model.vals()
    return values[0] if len(values) == 1 else cq.Compound.makeCompound(values)


def main(names: list[str]) -> None:
    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)
    for file, make in FILES.items():
        if not names or Path(file).stem in names or file in names:
            _write(make(), HERE / file)
            print(file, (HERE / file).stat().st_size)


if __name__ == "__main__":
    main(sys.argv[1:])
