"""A process that has imported everything and forks workers on request, in milliseconds each.

It has one thread and does nothing else, so that forking it is safe whatever the caller's threads do, and
the caller's ``__main__`` is never imported again. It ends as soon as the caller's end of its socket is
closed, also by the caller's death; the kernel then kills its workers (PR_SET_PDEATHSIG), and they their
readers.

Messages are JSON, one a packet. To the server: {"fork": n} with the worker's socket attached, {"kill": pid}.
From it: {"ready": pid}, {"forked": pid, "request": n}, {"refused": reason, "request": n},
{"ended": pid, "code": n}.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import pickle
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from multiprocessing.connection import wait
from typing import Any

from trimray import Error

_PACKET = 1 << 16
_START_SECONDS = 120.0
_END_SECONDS = 5.0
_BOOTSTRAP = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from trimray.batch import fork_server
fork_server.serve(int(sys.argv[2]), sys.argv[3])
"""


class ForkServer:
    """The caller's side. For one user at a time, from one thread."""

    def __init__(self) -> None:
        """Starts it; it answers about a second later. Raises Error."""
        self.owner = os.getpid()
        self.folder = tempfile.mkdtemp(prefix="trimray-batch-")
        self.socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        command = [sys.executable, "-c", _BOOTSTRAP, json.dumps(sys.path), str(theirs.fileno()), self.folder]
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                start_new_session=True,  # Ctrl-C reaches the caller alone
                env={**os.environ, **_environment()},
            )
        except OSError as error:
            self.socket.close()
            shutil.rmtree(self.folder, ignore_errors=True)
            raise Error(f"cannot start the server of workers: {error}") from None
        finally:
            theirs.close()
        self._requests = 0
        if not self._ready():
            self.close()
            raise Error("the server of workers did not start")

    def _ready(self) -> bool:
        readable = select.select([self.socket], [], [], _START_SECONDS)[0]
        return bool(readable) and "ready" in (self.receive() or {})

    def fork(self, job: Any) -> tuple[int, socket.socket]:
        """Asks for a worker; its number of the request, to be found in the answer, and the socket to it.

        job: what it is to do (worker.py); can be pickled. Raises OSError where the server is gone.
        """
        data = pickle.dumps(job)
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        self._requests += 1
        try:
            request = json.dumps({"fork": self._requests}).encode()
            socket.send_fds(self.socket, [request], [theirs.fileno()])
            ours.sendall(len(data).to_bytes(8, "little") + data)
        except OSError:
            ours.close()
            raise
        finally:
            theirs.close()
        return self._requests, ours

    def kill(self, pid: int) -> None:
        """Kills a worker, unless it has ended already; "ended" tells."""
        with contextlib.suppress(OSError):
            self.socket.send(json.dumps({"kill": pid}).encode())

    def receive(self) -> dict[str, Any] | None:
        """The next message; None once the server has ended."""
        try:
            data = self.socket.recv(_PACKET)
        except OSError:
            return None
        return json.loads(data) if data else None

    def close(self) -> None:
        """Ends the server and with it at once all its workers."""
        if self.owner != os.getpid():
            return
        self.socket.close()
        try:
            self._process.wait(_END_SECONDS)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def _environment() -> dict[str, str]:
    """One thread is enough for NumPy here, and none is there to be forked. Huge pages make forks quicker, and
    fewer pages have to be copied behind them."""
    tunables = [os.environ.get("GLIBC_TUNABLES", ""), "glibc.malloc.hugetlb=1"]
    return {
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "GLIBC_TUNABLES": ":".join(filter(None, tunables)),
    }


# One server without workers is kept for the next batch of this process.
_idle: list[ForkServer] = []
_lock = threading.Lock()


def take() -> ForkServer:
    """A server without workers. Raises Error."""
    with _lock:
        while _idle:
            server = _idle.pop()
            if server.owner == os.getpid() and not select.select([server.socket], [], [], 0)[0]:
                return server
            server.close()
    return ForkServer()


def give_back(server: ForkServer) -> None:
    """For the next one who takes; it must have no worker left."""
    with _lock:
        if not _idle:
            _idle.append(server)
            return
    server.close()


@atexit.register
def _close_idle() -> None:
    while _idle:
        _idle.pop().close()


def serve(descriptor: int, folder: str) -> None:
    """The server's side: until the socket is closed."""
    import gc

    from . import worker

    gc.disable()  # its passes are a quarter of the time to import OCP, and would find next to nothing
    worker.preload()
    gc.freeze()  # the collector of a worker leaves alone, and so does not copy, what all of them share
    gc.enable()
    wake, wake_write = os.pipe()
    os.set_blocking(wake_write, False)
    signal.set_wakeup_fd(wake_write, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    control = socket.socket(fileno=descriptor)
    control.send(json.dumps({"ready": os.getpid()}).encode())
    workers: set[int] = set()
    try:
        while True:
            readable = wait([control, wake])
            if wake in readable:
                os.read(wake, 4096)
                _reap(control, workers, folder)
            if control in readable and not _obey(control, workers, (wake, wake_write), folder):
                break
    finally:
        for pid in workers:
            os.kill(pid, signal.SIGKILL)
        for pid in workers:
            os.waitpid(pid, 0)
        shutil.rmtree(folder, ignore_errors=True)
    os._exit(0)


def _obey(control: socket.socket, workers: set[int], pipe: tuple[int, int], folder: str) -> bool:
    """Carries out one request. False: the caller is gone."""
    try:
        data, descriptors, _, _ = socket.recv_fds(control, _PACKET, 1)
    except OSError:
        return False
    if not data:
        return False
    request = json.loads(data)
    if "kill" in request:
        if request["kill"] in workers:
            os.kill(request["kill"], signal.SIGKILL)
        return True
    try:
        pid = os.fork()
    except OSError as error:
        os.close(descriptors[0])
        control.send(json.dumps({"refused": str(error), "request": request["fork"]}).encode())
        return True
    if pid == 0:
        try:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            control.close()
            for end in pipe:
                os.close(end)
            from . import worker

            worker.main(descriptors[0], os.getppid(), folder)
        finally:
            os._exit(worker.BROKEN)
    os.close(descriptors[0])
    workers.add(pid)
    control.send(json.dumps({"forked": pid, "request": request["fork"]}).encode())
    return True


def _reap(control: socket.socket, workers: set[int], folder: str) -> None:
    while workers:
        try:
            pid, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return
        if not pid:
            return
        workers.discard(pid)
        shutil.rmtree(os.path.join(folder, str(pid)), ignore_errors=True)
        with contextlib.suppress(OSError):
            control.send(json.dumps({"ended": pid, "code": os.waitstatus_to_exitcode(status)}).encode())
