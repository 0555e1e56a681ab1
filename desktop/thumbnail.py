"""trimray-thumbnailer -s SIZE IN OUT: one file's picture, for a file manager that waits.

The picture is made in a child process, so that neither a crash nor a hang nor hunger is more than one line on
stderr and an exit code. It needs no home, no cache and no configuration. Nothing heavy is imported here.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass

from trimray.importer.errors import Error, InputError, OutputError, TimeLimitError, UsageError

from .uris import path_of

USAGE = "usage: trimray-thumbnailer [-s SIZE] [--time-limit SECONDS] [--memory-limit BYTES] IN OUT"
MAX_SIZE = 4096
# The child keeps to the time limit by itself; it is killed when it is so much over it.
_GRACE_SECONDS = 3.0
# To write a file of some kilobytes.
_WRITE_SECONDS = 20.0
# What file managers send when they lose patience.
_IMPATIENT = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
# A line longer than this no sane child sends.
_MAX_ANSWER = 1 << 16


@dataclass(frozen=True)
class Request:
    """size: px, of the square picture. time_limit: s, until the picture is there. memory_limit: bytes, of the
    process that reads the file and of the one that draws it, each."""

    source: str
    target: str
    size: int = 128
    time_limit: float = 20.0
    memory_limit: int = 2 << 30


def main(arguments: list[str] | None = None) -> int:
    """Returns the exit code. arguments: without the program's name; by default the process's own."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        if arguments in (["-h"], ["--help"]):
            print(USAGE)
            return 0
        if arguments == ["--version"]:
            from trimray import __version__

            print(f"trimray-thumbnailer {__version__}")
            return 0
        request = parse(arguments)
        for number in _IMPATIENT - {signal.SIGINT}:
            signal.signal(number, _end_of_patience)
        code, text = supervise(request)
        if code:
            _say(text)
        return code
    except Error as error:
        _say(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        _say("interrupted")
        return 130
    except Exception as error:
        _say(f"internal error: {type(error).__name__}: {error}")
        return Error.exit_code


def _end_of_patience(number: int, frame: object) -> None:
    """Unwinds, so that the child and its files go, too."""
    raise SystemExit(128 + number)


def parse(arguments: list[str]) -> Request:
    """Raises UsageError, InputError for a URI that is no file's."""
    paths: list[str] = []
    values: dict[str, str] = {}
    names = {"-s": "size", "--size": "size", "--time-limit": "time_limit", "--memory-limit": "memory_limit"}
    rest = iter(arguments)
    for word in rest:
        flag, equals, value = word.partition("=")
        if word == "--":
            paths += rest
        elif flag in names and (equals or flag == word):
            values[names[flag]] = value if equals else next(rest, "")
        elif word.startswith("-s") and word[2:].isdigit():
            values["size"] = word[2:]
        elif word.startswith("-"):
            raise UsageError(f"unknown option {word}; {USAGE}")
        else:
            paths.append(word)
    if len(paths) != 2 or not all(paths):
        raise UsageError(USAGE)
    try:
        source = path_of(paths[0])
    except ValueError as error:
        raise InputError(f"{paths[0]}: {error}") from None
    return Request(
        source,
        paths[1],
        _size(values.get("size", str(Request.size))),
        _positive("--time-limit", values.get("time_limit", str(Request.time_limit)), {"s": 1.0}),
        int(_positive("--memory-limit", values.get("memory_limit", str(Request.memory_limit)), _BYTES)),
    )


_BYTES = {"k": 2.0**10, "m": 2.0**20, "g": 2.0**30}


def _size(text: str) -> int:
    if text.isascii() and text.isdigit() and 1 <= int(text[:9]) <= MAX_SIZE:
        return int(text)
    raise UsageError(f"-s: '{text}' is not a number of pixels from 1 to {MAX_SIZE}")


def _positive(flag: str, text: str, units: dict[str, float]) -> float:
    factor = units.get(text[-1:].lower(), 1.0)
    try:
        value = float(text.rstrip("".join(units) + "".join(units).upper())) * factor
    except ValueError:
        value = -1.0
    if 0.0 < value < float("inf"):
        return value
    raise UsageError(f"{flag}: '{text}' is not a number above 0")


def supervise(request: Request) -> tuple[int, str]:
    """Draws in a child process. Returns the exit code and one line, "" for 0. The child is dead then, and
    nothing of its scratch files is left."""
    _fill_standard_streams()
    scratch = _scratch(request)
    try:
        receive, send = os.pipe()
        parent = os.getpid()
        # An end of patience amid this would leave the child without anyone who ends it.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, _IMPATIENT)
        child = os.fork()
        if child == 0:
            os.close(receive)
            _child(request, send, scratch, parent, mask)
        try:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            os.close(send)
            return _watch(request, child, receive)
        finally:
            os.close(receive)
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            with contextlib.suppress(ChildProcessError):
                os.waitpid(child, 0)
    finally:
        _remove(scratch)


def _fill_standard_streams() -> None:
    """Where the caller closed them, the pipe below would take their place, and the child mute it."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(descriptor)


def _scratch(request: Request) -> str:
    """A folder for temporary files, beside the picture where there is no other place: that one must be
    writable anyhow. Raises OutputError."""
    reason = "no folder"
    for folder in (os.environ.get("TMPDIR"), "/tmp", os.path.dirname(request.target) or "."):
        path = os.path.join(folder or "/tmp", f".trimray-{os.urandom(8).hex()}")
        try:
            os.mkdir(path, 0o700)
            return path
        except OSError as error:
            reason = error.strerror or str(error)
    raise OutputError(f"{request.target}: not written: {reason}")


def _remove(folder: str) -> None:
    try:
        os.rmdir(folder)
    except OSError:
        import shutil

        shutil.rmtree(folder, ignore_errors=True)


def _child(request: Request, send: int, scratch: str, parent: int, mask: Iterable[int]) -> None:
    """Never returns. mask: of blocked signals."""
    code = Error.exit_code
    try:
        for number in _IMPATIENT:
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        os.environ["TMPDIR"] = scratch
        os.environ["OPENBLAS_NUM_THREADS"] = "1"  # NumPy would start a thread a core
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        from .drawing import draw

        draw(request, send, parent)
        code = 0
    finally:
        os._exit(code)


def _watch(request: Request, child: int, pipe: int) -> tuple[int, str]:
    """Until the child tells of its end, is dead, or too late. It says "w" when it begins to write."""
    deadline = time.monotonic() + request.time_limit + _GRACE_SECONDS
    name = os.path.basename(request.source) or request.source
    answer = b""
    while not answer.endswith(b"\n") and len(answer) < _MAX_ANSWER:
        if not select.select([pipe], [], [], max(0.0, deadline - time.monotonic()))[0]:
            return TimeLimitError.exit_code, f"{name}: no picture within {request.time_limit:g} s"
        data = os.read(pipe, 4096)
        if not data:
            return Error.exit_code, f"{name}: drawing it failed: {_end(child)}"
        if data.startswith(b"w") and not answer:
            deadline, data = time.monotonic() + _WRITE_SECONDS, data[1:]
        answer += data
    try:
        code, text = json.loads(answer)
        return int(code), str(text)
    except ValueError:
        return Error.exit_code, f"{name}: drawing it failed: the drawing process answered nonsense"


def _end(child: int) -> str:
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code < 0:
        return f"the drawing process was ended by {signal.Signals(-code).name}"
    return f"the drawing process ended early (exit {code})"


def _say(text: str) -> None:
    with contextlib.suppress(OSError):
        line = " ".join(f"trimray-thumbnailer: {text}".split())
        print(line.encode(errors="backslashreplace").decode(), file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
