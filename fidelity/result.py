"""What one command found out about one input; what all reports are made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from .record import Comparison, Finding, Verdict

Command = Literal["check", "roundtrip", "compare"]
VERDICTS: tuple[Verdict, ...] = ("complete", "changed", "partial", "empty", "failed")  # from good to bad

DIFFERENT = 7  # exit code


@dataclass(frozen=True)
class Result:
    """input: what messages call it. comparisons: in the order in which they were made; none where the input
    could not be read, and ``error`` says why. exit_code: as of the command line, for this input alone."""

    input: str
    command: Command
    comparisons: tuple[Comparison, ...] = ()
    error: str = ""
    exit_code: int = 0

    @property
    def verdict(self) -> Verdict:
        """The worst one."""
        if self.error:
            return "failed"
        return max((c.verdict for c in self.comparisons), key=VERDICTS.index, default="complete")

    @property
    def values(self) -> int:
        """Compared ones."""
        return sum(len(c.findings) for c in self.comparisons)

    def differences(self) -> tuple[Finding, ...]:
        return tuple(finding for comparison in self.comparisons for finding in comparison.differences())


def exit_code_of(comparisons: Sequence[Comparison]) -> int:
    """0, or 7 where one of them is not complete."""
    return 0 if all(c.verdict == "complete" for c in comparisons) else DIFFERENT
