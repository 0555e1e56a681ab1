"""trimray turntable: each input, or all of them together, turning once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from trimray.formats import check_sequence, numbered
from trimray.views import parse_aovs, parse_background

from .files import SEQUENCE, Job, plan
from .jobs import drawing_words, run_jobs, time_left, write
from .progress import Sink

if TYPE_CHECKING:
    from trimray import Frame, Model


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    jobs = plan(inputs, options["output"], options["sequence_format"], SEQUENCE)
    aovs = parse_aovs(",".join(options["aov"]))
    opaque = all(color[3] >= 1.0 for color in parse_background(options["background"]))
    for job in jobs:
        check_sequence(job.format, aovs, opaque)

    def draw(model: Model, job: Job, progress: Sink, start: float) -> int:
        paths = numbered(job.target)
        frames = _frames(model, job, aovs, options, progress, start)
        if paths is not None:
            from trimray.image_io import encode

            for number, frame in enumerate(frames, 1):
                write(paths(number), encode(frame, job.format))
        else:
            from trimray.animation import encode_animation

            write(job.target, encode_animation(frames, job.format, options["fps"]))
        return 0

    return run_jobs(jobs, options, draw, what="pictures", trace=True)


def _frames(
    model: Model, job: Job, aovs: tuple[str, ...], options: dict[str, Any], progress: Sink, start: float
) -> Iterator[Frame]:
    """start: of the input's work, on the clock of perf_counter."""
    left = time_left(job.name, options["time_limit"], start)
    return model.turntable(
        options["frames"],
        options["size"],
        view=options["view"],
        projection=options["projection"],
        up=options["up"],
        time_limit=left,
        progress=progress,
        aovs=aovs,
        **drawing_words(options),
    )
