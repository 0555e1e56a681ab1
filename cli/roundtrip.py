"""trimray roundtrip: each input against what is left of it when it is written and read back."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from trimray import UsageError

from .fidelity import check_reports, report
from .files import check_target, stem
from .jobs import data_of, each_input, loading_words
from .progress import Sink

if TYPE_CHECKING:
    from trimray.fidelity.result import Result
    from trimray.fidelity.roundtrip import RoundTrip


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    check_reports(options)
    targets = _targets(inputs, options["keep"])
    return report(_results(inputs, targets, options), options)


def _results(
    inputs: tuple[str, ...], targets: dict[str, str | None], options: dict[str, Any]
) -> Iterator[Result]:
    from trimray.fidelity.result import Result
    from trimray.fidelity.roundtrip import roundtrip

    def work(source: str, name: str, progress: Sink) -> RoundTrip:
        return roundtrip(
            data_of(source),
            name=name,
            keep=targets[source],
            images=bool(options["html"]),
            size=options["picture_size"],
            progress=progress,
            **{key: options[key] for key in ("via", "schema", "writer", "twice", "profile", "pictures")},
            **loading_words(options),
        )

    for done in each_input(inputs, options, work):
        if done.value is None:
            yield Result(done.name, "roundtrip", (), done.error, done.exit_code)
        else:
            yield Result(done.name, "roundtrip", done.value.comparisons, "", done.value.exit_code)


def _targets(inputs: tuple[str, ...], keep: str | None) -> dict[str, str | None]:
    """Where the written file of each input goes. Raises UsageError, OutputError."""
    if keep is None:
        return dict.fromkeys(inputs)
    targets: dict[str, str | None] = {source: keep.replace("{name}", stem(source)) for source in inputs}
    if len({os.path.realpath(str(target)) for target in targets.values()}) < len(inputs):
        raise UsageError("--keep: several inputs would be written to one file; put {name} into it")
    for target in targets.values():
        check_target(str(target))
        if any(
            source != "-" and os.path.realpath(source) == os.path.realpath(str(target)) for source in inputs
        ):
            raise UsageError(f"--keep: {target} would overwrite an input")
    return targets
