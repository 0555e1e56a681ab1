"""trimray render: each input, or all of them together, to a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from trimray.formats import check_fit
from trimray.views import parse_aovs, parse_background

from .files import Job, plan
from .jobs import drawing_words, run_jobs, time_left, write
from .progress import Sink

if TYPE_CHECKING:
    from trimray import Model


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    jobs = plan(inputs, options["output"], options["format"])
    aovs = parse_aovs(",".join(options["aov"]))
    opaque = all(color[3] >= 1.0 for color in parse_background(options["background"]))
    for job in jobs:
        check_fit(job.format, aovs, opaque)

    def draw(model: Model, job: Job, progress: Sink, start: float) -> int:
        _draw(model, job, aovs, options, progress, start)
        return 0

    return run_jobs(jobs, options, draw, what="picture", trace=True)


def _draw(
    model: Model, job: Job, aovs: tuple[str, ...], options: dict[str, Any], progress: Sink, start: float
) -> None:
    """start: of the input's work, on the clock of perf_counter."""
    from trimray.image_io import encode, preload

    preload()
    left = time_left(job.name, options["time_limit"], start)
    frame = model.render(
        options["size"],
        view=options["view"],
        projection=options["projection"],
        up=options["up"],
        aovs=aovs,
        **drawing_words(options),
        time_limit=left,
        progress=progress,
    )
    progress("write", None)
    write(job.target, encode(frame, job.format))
