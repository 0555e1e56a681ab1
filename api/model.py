"""Model: a CAD file as exact surfaces, to be looked at and asked with rays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Literal, TypeVar, Unpack

import numpy as np
import numpy.typing as npt

from . import _core
from .camera import Camera
from .contents import Contents
from .frame import Frame
from .hits import Hits, Rays, check_rays, portions_of
from .importer.errors import UsageError
from .measuring import Measured
from .pictures import Look, Words, draw
from .seeds import Seeder
from .views import CAST_MODES, PROJECTIONS, UP_AXES, Background, View, choose, parse_size, parse_view

if TYPE_CHECKING:
    from .tri_mesh import TriMesh
    from .view_mesh import Levels

CastMode = Literal["standard", "reference"]
Mode = Literal["hybrid", "standard", "reference"]
Progress = Callable[[str, float | None], None]
Answer = TypeVar("Answer")

# Rays a cast gives to the core at once; between two such portions Ctrl-C is heard.
_PORTION = {"standard": 1 << 20, "reference": 1 << 10}


class Model(Contents, Measured):
    """A model ready for rays. Made by ``load``; immutable; may be used from several threads."""

    @property
    def _scene(self) -> _core.Scene:
        return self._hierarchy.scene()

    def tessellate(
        self,
        deviation: float | str | None = None,
        *,
        angle: float | None = None,
        view: View | Camera | None = None,
        threads: int = 0,
        progress: Progress | None = None,
    ) -> TriMesh:
        """A watertight mesh of the whole model, no farther from its surfaces than asked for.

        deviation: mm, or a text: "0.05mm", or "0.1%" of the diagonal of the model's bounds, which is the
            default, so that small and large parts look alike.
        angle: radians, the largest turn of the surface along a triangle's side; no limit by default.
        view: a camera (or a view, for the picture of 512 x 512 px that ``render`` makes of it): the mesh is
            as coarse as this picture allows, and covers what is in it. deviation is in pixels then, "0.3px"
            by default. Parts that lie partly beyond the picture may end there, parts beyond it have no
            triangles. Meshes are kept with the model, and used again while they are fine enough.
        threads: 0 for all cores; the mesh is the same for any number. progress: called with "mesh" and a
        fraction. A face that cannot be meshed exactly is named in ``TriMesh.issues``.
        Raises EmptyError when no face can be drawn, UsageError.
        """
        from .tri_mesh import tessellate

        if view is None:
            return tessellate(self, deviation, angle, threads, progress)
        from .view_mesh import tessellate_view

        camera = view if isinstance(view, Camera) else self.camera(view=view)
        return tessellate_view(self, self._levels, deviation, angle, camera, threads, progress)

    @cached_property
    def _levels(self) -> Levels:
        from .view_mesh import Levels

        return Levels()

    @cached_property
    def _seeder(self) -> Seeder:
        return Seeder()

    def camera(
        self,
        size: Sequence[int] | str = (512, 512),
        *,
        view: View = "iso",
        projection: str = "orthographic",
        up: str = "z",
        zoom: float = 1.0,
        beside: Sequence[Model] = (),
    ) -> Camera:
        """The camera of the picture that ``render`` makes of these, enlarged zoom times about its centre.

        beside: other models to fit into the picture too, so that one camera can look at all of them.
        Raises EmptyError when no face can be drawn, UsageError.
        """
        outlines = [model._extent[1] for model in (self, *beside) if len(model._extent[1])]
        outline = np.concatenate(outlines) if beside and outlines else None
        fitted = self._camera(parse_size(size), view, projection, up, outline)
        try:
            return Camera(fitted if zoom == 1.0 else fitted.zoomed(float(zoom)))
        except (_core.ArgumentError, TypeError, ValueError):
            raise UsageError(f"zoom: {zoom!r} is not a number above 0") from None

    def cast(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        tmin: npt.ArrayLike = 0.0,
        tmax: npt.ArrayLike = math.inf,
        mode: CastMode = "standard",
        threads: int = 0,
    ) -> Hits:
        """The nearest hit of each ray in [tmin, tmax]: exact first hits on the trimmed surfaces.

        A feature in its own right: millions of rays a second, where OpenCascade's own intersector does 500
            to 8,000.

        origins, directions: (n, 3) float64, mm, world; one of them may be (3,), for all rays. A direction
            may have any length but 0; t counts in multiples of it. tmin, tmax: numbers or (n,).
        mode: "reference" asks the slow tracer that judges the fast one.
        threads: 0 for all cores; the result is the same for any number. |error of t| <= 1e-9 of the model's
        diagonal. Raises UsageError.
        """
        rays = check_rays(origins, directions, tmin, tmax)
        portions = _asked("cast", self._scene.cast, rays, mode, threads)
        return (
            Hits(*portions[0])
            if len(portions) == 1
            else Hits(*(np.concatenate(p) for p in zip(*portions, strict=True)))
        )

    def count_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        tmin: npt.ArrayLike = 0.0,
        tmax: npt.ArrayLike = math.inf,
        mode: CastMode = "standard",
        threads: int = 0,
    ) -> npt.NDArray[np.int32]:
        """Crossings per ray in [tmin, tmax], (n,) int32: even on closed solids for rays that start outside.

        Arguments and errors as in ``cast``.
        """
        rays = check_rays(origins, directions, tmin, tmax)
        return np.concatenate(_asked("count_hits", self._scene.count_hits, rays, mode, threads))

    def render(
        self,
        size: Sequence[int] | str = (512, 512),
        *,
        view: View | Camera = "iso",
        projection: str = "orthographic",
        up: str = "z",
        samples: int = 4,
        background: Background = "white",
        mode: Mode = "hybrid",
        seeds: str = "auto",
        seed_process: str = "uv",
        aovs: Sequence[str] | str = ("color",),
        orientation: bool = False,
        shadows: bool = False,
        ambient_occlusion: int = 0,
        occlusion_distance: float = 0.1,
        reflections: int = 0,
        threads: int = 0,
        time_limit: float | None = None,
        progress: Progress | None = None,
    ) -> Frame:
        """A picture of the whole model, fitted to the frame.

        size: (width, height) in px. view: "iso", "front", "back", "left", "right", "top", "bottom", or
            (azimuth, elevation) in
            degrees: azimuth 0 is the front, 90 the right side. up: the model's axis that points up, "z",
                "y", "x", "-z", ...; or a camera from ``camera``, which then says size, up and projection,
                too.
        projection: "orthographic" or "perspective" (30 degrees across the shorter side).
        samples: rays per pixel for the colour.
        background: a colour (name, "#rrggbb", 3 or 4 numbers in [0, 1]), two of them for a gradient from top
            to bottom, or "transparent".
        mode: the tracer; every one gives the same picture, to the byte for "hybrid", the fastest, and
            "standard". "reference" is the slow one that judges the others.
        seeds: what draws a coarse mesh first, to tell the hybrid tracer where to look: "osmesa", "egl",
            "embree", "none"; "auto" is whatever is fastest. They never change the picture: where the one that
            is asked for does not work, a warning says so and there are none. seed_process: "uv" or "id", the
            two ways of the paper.
        aovs: any of "color", "depth", "position", "normal", "uv", "face", "instance", "time",
            "seed_id", "seed_uv"; see Frame.
        orientation: tint faces that turn their inner side to the eye.
        shadows: of the two lamps that stand beside the camera. ambient_occlusion: rays per sample, 16 for
            instance, that darken corners into which little light comes, by what they meet within
            occlusion_distance (a fraction of the bounds' diagonal). reflections: bounces, as of polished
            parts. All follow the exact surfaces.
        threads: 0 for all cores; the bytes are the same for any number.
        time_limit: seconds. progress: called with "hierarchy" or "trace" and a fraction or None.
        Raises EmptyError when no face can be drawn, TimeLimitError, UsageError.
        """
        if isinstance(view, Camera):
            camera = view._core
        else:
            camera = self._camera(parse_size(size), view, projection, up)
        look = Look.of(
            aovs=aovs, samples=samples, background=background, mode=mode, seeds=seeds, threads=threads,
            seed_process=seed_process, orientation=orientation, shadows=shadows, reflections=reflections,
            ambient_occlusion=ambient_occlusion, occlusion_distance=occlusion_distance,
        )  # fmt: skip
        return draw(self, camera, look, time_limit, progress)

    def turntable(
        self,
        frames: int = 60,
        size: Sequence[int] | str = (512, 512),
        *,
        view: View = "iso",
        projection: str = "orthographic",
        up: str = "z",
        time_limit: float | None = None,
        progress: Progress | None = None,
        **look: Unpack[Words],
    ) -> Iterator[Frame]:
        """The frames of one full turn, made one by one as they are asked for.

        The camera goes round the upright line through the middle of the bounds, counter-clockwise seen from
        above, from `view` on; all frames have one framing, fitted to the whole turn. look: as in ``render``,
        whose pictures these are. Seeds of a frame are made while the one before it is traced.
        time_limit: seconds for all frames. progress: called with "turn" and a fraction.
        Raises EmptyError when no face can be drawn, TimeLimitError, UsageError.
        """
        from . import turntable

        views = turntable.cameras(
            self, turntable.parse_frames(frames), parse_size(size), view, projection, up
        )
        return turntable.turntable(self, views, Look.of(**look), time_limit, progress)

    def _camera(
        self,
        size: tuple[int, int],
        view: View,
        projection: str,
        up: str,
        outline: npt.NDArray[np.float64] | None = None,
    ) -> _core.Camera:
        """Fitted to the outline, by default the model's."""
        azimuth, elevation = parse_view(view)
        perspective = choose("projection", projection, PROJECTIONS) == "perspective"
        axis = getattr(_core.UpAxis, UP_AXES[choose("up", up.lower().lstrip("+"), UP_AXES)])
        _ = self.bounds  # raises when there is nothing to look at
        points = np.ascontiguousarray(self._extent[1] if outline is None else outline)
        return _core.Camera.fit(
            azimuth, elevation, axis, points, size[0], size[1], perspective, _FOV_DEG, _MARGIN
        )


_FOV_DEG = 30.0
_MARGIN = 0.04


def _asked(name: str, ask: Callable[..., Answer], rays: Rays, mode: str, threads: int) -> list[Answer]:
    """What the core answers to each portion of the rays. Raises UsageError, under the method's name."""
    reference = choose("mode", mode, CAST_MODES) == "reference"
    try:
        return [ask(*part, reference, threads) for part in portions_of(rays, _PORTION[mode])]
    except _core.ArgumentError as error:
        raise UsageError(f"{name}: {error}") from None
