"""Someone else's converter: a command that reads one file and writes another."""

from __future__ import annotations

import contextlib
import os
import select
import shlex
import signal
import subprocess
import tempfile
from typing import IO

from trimray import OutputError, TimeLimitError, UsageError
from trimray.web_page import shown

# Bytes of what the command said that are looked at, from the end.
_TAIL = 4096
# Characters of its last line that stand in a message.
_LONGEST_LINE = 200


def check_writer(command: str) -> list[str]:
    """The words of the command. Raises UsageError, where {in} or {out} is missing too."""
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise UsageError(f"writer: '{command}': {error}") from None
    for field in ("{in}", "{out}"):
        if not any(field in word for word in words):
            raise UsageError(f"writer: '{command}' has no {field}")
    return words


def run_writer(command: str, source: str, target: str, *, time_limit: float | None = None) -> None:
    """Runs the command, without a shell, with {in} and {out} replaced by both paths.

    It runs in a process group of its own, all of which ends with it or with the time limit (s). Raises
    OutputError when it fails or writes nothing, TimeLimitError, UsageError.
    """
    words = [word.replace("{in}", source).replace("{out}", target) for word in check_writer(command)]
    name = shown(os.path.basename(words[0]))
    with tempfile.TemporaryFile() as said:
        try:
            process = subprocess.Popen(
                words, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True
            )
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise OutputError(f"the writer '{name}' cannot be started: {reason}") from None
        status = _wait(process, time_limit)
        if status is None:
            raise TimeLimitError(f"the writer '{name}' did not end within {time_limit or 0:g} s")
        if status != 0:
            how = f"by {signal.Signals(-status).name}" if status < 0 else f"with exit status {status}"
            raise OutputError(f"the writer '{name}' ended {how}{_last_line(said)}")
        if not os.path.isfile(target):
            raise OutputError(f"the writer '{name}' wrote no file{_last_line(said)}")
        if os.path.getsize(target) == 0:
            raise OutputError(f"the writer '{name}' wrote an empty file{_last_line(said)}")


def _wait(process: subprocess.Popen[bytes], limit: float | None) -> int | None:
    """Its status, None where it did not end in time. Whatever it has left running ends with it: until it is
    waited for, the number of its group is no one else's."""
    ended: list[int] = []
    watched = os.pidfd_open(process.pid)
    try:
        ended, _, _ = select.select([watched], [], [], limit)
    finally:
        os.close(watched)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        status = process.wait()
    return status if ended else None


def _last_line(said: IO[bytes]) -> str:
    said.seek(0, os.SEEK_END)
    said.seek(max(0, said.tell() - _TAIL))
    lines = [line.strip() for line in said.read().decode(errors="replace").splitlines() if line.strip()]
    return f": {shown(lines[-1])[:_LONGEST_LINE]}" if lines else ""
