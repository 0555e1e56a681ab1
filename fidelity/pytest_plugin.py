"""The pytest plugin: its options, the running test, and a summary. The assertions are in ``trimray.testing``.

pytest loads it in every suite of an environment that has trimray, so it imports nothing but pytest, and does
next to nothing for a test that does not call the assertions.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from . import running


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("trimray", "CAD models (trimray.testing)")
    group.addoption(
        "--trimray-update",
        action="store_true",
        help="write or renew the golden pictures of assert_matches_picture",
    )
    group.addoption(
        "--trimray-report",
        metavar="DIR",
        help=f"where failures leave their pictures and reports (default: {running.FAILURES})",
    )


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    before = running.enter(partial(_running, item))
    yield
    running.enter(before)


def _running(item: pytest.Item) -> running.Running:
    config = item.config
    chosen = config.getoption("--trimray-report")
    root = config.rootpath
    report = Path(config.invocation_params.dir, chosen) if chosen else root / running.FAILURES
    return running.Running(
        item.nodeid,
        item.path.parent,
        root,
        report,
        chosen=bool(chosen),
        update=bool(config.getoption("--trimray-update")),
        notes=item.user_properties,
    )


_KINDS = {running.PICTURE: "golden pictures", running.FAILURE: "failures"}
_collected: dict[str, list[str]] = {kind: [] for kind in _KINDS}


def pytest_sessionstart() -> None:
    for lines in _collected.values():
        lines.clear()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Under pytest-xdist too, where the reports come from other processes."""
    if report.when == "teardown":
        for key, value in report.user_properties:
            if key in _collected:
                _collected[key].append(str(value))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    for key, lines in _collected.items():
        if lines:
            terminalreporter.section(f"trimray: {_KINDS[key]}", sep="-")
            for line in sorted(set(lines)):
                terminalreporter.write_line(line)
