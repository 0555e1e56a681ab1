"""Faster memory for OpenCascade, in processes that read files and end."""

import contextlib
import ctypes
import os
import sys
from pathlib import Path

LIBRARY = Path(__file__).absolute().parent.parent / "libtrimray_heap.so"


def use() -> None:
    """Makes OpenCascade take its memory from heap.cpp. Of no effect once OCP is imported, whose blocks would
    then be given back to a heap that they are not of; nor where the library was not built."""
    if "OCP" not in sys.modules:
        with contextlib.suppress(OSError):
            ctypes.CDLL(str(LIBRARY), mode=os.RTLD_GLOBAL | os.RTLD_NOW)
