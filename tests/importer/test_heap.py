"""The memory that OpenCascade is given in reading processes: heap.cpp through its four functions."""

from __future__ import annotations

import ctypes
import random
import subprocess
import sys

import pytest

from trimray.importer import heap

pytestmark = pytest.mark.skipif(not heap.LIBRARY.is_file(), reason="built without libtrimray_heap.so")

LARGEST = 512  # bytes of a block that is none of malloc's


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
        size = rng.choice((0, 1, 16, 17, 24, 100, LARGEST, LARGEST + 1, 5000, rng.randrange(600)))
        address = taken.take(size)
        assert address % 16 == 0 and address not in blocks
        assert ctypes.string_at(address, size) == bytes(size)
        mark = step % 255 + 1
        ctypes.memset(address, mark, size)
        blocks[address] = size, mark
    for address, (size, mark) in blocks.items():
        assert ctypes.string_at(address, size) == bytes([mark]) * size


def test_what_is_resized_keeps_its_content() -> None:
    taken = Heap()
    for first in (1, 16, 40, LARGEST, LARGEST + 1, 4000):
        for then in (1, 16, 41, 300, LARGEST, LARGEST + 1, 9000):
            address = taken.take_dirty(first)
            content = bytes(i % 251 for i in range(first))
            ctypes.memmove(address, content, first)
            address = taken.resize(address, then)
            kept = min(first, then)
            assert ctypes.string_at(address, kept) == content[:kept]
            taken.free(address)
    assert ctypes.string_at(taken.resize(None, 40), 40) == bytes(40)


def test_a_freed_block_is_the_next_of_its_size() -> None:
    taken = Heap()
    first = taken.take(100)
    ctypes.memset(first, 7, 100)
    taken.free(first)
    assert taken.take(112) == first
    assert ctypes.string_at(first, 112) == bytes(112)


def test_blocks_of_malloc_are_freed_as_such() -> None:
    libc = ctypes.CDLL(None)
    libc.malloc.restype, libc.malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
    taken = Heap()
    taken.free(libc.malloc(100))
    taken.free(None)


def _run(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_opencascade_takes_its_memory_here_where_it_is_loaded_first() -> None:
    code = """
import ctypes
from trimray.importer import heap
{0}
import OCP.BRepPrimAPI, OCP.gp
{1}
take = ctypes.CDLL(str(heap.LIBRARY))._ZN8Standard8AllocateEm
take.restype, take.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
first = [take(size) for size in range(16, 513, 16)]
shapes = [OCP.BRepPrimAPI.BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape() for _ in range(20)]
print(sum(take(size) - a != size for size, a in zip(range(16, 513, 16), first)))
"""
    assert int(_run(code.format("heap.use()", ""))) > 3
    assert int(_run(code.format("", "heap.use()"))) == 0


def test_too_little_memory_is_an_error_of_its_own() -> None:
    out = _run("""
import resource
from trimray.importer import heap
heap.use()
from OCP.TColStd import TColStd_HArray1OfReal
from OCP.gp import gp_Pnt
from OCP.Geom import Geom_CartesianPoint
resource.setrlimit(resource.RLIMIT_DATA, (900 << 20, 900 << 20))
kept = []
try:
    while True:
        kept.append(Geom_CartesianPoint(0.0, 0.0, 0.0))
except BaseException as error:
    count = len(kept)
    kept.clear()
    print(type(error).__name__, count > 100_000)
""")
    assert out.split() == ["MemoryError", "True"]
