"""A child process that does what its request's name says; takes the place of trimray.importer.child."""

import ctypes
import json
import os
import signal
import time


def main(argument: str) -> None:
    request = json.loads(argument)
    os.write(request["pipe"], b'{"stage": "transfer", "fraction": null}\n')
    match request["name"]:
        case "hang":
            while True:
                time.sleep(1)
        case "segfault":
            ctypes.string_at(0)
        case "abort":
            os.abort()
        case "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case "raise":
            raise RuntimeError("through main")
        case "exit":
            os._exit(7)
        case "memory":
            hoard = [b"x" * (8 << 20) for _ in range(50)]  # no more: nobody may look for a while
            time.sleep(600)
            del hoard
        case "nonsense":
            os.write(request["pipe"], b'{"model": {}, "blobs": [3]}\nabc')
            time.sleep(60)
