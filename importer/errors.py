"""The errors of the product: one tree, each with the exit code of the command line.

    Error                     70  internal
    |-- UsageError             2  a wrong option or argument
    |-- InputError             3  unreadable: missing, no permission, a directory, empty, truncated, not a
    |   |                         model, or the reader crashed on it
    |   `-- EmptyError         3  readable, but there is no face in it
    |-- OutputError            4  the result could not be written
    `-- LimitError             5  a limit set by the caller was reached
        |-- TimeLimitError
        `-- MemoryLimitError

The text of an error is one line: file, entity or face, cause.
"""


class Error(Exception):
    """Root of the tree. ``detail`` may hold more lines for a bug report; the text itself is one line.
    ``peak_memory``: bytes that a reading process was seen to hold, 0 where nobody looked."""

    exit_code = 70
    peak_memory = 0

    def __init__(self, message: str, *, detail: str = "") -> None:
        super().__init__(" ".join(message.split()))
        self.detail = detail


class UsageError(Error):
    """A wrong option or argument."""

    exit_code = 2


class InputError(Error):
    """The input cannot be read."""

    exit_code = 3


class EmptyError(InputError):
    """The input was read, but holds no face. ``report`` (a dict) says what it does hold."""

    def __init__(self, message: str, *, detail: str = "", report: dict[str, object] | None = None) -> None:
        super().__init__(message, detail=detail)
        self.report: dict[str, object] = report or {}


class OutputError(Error):
    """The result could not be written."""

    exit_code = 4


class LimitError(Error):
    """A limit set by the caller was reached."""

    exit_code = 5


class TimeLimitError(LimitError):
    """Reading took longer than ``time_limit``."""


class MemoryLimitError(LimitError):
    """Reading needed more memory than ``memory_limit`` (or than the machine has)."""
