"""The memory that OpenCascade is given in reading processes: heap.cpp through its four functions."""

from __future__ import annotations

import ctypes
import os
import random
import re
import subprocess
import sys

import pytest

from trimray.importer import heap

pytestmark = pytest.mark.skipif(not heap.LIBRARY.is_file(), reason="built without libtrimray_heap.so")


class Heap:
    def __init__(self) -> None:
        library = ctypes.CDLL(str(heap.LIBRARY))
        self.take, self.take_dirty = library._ZN8Standard8AllocateEm, library._ZN8Standard15AllocateOptimalEm
        self.resize, self.free = library._ZN8Standard10ReallocateEPvm, library._ZN8Standard4FreeEPv
        for function, arguments in (
            (self.take, [ctypes.c_size_t]),
            (self.take_dirty, [ctypes.c_size_t]),
            (self.resize, [ctypes.c_void_p, ctypes.c_size_t]),
            (self.free, [ctypes.c_void_p]),
        ):
            function.restype, function.argtypes = ctypes.c_void_p, arguments


def test_blocks_are_zero_aligned_and_apart() -> None:
    taken, rng, blocks = Heap(), random.Random(1), dict[int, tuple[int, int]]()
    for step in range(20_000):
        if blocks and rng.random() < 0.45:
            address = rng.choice(list(blocks)[-50:])
            size, mark = blocks.pop(address)
            assert ctypes.string_at(address, size) == bytes([mark]) * size
            taken.free(address)
            continue
        size = rng.choice((0, 1, 16, 17, 24, 100, 512, 5000, 100_000, rng.randrange(600)))
        address = taken.take(size)
        assert address % (16 if size > 8 else 8) == 0 and address not in blocks
        assert ctypes.string_at(address, size) == bytes(size)
        mark = step % 255 + 1
        ctypes.memset(address, mark, size)
        blocks[address] = size, mark
    for address, (size, mark) in blocks.items():
        assert ctypes.string_at(address, size) == bytes([mark]) * size


def test_what_is_resized_keeps_its_content() -> None:
    taken = Heap()
    for first in (1, 16, 40, 512, 4000):
        for then in (1, 16, 41, 300, 512, 9000):
            address = taken.take_dirty(first)
            content = bytes(i % 251 for i in range(first))
            ctypes.memmove(address, content, first)
            address = taken.resize(address, then)
            kept = min(first, then)
            assert ctypes.string_at(address, kept) == content[:kept]
            taken.free(address)
    assert ctypes.string_at(taken.resize(None, 40), 40) == bytes(40)


def _run(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ | environment
    )


def test_opencascade_takes_its_memory_here_where_it_is_loaded_first() -> None:
    code = """
from trimray.importer import heap
{0}
import OCP.BRepPrimAPI
{1}
OCP.BRepPrimAPI.BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()
"""
    # What the dynamic linker tells of each function that a library finds in another (ld.so(8)).
    bound = re.compile(r"libTK\S+ \[0\] to \S+libtrimray_heap\.so \[0\]: normal symbol `(\w+)'")
    first = _run(code.format("heap.use()", ""), LD_DEBUG="bindings").stderr
    assert {"_ZN8Standard8AllocateEm", "_ZN8Standard4FreeEPv"} <= set(bound.findall(first))
    late = _run(code.format("", "heap.use()"), LD_DEBUG="bindings").stderr
    assert "libTKernel" in late and not bound.findall(late)


def test_too_little_memory_is_an_error_of_its_own() -> None:
    out = _run("""
import resource
from trimray.importer import heap
heap.use()
from OCP.TColStd import TColStd_HArray1OfReal
resource.setrlimit(resource.RLIMIT_DATA, (900 << 20, 900 << 20))
try:
    TColStd_HArray1OfReal(1, 1 << 30)
except MemoryError as error:
    print(type(error).__name__, TColStd_HArray1OfReal(1, 1 << 10).Length())
""")
    assert out.stdout.split() == ["MemoryError", "1024"]
