"""What files declare, beside what arrives of it: validation properties, layers, counts; and real models."""

import json
import math
from pathlib import Path

import conftest
import make
import numpy as np
import pytest
from OCP.gp import gp_Pnt
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDF import TDF_Label
from OCP.XCAFDoc import XCAFDoc_Area, XCAFDoc_Centroid, XCAFDoc_DocumentTool, XCAFDoc_Volume

import trimray
from trimray.importer import TimeLimitError, inspect_mass
from trimray.importer.input_file import open_input
from trimray.importer.inspect_child import inspect_file
from trimray.importer.inspection import Inspection
from trimray.importer.report import Report


@pytest.fixture
def inspect_here(tmp_path):
    """In this process: what the child does, without the second it takes to start one."""

    def run(path: Path) -> Inspection:
        report = Report()
        opened = open_input(str(path), name=str(path), folder=str(tmp_path), memory_limit=None, report=report)
        return inspect_file(opened, name=str(path), folder=str(tmp_path), report=report)

    return run


def _write(document: make.Document, path: Path, unit: str = "MM") -> Path:
    """With layers and validation properties."""
    document.shapes.UpdateAssemblies()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    writer = STEPCAFControl_Writer()
    for switch in ("Color", "Name", "Layer", "Props"):
        getattr(writer, f"Set{switch}Mode")(True)
    writer.Transfer(document.document, STEPControl_StepModelType.STEPControl_AsIs)
    assert writer.Write(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    return path


def _declare(label: TDF_Label, volume: float, area: float, centroid: tuple[float, float, float]) -> None:
    XCAFDoc_Volume.Set_s(label, volume)
    XCAFDoc_Area.Set_s(label, area)
    XCAFDoc_Centroid.Set_s(label, gp_Pnt(*centroid))


def _layer(document: make.Document, label: TDF_Label, name: str) -> None:
    tool = XCAFDoc_DocumentTool.LayerTool_s(document.document.Main())
    tool.SetLayer(label, tool.AddLayer(TCollection_ExtendedString(name, True)))


@pytest.mark.parametrize("unit", ["MM", "INCH"])
def test_validation_properties_are_read_in_their_unit(tmp_path, inspect_here, unit: str) -> None:
    document = make.Document()
    part = document.part(make.box(), "böx")
    assembly = document.assembly("two")
    document.component(assembly, part, make.moved(100.0), "left")
    document.component(assembly, part, make.moved(200.0), "right")
    _declare(part, 6000.0, 2200.0, (5.0, 10.0, 15.0))
    _declare(assembly, 12000.0, 4400.0, (155.0, 10.0, 15.0))
    found = inspect_here(_write(document, tmp_path / "two.step", unit))
    # OpenCascade gives a part's properties to its body: "body #12 of part böx".
    by_of = {(p.of.rpartition(" of part ")[2], p.quantity): p for p in found.properties}
    assert set(by_of) == {
        (of, quantity) for of in ("böx", "assembly two") for quantity in ("volume", "area", "centroid")
    }
    assert by_of["böx", "volume"].value == pytest.approx(6000.0, rel=1e-12)
    assert by_of["böx", "volume"].prototype == 0
    centroid = by_of["assembly two", "centroid"]
    assert centroid.measured == pytest.approx((155.0, 10.0, 15.0), rel=1e-12)
    # OpenCascade's writer converts areas and volumes, but writes centroids in mm whatever the unit.
    scale = 25.4 if unit == "INCH" else 1.0
    assert np.array(centroid.value) / scale == pytest.approx((155.0, 10.0, 15.0), rel=1e-12)
    assert max(p.relative for p in found.properties if p.quantity != "centroid") < 1e-11
    assert all(p.reason == "" and p.entity.startswith("#") for p in found.properties)


def test_validation_properties_that_do_not_hold_are_seen(tmp_path, inspect_here) -> None:
    document = make.Document()
    part = document.part(make.cylinder(), "pin")
    _declare(part, 300.0 * math.pi * 1.001, 170.0 * math.pi, (0.0, 1.0, 6.0))
    found = {p.quantity: p for p in inspect_here(_write(document, tmp_path / "pin.step")).properties}
    assert found["volume"].relative == pytest.approx(1e-3 / 1.001, rel=1e-6)
    assert found["area"].relative < 1e-12
    assert found["centroid"].relative == pytest.approx(1.0 / math.sqrt(10**2 + 10**2 + 12**2), rel=1e-3)


def test_properties_of_what_cannot_be_drawn_are_not_compared(tmp_path, inspect_here, monkeypatch) -> None:
    measure = inspect_mass._core.measure_mass

    def without_the_first(store: object) -> dict[str, np.ndarray]:
        found = measure(store)
        lost = np.arange(len(found["face_integrals"]))[:, None] == 0
        return found | {"face_integrals": np.where(lost, np.nan, found["face_integrals"])}

    monkeypatch.setattr(inspect_mass._core, "measure_mass", without_the_first)
    document = make.Document()
    _declare(document.part(make.box(), "box"), 6000.0, 2200.0, (5.0, 10.0, 15.0))
    found = inspect_here(_write(document, tmp_path / "box.step"))
    assert found.mass.left_out == (0,) and found.mass.volume == 0.0
    assert [(p.relative, p.measured) for p in found.properties] == [(None, None)] * 3
    assert all("cannot be drawn" in p.reason for p in found.properties)


def test_blank_properties_are_not_compared(tmp_path, inspect_here) -> None:
    document = make.Document()
    _declare(document.part(make.box(), "box"), 0.0, 2200.0, (5.0, 10.0, 15.0))
    found = {p.quantity: p for p in inspect_here(_write(document, tmp_path / "box.step")).properties}
    assert found["volume"].relative is None
    assert "0 instead of a value" in found["volume"].reason
    assert found["area"].relative < 1e-12


@pytest.fixture
def layered(tmp_path) -> Path:
    document = make.Document()
    box, pin = make.box(), make.cylinder()
    parts = document.part(box, "box"), document.part(pin, "pin")
    assembly = document.assembly("top")
    document.component(assembly, parts[0], make.moved(100.0), "left")
    document.component(assembly, parts[0], make.moved(200.0), "right")
    document.component(assembly, parts[1], make.moved(300.0), "third")
    _layer(document, parts[1], "pins")
    _layer(document, document.subshape(parts[0], make.faces(box)[2]), "façade")
    return _write(document, tmp_path / "layers.step")


def test_layers_arrive_with_the_model_and_the_inspection(layered, inspect_here) -> None:
    model = trimray.load(layered, cache=False)
    assert set(model.layers) == {"pins", "façade"}
    assert model.layers["pins"] == trimray.Layer(faces=(6, 7, 8), instances=())
    assert model.layers["façade"] == trimray.Layer(faces=(2,), instances=())
    found = inspect_here(layered)
    assert found.layers == {
        name: {"faces": list(layer.faces), "instances": list(layer.instances)}
        for name, layer in model.layers.items()
    }


def test_layers_survive_the_cache_and_merging(layered, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    first, again = trimray.load(layered), trimray.load(layered)
    assert again.layers == first.layers
    merged = trimray.merge([first, again])
    assert merged.layers["façade"].faces == (2, 2 + len(first.faces))


def test_iges_layers_arrive(tmp_path, inspect_here) -> None:
    path = make.iges_file(tmp_path / "box.igs", make.box(), solids=True)
    found = inspect_here(path)
    assert found.layers == {}
    assert found.entities["510"] == 6
    counts = {c.name: (c.declared, c.arrived) for c in found.counts}
    assert counts["faces"] == (6, 6)
    assert counts["solids"] == (1, 1)
    assert found.mass.volume == pytest.approx(6000.0, rel=1e-12)


def test_a_face_that_does_not_arrive_is_missing_and_named(tmp_path, inspect_here) -> None:
    path = make.step_file(tmp_path / "box.step", make.box())
    text = path.read_text()
    plane = text.index("PLANE(")
    path.write_text(text[:plane] + "PLAIN(" + text[plane + 6 :])
    found = inspect_here(path)
    faces = next(c for c in found.counts if c.name == "faces")
    assert (faces.declared, faces.arrived, faces.missing) == (6, 5, 1)
    assert any(lost.severity == "error" and lost.entity.startswith("#") for lost in found.lost)
    assert found.topology.free_edges == 4


def test_the_child_gives_the_same_answer(tmp_path, inspect_here) -> None:
    path = make.step_file(tmp_path / "pin.step", make.cylinder())
    there, here = trimray.inspect(path), inspect_here(path)
    assert there.topology == here.topology
    assert there.mass == here.mass
    assert there.prototypes == here.prototypes
    assert there.counts == here.counts
    for column in ("faces", "length", "deviation", "smooth"):
        assert np.array_equal(getattr(there.edges, column), getattr(here.edges, column))
    assert there.edges.faces.dtype == np.int32
    assert {"parse", "measure", "edges", "check"} <= set(there.seconds)
    assert there.source["schema"].startswith("AUTOMOTIVE_DESIGN")


def test_limits_hold_for_inspections(tmp_path) -> None:
    path = make.step_file(tmp_path / "box.step", make.box())
    with pytest.raises(TimeLimitError, match=r"box\.step: not read within 0\.01 s"):
        trimray.inspect(path, time_limit=0.01)


_skip = pytest.mark.skipif(
    conftest.models_folder() is None, reason="TRIMRAY_MODELS does not name a folder with a MANIFEST.tsv"
)
# name -> how many properties, how far a volume or area may be from what the file declares, and a centroid.
# The numbers of as1-oc-214 are those that OpenCascade gives without an adaptive integration.
_DECLARED = {
    "stepcode+stepcode/as1-oc-214.stp": (27, 1.4e-3, 8e-6),
    "stepcode+stepcode/dm1-id-214.stp": (19, 3e-6, 2.3e-6),
    "yuechen-li-dev+Aetheris/nist_ctc_01_asme1_ap242-e1.stp": (3, 1e-7, 1e-7),
}


@pytest.mark.corpus
@_skip
@pytest.mark.parametrize("name", _DECLARED)
def test_real_models_are_what_they_declare(name: str, inspect_here, real_model) -> None:
    count, relative, apart = _DECLARED[name]
    found = inspect_here(real_model(name))
    compared = [p for p in found.properties if not p.reason]
    assert len(found.properties) == count
    assert max(p.relative for p in compared if p.quantity != "centroid") < relative
    assert max(p.relative for p in compared if p.quantity == "centroid") < apart
    assert [c.name for c in found.counts if c.missing] == []
    assert found.topology.closed_shells == found.topology.shells
    assert found.mass.volume_error < 1e-12 * found.mass.volume
    json.dumps(found.as_dict(), allow_nan=False)


@pytest.mark.corpus
@_skip
def test_the_centroid_of_dm1_is_that_of_its_mass(inspect_here, real_model) -> None:
    """It is far from the centroid of the volume, but where the densities in the file put it (lb/in^3)."""
    found = inspect_here(real_model("stepcode+stepcode/dm1-id-214.stp"))
    density = {"bolt": 0.285230375059732, "l-bracket": 0.160129333366867, "nut": 0.297240075062247}
    volumes = {p.of.removeprefix("part "): p.measured for p in found.properties if p.quantity == "volume"}
    weight, moment = 0.0, np.zeros(3)
    for p in found.properties:
        if p.of.startswith("instance "):
            part = p.of.split()[1].rpartition("_")[0]
            weight += density[part] * volumes[part]
            moment += density[part] * volumes[part] * np.array(p.measured)
    (whole,) = (p for p in found.properties if p.of == "assembly dm1" and p.quantity == "centroid")
    assert np.linalg.norm(moment / weight - whole.value) < 1e-4
    assert whole.relative > 0.01
    assert "densities" in whole.reason


@pytest.mark.corpus
@_skip
def test_blank_properties_of_a_real_model(inspect_here, real_model) -> None:
    found = inspect_here(real_model("yuechen-li-dev+Aetheris/nist_stc_06_asme1_ap242-e3.stp"))
    assert {p.reason for p in found.properties} == {"the file says 0 instead of a value"}
    assert set(found.layers) == {"1"}
    assert len(found.layers["1"]["faces"]) == 144
