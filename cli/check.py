"""trimray check: each input against itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .fidelity import check_reports, report
from .jobs import data_of, each_input, loading_words
from .progress import Sink

if TYPE_CHECKING:
    from trimray.fidelity.record import Comparison
    from trimray.fidelity.result import Result


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    check_reports(options)
    return report(_results(inputs, options), options)


def _results(inputs: tuple[str, ...], options: dict[str, Any]) -> Iterator[Result]:
    from trimray.fidelity.check import check
    from trimray.fidelity.result import Result, exit_code_of

    def work(source: str, name: str, progress: Sink) -> Comparison:
        return check(
            data_of(source),
            name=name,
            profile=options["profile"],
            progress=progress,
            **loading_words(options),
        )

    for done in each_input(inputs, options, work):
        if done.value is None:
            yield Result(done.name, "check", (), done.error, done.exit_code)
        else:
            yield Result(done.name, "check", (done.value,), "", exit_code_of([done.value]))
