"""How a batch goes on: a bar on a terminal, plain or JSON lines; and one line for each file that is not
complete."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

from trimray.batch import Listener

from .output import colored, emit, printable, say, shown_path

if TYPE_CHECKING:
    from trimray.batch import Outcome

_EVERY_SECONDS = 1.0


class BatchProgress(Listener):
    """mode: auto, none, plain or json."""

    def __init__(self, mode: str, quiet: bool, verbose: int) -> None:
        if mode == "auto":
            mode = "bar" if sys.stderr.isatty() and not quiet else "none"
        self._mode, self._quiet, self._verbose = mode, quiet, verbose
        self.total = self.done = self.failed = 0
        self._drawn = 0
        self._start = self._last = time.monotonic()
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> BatchProgress:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def begin(self, total: int) -> None:
        self.total = total
        self._start = time.monotonic()
        if self._mode == "bar":
            self._show_bar()

    def skipped(self, outcome: Outcome) -> None:
        self.done += 1
        self.failed += outcome.status == "failed"
        if self._verbose > 1:
            self._say_file(outcome, f"unchanged, {outcome.status}{_because(outcome)}")
        self._tell()

    def drawn(self, outcome: Outcome) -> None:
        self.done += 1
        self._drawn += 1
        failed = outcome.status == "failed"
        self.failed += failed
        if failed or (outcome.status != "complete" and not self._quiet):
            self._say_file(outcome, f"{outcome.status}{_because(outcome)}", error=failed)
        elif self._verbose and not self._quiet:
            self._say_file(outcome, f"{outcome.seconds:.2f} s: {shown_path(outcome.target)}")
        self._tell()

    def note(self, text: str) -> None:
        if self._verbose:
            self._say(printable(text))

    def _say_file(self, outcome: Outcome, text: str, error: bool = False) -> None:
        self._say(
            f"{shown_path(outcome.path)}: {text}",
            error,
            event="file",
            input=outcome.path,
            status=outcome.status,
            reason=outcome.reason,
            seconds=round(outcome.seconds, 3),
        )

    def _say(self, text: str, error: bool = False, **event: Any) -> None:
        """Above the bar, where there is one."""
        if self._bar is None:
            say(text, error=error, **event)
        else:
            from rich.text import Text

            head = ("trimray:", "bold red" if error else "bold yellow")
            self._bar.console.print(Text.assemble(head, " ", text), soft_wrap=True)

    def _tell(self) -> None:
        if self._bar is not None:
            self._bar.update(
                self._task,
                completed=self.done,
                rate=self._rate_text(),
                left=self._left_text(),
                failed=self.failed,
            )
            return
        now = time.monotonic()
        if self._mode not in ("plain", "json") or (
            now - self._last < _EVERY_SECONDS and self.done < self.total
        ):
            return
        self._last = now
        if self._mode == "json":
            rate, left = self._rate(), self._left()
            emit(
                "progress",
                done=self.done,
                total=self.total,
                failed=self.failed,
                files_per_second=None if rate is None else round(rate, 3),
                seconds_left=None if left is None else round(left, 1),
            )
        else:
            say(
                f"{self.done} of {self.total} files, {self.failed} failed, {self._rate_text()}, "
                f"{self._left_text()} left"
            )

    def _rate(self) -> float | None:
        """Files drawn a second."""
        passed = time.monotonic() - self._start
        return self._drawn / passed if self._drawn and passed > 0 else None

    def _left(self) -> float | None:
        """Seconds; the largest files come first, so that it is rather less."""
        rate = self._rate()
        if self.done >= self.total:
            return 0.0
        return None if rate is None else (self.total - self.done) / rate

    def _rate_text(self) -> str:
        rate = self._rate()
        return "-" if rate is None else f"{rate:.1f} a second"

    def _left_text(self) -> str:
        left = self._left()
        if left is None:
            return "-"
        seconds = round(left)
        if seconds < 60:
            return f"{seconds} s"
        minutes, hours = seconds // 60, seconds // 3600
        return f"{minutes} min" if minutes < 120 else f"{hours} h {minutes % 60} min"

    def _show_bar(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        console = Console(stderr=True, no_color=not colored(sys.stderr), highlight=False)
        columns = (
            BarColumn(),
            TextColumn("{task.completed} of {task.total}"),
            TextColumn("{task.fields[rate]}"),
            TextColumn("{task.fields[left]} left"),
            TextColumn("{task.fields[failed]} failed"),
        )
        self._bar = Progress(*columns, console=console, transient=True)
        self._task = self._bar.add_task("", total=self.total, rate="-", left="-", failed=0)
        self._bar.start()


def _because(outcome: Outcome) -> str:
    return f": {printable(outcome.reason)}" if outcome.reason else ""
