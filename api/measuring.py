"""What a Model can be measured by: the part of Model that needs its store alone."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy.typing as npt

from ._core import PointIndex, Store, sample_edges, sample_faces

if TYPE_CHECKING:
    from .distances import Distances, EdgeSamples, Samples
    from .mass_properties import MassProperties


class Measured:
    """Distances from points to a model, points on it, and its mass properties."""

    _core: Store

    @cached_property
    def _point_index(self) -> PointIndex:
        return PointIndex(self._core)

    def distance(self, points: npt.ArrayLike, *, edges: bool = False, threads: int = 0) -> Distances:
        """The exact distance of each point from the model, to 1e-12 of its diagonal.

        points: (n, 3) or (3,) float64, mm, world.
        edges: from the edges of the faces alone.
        threads: 0 for all cores; the result is the same for any number. Raises UsageError.

        Faces that cannot be drawn (``report``) have no points to be near to.
        """
        from .distances import distances

        return distances(self._point_index, points, edges, threads)

    def sample(self, count: int = 16, *, seed: int = 0, threads: int = 0) -> Samples:
        """count points of every face of every instance, evenly by area; the same ones for the same seed.

        Faces that cannot be drawn have none, faces that are almost empty may have fewer. Raises UsageError.
        """
        from .distances import Samples, check_count

        check_count(count, seed)
        return Samples(*sample_faces(self._core, int(count), int(seed), threads))

    def sample_edges(self, count: int = 16, *, seed: int = 0, threads: int = 0) -> EdgeSamples:
        """count points of every edge of every instance, spread along it, as in ``sample``."""
        from .distances import EdgeSamples, check_count

        check_count(count, seed)
        return EdgeSamples(*sample_edges(self._core, int(count), int(seed), threads))

    def mass_properties(self, threads: int = 0) -> MassProperties:
        """Area, volume, centroid and inertia of the exact surfaces, each with what it may be off by.

        threads: 0 for all cores; the result is the same, bit for bit, for any number.
        Faces that cannot be drawn are named, and count nothing.
        """
        from .mass_properties import mass_properties

        return mass_properties(self._core, threads)
