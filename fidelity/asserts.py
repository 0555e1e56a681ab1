"""The assertions of ``trimray.testing``. What they say on failure is made in ``failures`` and ``golden``.

Nothing heavy is imported before the first call. pytest hides the frames in here from its tracebacks.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .running import here

if TYPE_CHECKING:
    from trimray.views import View

    from .roundtrip import Via

# What is the same about the same geometry, whatever it is called, coloured and grouped like.
GEOMETRY = ("topology", "mass", "geometry", "pictures")


def assert_roundtrip(
    path_or_shape: Any,
    via: Via = "step",
    profile: str = "default",
    *,
    ignore: str | Sequence[str] = (),
    twice: bool = False,
    **options: Any,
) -> None:
    """The model loses nothing when it is written, and read back from the written bytes.

    path_or_shape: a path; a cadquery Workplane, Shape or Assembly; a build123d object; an OCP shape; a Model.
        A relative path that does not exist is looked for beside the test file, too.
    via: "step", "iges", "brep", or "store": written as STEP from trimray's own surfaces.
    profile: of tolerances: "strict", "default", "lenient".
    ignore: what may differ: names of findings as failures show them, such as "colour" or "*name*", or of
        sections: "structure", "topology", "mass", "geometry", "pictures".
    twice: write what was read once more, and compare that, too.
    options: of ``trimray.fidelity.roundtrip``, such as schema, writer, heal, views, size.
    Raises AssertionError, UsageError.
    """
    __tracebackhide__ = True
    from .failures import check_comparisons
    from .roundtrip import roundtrip

    running = here()
    source = running.model(path_or_shape)
    message = check_comparisons(
        running,
        "roundtrip",
        lambda colors: (
            roundtrip(
                source, via=via, profile=profile, twice=twice, **{"colors": colors, **options}
            ).comparisons
        ),
        ignore=ignore,
    )
    if message:
        raise AssertionError(message)


def assert_same_geometry(
    a: Any,
    b: Any,
    profile: str = "default",
    *,
    sections: Sequence[str] = GEOMETRY,
    ignore: str | Sequence[str] = (),
    **options: Any,
) -> None:
    """Two models have the same faces in the same places.

    Names, colours, layers and the assembly tree do not count, unless sections has "structure", too.

    a, b, profile, ignore: as of ``assert_roundtrip``. sections: those that count.
    options: of ``trimray.compare``, such as heal, views, size, points.
    Raises AssertionError, UsageError.
    """
    __tracebackhide__ = True
    from .comparing import compare
    from .failures import check_comparisons

    running = here()
    models = running.model(a), running.model(b)
    message = check_comparisons(
        running,
        "compare",
        lambda colors: [compare(*models, profile=profile, **{"colors": colors, **options})],
        sections=sections,
        ignore=ignore,
    )
    if message:
        raise AssertionError(message)


def assert_matches_picture(
    path_or_shape: Any,
    golden: str | os.PathLike[str],
    view: View = "iso",
    size: Sequence[int] | str = (512, 512),
    *,
    tolerance: int = 0,
    pixels: int = 0,
    **look: Any,
) -> None:
    """The model looks as it does in a golden picture, which ``pytest --trimray-update`` makes and renews.

    Pictures are the same on every machine and for every number of threads, so nothing may differ by default.
    That holds for one version of trimray and of OpenCascade.

    path_or_shape: as of ``assert_roundtrip``. golden: path of a PNG, from the test file's folder.
    view, size (width, height) px, look: as of ``Model.render``.
    tolerance: by how many of 255 steps a pixel may be off. pixels: how many may be off by more.
    Raises AssertionError, UsageError.
    """
    __tracebackhide__ = True
    from .golden import check_picture

    running = here()
    message = check_picture(
        running, running.model(path_or_shape), golden, tolerance, pixels, {"size": size, "view": view, **look}
    )
    if message:
        raise AssertionError(message)
