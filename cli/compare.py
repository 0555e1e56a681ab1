"""trimray compare: two models."""

from __future__ import annotations

from typing import Any

from trimray import Error, UsageError

from .fidelity import check_reports, report
from .files import name_of
from .jobs import data_of, loading_words, tell_error
from .progress import progress_of


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    if len(inputs) != 2:
        raise UsageError(f"compare takes two models, A and B, not {len(inputs)}")
    if inputs.count("-") > 1:
        raise UsageError("stdin can be read once only")
    check_reports(options)
    from trimray.fidelity import compare, read
    from trimray.fidelity.result import Result, exit_code_of

    names = [name_of(source) for source in inputs]
    title = " - ".join(names)
    sides = []
    for source, name in zip(inputs, names, strict=True):
        try:
            with progress_of(name, options["progress"], options["quiet"]) as progress:
                side = read(data_of(source), name=name, progress=progress, **loading_words(options))
            if side.failure is not None:
                raise side.failure
        except Error as error:
            text = tell_error(name, error)
            return report([Result(title, "compare", (), text, error.exit_code)], options)
        sides.append(side)
    with progress_of(title, options["progress"], options["quiet"]) as progress:
        compared = compare(
            *sides,
            profile=options["profile"],
            pictures=options["pictures"],
            images=bool(options["html"]),
            size=options["picture_size"],
            progress=progress,
        )
    return report([Result(title, "compare", (compared,), "", exit_code_of([compared]))], options)
