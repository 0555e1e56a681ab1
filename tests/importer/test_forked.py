"""Reading children forked from a process that reads and draws many files."""

import signal
import subprocess
import sys

import make
import numpy as np
import pytest

from trimray.importer import EmptyError, InputError, MemoryLimitError, TimeLimitError, read_model

# Run as a program: a process that has no test framework in it, and OpenCascade.
MANY = """
import os, sys, threading
from pathlib import Path
import numpy as np
from trimray import load
from trimray.importer import child
child.preload()
box, mesh = sys.argv[1:3]
def facts():
    return len(os.listdir("/proc/self/fd")), threading.active_count()
model = load(box, cache=False, start="fork")
reference = model.render((32, 32), threads=2)["color"]
before = facts()
for n in range(60):
    path = mesh if n % 4 == 3 else box
    model = load(path, cache=False, start="fork", time_limit=60, memory_limit=2 << 30)
    assert len(model.faces) == (1 if path == mesh else 6), n
    if n % 20 == 0:
        again = load(box, cache=False, start="fork").render((32, 32), threads=2)
        assert np.array_equal(again["color"], reference)
assert facts() == before, (facts(), before)
try:
    os.waitpid(-1, os.WNOHANG)
    raise SystemExit("a child is left")
except ChildProcessError:
    print("good")
"""

TRIANGLE = """solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid a
"""


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    return make.step_file(tmp_path_factory.mktemp("forked") / "box.step", make.box())


def test_many_children_of_a_process_that_draws(tmp_path, box):
    """Its threads, those of the core above all, are not in the children; nothing of these is left."""
    mesh = tmp_path / "triangle.stl"
    mesh.write_text(TRIANGLE)
    done = subprocess.run(
        [sys.executable, "-c", MANY, str(box), str(mesh)], capture_output=True, text=True, timeout=500
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "good\n", "")


def test_a_forked_child_reads_the_same(box):
    spawned, forked = read_model(box), read_model(box, start="fork")
    assert forked.brep == spawned.brep
    assert np.array_equal(forked.instance_placements, spawned.instance_placements)
    assert forked.tree == spawned.tree


def test_limits_and_errors_are_the_same(tmp_path, box):
    with pytest.raises(TimeLimitError, match="not read within"):
        read_model(box, start="fork", time_limit=0.001)
    with pytest.raises(MemoryLimitError, match="cannot be read within 1 MiB"):
        read_model(box, start="fork", memory_limit=1 << 20)
    text = tmp_path / "text.step"
    text.write_text("hello")
    with pytest.raises(InputError, match="truncated"):
        read_model(text, start="fork")
    empty = tmp_path / "empty.stl"
    empty.write_text("solid a\nendsolid a\n")
    with pytest.raises(EmptyError):
        read_model(empty, start="fork")


def test_handlers_and_masks_of_the_parent_do_not_hold_the_child(box):
    """A child must die of its alarm (read_step.py), whatever its parent does with that signal."""
    code = (
        "import os, signal, sys, time\n"
        "from trimray.importer.forked import fork_child\n"
        "signal.signal(signal.SIGALRM, lambda *_: None)\n"
        "signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM, signal.SIGTERM])\n"
        "sys.modules['alarmed'] = type(sys)('alarmed')\n"
        "def main(argument):\n"
        "    signal.setitimer(signal.ITIMER_REAL, 0.01)\n"
        "    time.sleep(60)\n"
        "sys.modules['alarmed'].main = main\n"
        "r, w = os.pipe()\n"
        "print(fork_child('alarmed', '{}', w).wait())\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout == f"{-signal.SIGALRM}\n", done.stderr
