"""trimray compare: two models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from trimray import Error, UsageError

from .fidelity import check_reports, report
from .files import name_of
from .jobs import data_of, limited_progress, loading_words, tell_error
from .limit import Limited

if TYPE_CHECKING:
    from trimray.fidelity.record import Comparison


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    if len(inputs) != 2:
        raise UsageError(f"compare takes two models, A and B, not {len(inputs)}")
    if inputs.count("-") > 1:
        raise UsageError("stdin can be read once only")
    check_reports(options)
    from trimray.fidelity.result import Result, exit_code_of

    names = [name_of(source) for source in inputs]
    title = " - ".join(names)
    try:
        with limited_progress(title, options) as progress:
            compared = _compared(inputs, names, options, progress)
    except Error as error:
        named = next((name for name in names if name in str(error)), title)
        text = tell_error(named, error)
        return report([Result(title, "compare", (), text, error.exit_code)], options)
    return report([Result(title, "compare", (compared,), "", exit_code_of([compared]))], options)


def _compared(
    inputs: tuple[str, ...], names: list[str], options: dict[str, Any], progress: Limited
) -> Comparison:
    """Raises what reading raises."""
    from trimray.fidelity import compare, read

    sides = []
    for source, name in zip(inputs, names, strict=True):
        words = loading_words(options) | {"time_limit": progress.left()}
        side = read(data_of(source), name=name, progress=progress, **words)
        if side.failure is not None:
            raise side.failure
        sides.append(side)
    return compare(
        *sides,
        profile=options["profile"],
        pictures=options["pictures"],
        images=bool(options["html"]),
        size=options["picture_size"],
        progress=progress,
    )
