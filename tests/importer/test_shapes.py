"""Shapes given in Python."""

import make
import numpy as np
import pytest

from trimray.importer import EmptyError, UsageError, read_model, shapes

cadquery = pytest.importorskip("cadquery")


def test_ocp_shape_keeps_its_location():
    model = read_model(make.box().Moved(make.moved(1, 2, 3)), name="box")
    assert model.prototype_names == ("box",)
    assert model.instance_placements[0][[3, 7, 11]] == pytest.approx([1, 2, 3])
    assert model.report["faces"] == 6


def test_workplane_with_several_solids_is_one_part():
    model = read_model(cadquery.Workplane().pushPoints([(0, 0), (9, 0)]).box(1, 1, 1, combine=False))
    assert model.report["faces"] == 6 and model.report["face_uses"] == 12
    assert len(model.prototype_shapes) == 1


def test_cadquery_shape():
    assert read_model(cadquery.Solid.makeSphere(3, angleDegrees1=-90)).report["faces"] == 1


def test_assembly_keeps_names_colors_and_instances():
    bolt = cadquery.Workplane().cylinder(4, 1)
    inner = cadquery.Assembly(name="inner", color=cadquery.Color(0, 0, 1))
    inner.add(bolt, name="a", loc=cadquery.Location((5, 0, 0)))
    inner.add(bolt, name="b", loc=cadquery.Location((0, 5, 0)), color=cadquery.Color(1, 0, 0, 0.5))
    top = cadquery.Assembly(cadquery.Workplane().box(2, 2, 2), name="top")
    top.add(inner, loc=cadquery.Location((0, 0, 10)))
    model = read_model(top)
    by_name = {instance.path: i for i, instance in enumerate(model.instances)}
    assert set(by_name) == {("top", "top_part"), ("top", "inner", "a"), ("top", "inner", "b")}
    a, b = by_name["top", "inner", "a"], by_name["top", "inner", "b"]
    assert model.instance_prototypes[a] == model.instance_prototypes[b]
    assert model.instance_placements[a][[3, 7, 11]] == pytest.approx([5, 0, 10])
    assert model.instance_colors[a] == pytest.approx([0, 0, 1, 1])
    assert model.instance_colors[b] == pytest.approx([1, 0, 0, 0.5])
    assert model.instance_colors[by_name["top", "top_part"]][0] < 0
    assert len(model.prototype_shapes) == 2


def test_assembly_color_is_srgb():
    """cadquery's Color is sRGB-encoded unless it is told otherwise."""
    color = cadquery.Color(0.5, 0.25, 0.75)
    model = read_model(cadquery.Assembly(cadquery.Workplane().box(1, 1, 1), color=color))
    assert model.instance_colors[0, :3] == pytest.approx(np.array([0.5, 0.25, 0.75]), abs=2e-6)


def test_wrapper_with_children_is_a_tree():
    """As build123d has it: children, label, color, wrapped."""

    class Node:
        def __init__(self, wrapped, label, children=(), color=None):
            self.wrapped, self.label, self.children, self.color = wrapped, label, children, color

    child = Node(make.box().Moved(make.moved(1)), "child", color=cadquery.Color(0, 1, 0))
    top = Node(make.box().Moved(make.moved(0, 0, 4)), "top", (child,))
    model = read_model(top)
    assert [instance.path for instance in model.instances] == [("top", "child")]
    assert model.instance_placements[0][[3, 7, 11]] == pytest.approx([1, 0, 4])
    assert model.instance_colors[0] == pytest.approx([0, 1, 0, 1])


def test_no_faces_and_foreign_objects():
    with pytest.raises(EmptyError):
        read_model(cadquery.Edge.makeLine((0, 0, 0), (1, 0, 0)))
    with pytest.raises(UsageError):
        shapes.from_shape(object())
