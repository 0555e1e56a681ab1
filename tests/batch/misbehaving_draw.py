"""Drawing functions that do what the item's name says; run in the workers of the pool."""

import ctypes
import json
import os
import resource
import signal
import time
from pathlib import Path

from trimray.batch.record import Item, Outcome, Settings
from trimray.importer import child
from trimray.importer.forked import data_bytes
from trimray.importer.process import Request, run_child

_hoard = []
_poisoned = []


def draw(item: Item, settings: Settings) -> Outcome:
    """By the name's part before "-": good ones take as many milliseconds as their size says."""
    if _poisoned:
        ctypes.string_at(0)
    match Path(item.path).name.partition("-")[0]:
        case "segfault":
            ctypes.string_at(0)
        case "abort":
            os.abort()
        case "hang":
            time.sleep(1000)
        case "deaf":
            signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
            ctypes.CDLL(None).sleep(1000)  # holds on in native code
        case "reader":  # hangs in a reading child
            request = Request(item.path, "reader", "/tmp", "default", None, None)
            run_child(request, time_limit=None, module=__name__, start="fork")
        case "hog":
            limit = data_bytes() + (64 << 20)
            resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
            while True:
                _hoard.append(bytearray(8 << 20))
        case "exit0":
            os._exit(0)
        case "exit7":
            os._exit(7)
        case "exit113":
            os._exit(113)
        case "quit":
            raise SystemExit(3)
        case "raise":
            raise ValueError("two\nlines")
        case "unspeakable":
            return Outcome(item.path, item.target, "complete", reason=lambda: "")
        case "nothing":
            return None
        case "nonsense":
            _shout(b'{"status": "splendid"}\n')
            time.sleep(1000)
        case "endless":
            _shout(b"x" * (3 << 20))
            time.sleep(1000)
        case "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case "killedonce":
            if not os.path.exists(item.target):
                Path(item.target).touch()
                os.kill(os.getpid(), signal.SIGKILL)
        case "poison":  # its damage shows while the next file is drawn
            _poisoned.append(True)
        case "grow":
            _hoard.append(b"x" * (300 << 20))
        case "leftover":
            folder, name = os.path.split(item.target)
            Path(folder, f".{name}.0123456789ab.part").touch()
            os._exit(1)
    time.sleep(item.size / 1000)
    return Outcome(item.path, item.target, "complete", reason=str(os.getpid()))


def main(argument: str) -> None:
    """Of the reading child."""
    child._die_with(json.loads(argument)["parent"])
    time.sleep(1000)


def _shout(data: bytes) -> None:
    """Writes on every socket of this process."""
    for entry in os.listdir("/proc/self/fd"):
        try:
            if os.readlink(f"/proc/self/fd/{entry}").startswith("socket:"):
                os.write(int(entry), data)
        except OSError:
            continue


class Unloadable:
    """Can be pickled, but not be unpickled."""

    def __call__(self, item: Item, settings: Settings) -> Outcome:
        raise NotImplementedError

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.stat, ("/nonexistent",)
