"""The child process: crashes, hangs and hoarding end as clear errors, and nothing stays behind."""

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import make
import pytest

from tests.processes import runs, until
from trimray.importer import Error, InputError, MemoryLimitError, TimeLimitError, process, read_model
from trimray.importer.process import Request, run_child

HERE = Path(__file__).parent


@pytest.fixture(params=["spawn", "fork"])
def run(request, monkeypatch):
    """Runs a misbehaving child, started in either way."""
    monkeypatch.setenv("PYTHONPATH", str(HERE))

    def run(name, *, time_limit=None, memory_limit=None, progress=None):
        job = Request("unused", name, "/tmp", "default", None, memory_limit)
        options = {"module": "misbehaving_child", "start": request.param}
        return run_child(job, time_limit=time_limit, progress=progress, **options)

    return run


def children():
    """Processes whose parent is this one."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if (
                entry.name.isdigit()
                and int((entry / "stat").read_text().rpartition(")")[2].split()[1]) == os.getpid()
            ):
                found.append(int(entry.name))
        except OSError:
            continue
    return found


@pytest.fixture(autouse=True)
def _no_child_left():
    before = set(children())
    yield
    assert set(children()) <= before


@pytest.fixture
def late(monkeypatch):
    """A time limit is over as soon as this has been called, as a child's progress, and not before."""
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(process, "time", SimpleNamespace(monotonic=lambda: clock.now))

    def late(stage, fraction):
        clock.now = 100.0

    return late


def test_hang_ends_at_the_time_limit(run, late):
    with pytest.raises(
        TimeLimitError, match=r"hang: not read within 90 s \(stopped in stage 'transfer'\)"
    ) as caught:
        run("hang", time_limit=90, progress=late)
    assert caught.value.exit_code == 5


@pytest.mark.parametrize(("name", "signal"), [("segfault", "SIGSEGV"), ("abort", "SIGABRT")])
def test_crash_is_one_line(run, name, signal):
    with pytest.raises(
        InputError, match=rf"^{name}: OpenCascade crashed on it \({signal} in stage 'transfer'\)$"
    ) as caught:
        run(name)
    assert caught.value.exit_code == 3


def test_hoarding_ends_at_the_memory_limit(run):
    with pytest.raises(MemoryLimitError, match="memory: cannot be read within 200 MiB") as caught:
        run("memory", memory_limit=200 << 20)
    assert caught.value.exit_code == 5


def test_kill_from_outside_counts_as_out_of_memory(run):
    with pytest.raises(MemoryLimitError, match="in this machine's memory"):
        run("killed")


def test_silent_end_and_nonsense_are_errors(run):
    with pytest.raises(InputError, match="exit 7"):
        run("exit")
    with pytest.raises(InputError, match="nonsense"):
        run("nonsense")


def test_interrupt_passes_through_and_kills_the_child(run):
    def interrupt(stage, fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run("hang", progress=interrupt)


def test_forked_child_leaves_the_parents_exit_and_files_alone(run, tmp_path):
    """What the parent would do at its exit, and its open files, are none of the child's."""
    with open(tmp_path / "log", "w") as file:
        file.write("once")
        with pytest.raises(InputError, match="exit 7"):
            run("exit")
        with pytest.raises(InputError, match=r"ended early \(exit (1|70)"):
            run("raise")
    assert (tmp_path / "log").read_text() == "once"


@pytest.fixture(params=["seen", "not looked at"])
def watch(request, monkeypatch):
    """On a busy machine a child may have ended before its memory is looked at."""
    if request.param == "not looked at":
        monkeypatch.setattr(process._Watch, "_check_limits", lambda self: None)


@pytest.mark.parametrize("mebibytes", [60, 150])  # OpenCascade's libraries find no room, or not all of them
def test_real_reader_obeys_a_small_memory_limit(tmp_path, watch, mebibytes):
    path = make.step_file(tmp_path / "box.step", make.box())
    with pytest.raises(MemoryLimitError):
        read_model(path, memory_limit=mebibytes << 20)


@pytest.mark.parametrize("sample", ["bracket.step", "patch.step"])  # the first one crashes for want of memory
def test_forked_reader_obeys_a_small_memory_limit(samples_dir, watch, sample):
    with pytest.raises(MemoryLimitError, match="cannot be read within 1 MiB"):
        read_model(samples_dir / sample, start="fork", memory_limit=1 << 20)


def test_real_reader_obeys_a_short_time_limit(tmp_path):
    path = make.step_file(tmp_path / "box.step", make.box())
    with pytest.raises(TimeLimitError):
        read_model(path, time_limit=0.05)


def test_child_dies_with_its_parent(tmp_path):
    """The parent is killed while its child hangs; the child must go too."""
    script = (
        "import os, sys\n"
        "from trimray.importer.process import Request, run_child\n"
        "def progress(stage, fraction):\n"
        "    pids = [e for e in os.listdir('/proc') if e.isdigit()]\n"
        "    for pid in pids:\n"
        "        try:\n"
        "            if int(open(f'/proc/{pid}/stat').read().rpartition(')')[2].split()[1]) == os.getpid():\n"
        "                print(pid, flush=True)\n"
        "        except OSError: pass\n"
        "run_child(Request('x', 'hang', '/tmp', 'default', None, None), time_limit=60, progress=progress,"
        " module='mortal_child')\n"
    )
    mortal = tmp_path / "mortal_child.py"
    mortal.write_text(
        "import json\nfrom trimray.importer import child\nimport misbehaving_child\n"
        "def main(argument):\n"
        "    child._die_with(json.loads(argument)['parent'])\n"
        "    misbehaving_child.main(argument)\n"
    )
    import trimray.importer as importer

    root = Path(importer.__path__[0]).parent.parent
    paths = [str(tmp_path), str(HERE), str(Path(sys.modules["trimray"].__path__[0]).parent), str(root)]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, env=env
    ) as parent:
        child = int(parent.stdout.readline())
        parent.kill()
    until(lambda: not runs(child))


def test_nothing_is_printed_and_progress_is_told(tmp_path, capfd):
    path = make.step_file(tmp_path / "box.step", make.box())
    capfd.readouterr()
    stages = []
    model = read_model(path, progress=lambda stage, fraction: stages.append(stage))
    assert capfd.readouterr() == ("", "")
    assert stages[:3] == ["parse", "transfer", "extract"]
    assert model.report["faces"] == 6
    assert model.report["peak_memory"] > 50 << 20
    model.validate()


def test_reading_a_file_does_not_load_opencascade_here(tmp_path):
    path = make.step_file(tmp_path / "box.step", make.box())
    script = (
        f"import sys; from trimray.importer import read_model; read_model({str(path)!r});"
        " print('OCP' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_every_error_has_an_exit_code():
    assert issubclass(TimeLimitError, Error) and TimeLimitError("x").exit_code == 5


def test_what_a_hanging_child_held_is_told(run, late):
    with pytest.raises(TimeLimitError) as caught:
        run("hang", time_limit=90, memory_limit=8 << 30, progress=late)
    assert caught.value.peak_memory > 1 << 20
