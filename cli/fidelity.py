"""What check, roundtrip and compare have in common: their results as text, JSON, JUnit XML and a page."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from trimray import UsageError

from .files import check_target
from .jobs import exit_code, write
from .output import write_stdout

if TYPE_CHECKING:
    from trimray.fidelity.result import Result


def check_reports(options: dict[str, Any]) -> None:
    """Can all be written that is asked for? Raises UsageError, OutputError."""
    from trimray.web_page import check_page

    wanted = [options[name] for name in ("junit", "html") if options[name]]
    if wanted.count("-") + options["json"] > 1:
        raise UsageError("only one of --json, --junit and --html can go to stdout")
    for target in wanted:
        if target != "-":
            check_target(target)
    if options["html"] not in (None, "-"):
        check_page(options["html"], "page")
    if len(set(wanted)) < len(wanted):
        raise UsageError("--junit and --html would both be written to the same file")


def report(results: Iterable[Result], options: dict[str, Any]) -> int:
    """Tells and writes what was found out, of each input as soon as it is known; returns the exit code."""
    from trimray.fidelity.report_text import to_text

    spoken = not options["json"] and "-" not in (options["junit"], options["html"])
    known: list[Result] = []
    for result in results:
        known.append(result)
        if not spoken or not result.comparisons:  # errors are on stderr already
            continue
        if not options["quiet"] or result.verdict != "complete":
            write_stdout(to_text([result], everything=bool(options["verbose"])))
    if options["json"]:
        from trimray.fidelity.report_json import to_json

        write_stdout(to_json(known))
    if options["junit"]:
        from trimray.fidelity.report_junit import to_junit

        write(options["junit"], to_junit(known))
    if options["html"]:
        from trimray.fidelity.report_html import to_html

        write(options["html"], to_html(known))
    return exit_code([result.exit_code for result in known])
