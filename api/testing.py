"""Assertions for tests of whatever makes, converts or reads CAD models.

    from trimray.testing import assert_matches_picture, assert_roundtrip, assert_same_geometry

They take a path, bytes, a cadquery Workplane, Shape or Assembly, a build123d object, an OCP shape or a Model,
raise AssertionError, and work under any test runner. Under pytest, the plugin that comes with trimray gives
them ``--trimray-update`` and ``--trimray-report``.
"""

from .fidelity.asserts import assert_matches_picture, assert_roundtrip, assert_same_geometry

__all__ = ["assert_matches_picture", "assert_roundtrip", "assert_same_geometry"]
