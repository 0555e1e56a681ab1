"""The reading child as a copy of this process: no new interpreter, no second import of OpenCascade."""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import resource
import signal
import subprocess
import time
import warnings
from pathlib import Path


class Forked:
    """As much of subprocess.Popen as process.py needs. Its process must have no other parent."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self.peak_memory = 0  # bytes resident at most; known once it has been waited for
        self._code: int | None = None

    def kill(self) -> None:
        """Of no effect on one that has been waited for."""
        if self._code is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)

    def wait(self, timeout: float | None = None) -> int:
        """Its exit code; less than 0: the signal that ended it. Raises subprocess.TimeoutExpired."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while self._code is None:
            pid, status = self._waitpid(0 if deadline is None else os.WNOHANG)
            if pid:
                self._code = os.waitstatus_to_exitcode(status)
            elif deadline is not None and time.monotonic() >= deadline:
                raise subprocess.TimeoutExpired("the reading process", timeout or 0.0)
            else:
                time.sleep(0.002)
        return self._code

    def _waitpid(self, options: int) -> tuple[int, int]:
        try:
            pid, status, usage = os.wait4(self.pid, options)
        except ChildProcessError:  # somebody else took it, or SIGCHLD is ignored
            return self.pid, 0
        self.peak_memory = usage.ru_maxrss * 1024
        return pid, status


def fork_child(module: str, argument: str, pipe: int) -> Forked:
    """A child that runs ``module.main(argument)`` and ends. pipe: the one descriptor that it keeps.

    To be called while no other thread of this process is at work: the child has none of them, but whatever
    they held stays locked in it. Raises OSError.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # idle threads, such as the core's, do no harm
        pid = os.fork()
    if pid:
        return Forked(pid)
    try:
        _become_child(pipe)
        inherited = json.dumps({**json.loads(argument), "inherited": data_bytes()})
        importlib.import_module(module).main(inherited)
    finally:
        os._exit(70)  # whatever happened: nothing of the parent's code may run here, its atexit least of all


def _become_child(pipe: int) -> None:
    """Leaves the parent's session, handlers and files."""
    gc.freeze()  # what is inherited is never collected: that would copy its pages
    os.setsid()  # Ctrl-C reaches the caller, who kills the child
    signal.set_wakeup_fd(-1)
    for number in signal.valid_signals():
        # SIGTERM is sent to all processes of a job: the caller decides here too, from the first moment on.
        handler = signal.SIG_IGN if number == signal.SIGTERM else signal.SIG_DFL
        if signal.getsignal(number) not in (handler, None):
            with contextlib.suppress(OSError, ValueError):
                signal.signal(number, handler)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    os.closerange(3, pipe)
    os.closerange(pipe + 1, os.sysconf("SC_OPEN_MAX"))


def data_bytes() -> int:
    """What RLIMIT_DATA counts of this process now; 0 where it cannot be told."""
    return _status_bytes("VmData:")


def peak_bytes() -> int:
    """Resident in this process at most; what the kernel counts of usage may also be of the program that
    started it."""
    return _status_bytes("VmHWM:") or resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _status_bytes(name: str) -> int:
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith(name):
                return int(line.split()[1]) * 1024
    except (OSError, IndexError, ValueError):
        pass
    return 0
