"""Batches on a Dask cluster: a real scheduler and real workers, which die on the way."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.processes import runs, until
from trimray import Error, UsageError
from trimray.batch import cluster
from trimray.batch.chunks import DEATHS
from trimray.batch.cluster import draw_on_cluster
from trimray.batch.pool import draw_all
from trimray.batch.record import Item, Outcome, Settings

from . import cluster_draws

distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install 'trimray[dask]'")

SETTINGS = Settings(size=(64, 64), time_limit=5.0)
HERE = Path(__file__).resolve().parent


class Cluster:
    """Processes of a cluster; all that it starts ends with it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._processes: list[subprocess.Popen[bytes]] = []
        self.scheduler = self._start("scheduler", "--port", "0", "--host", "127.0.0.1")
        until(lambda: bool(self.address))

    @property
    def address(self) -> str:
        """ "" until the scheduler has written it."""
        with contextlib.suppress(OSError, ValueError):
            return str(json.loads((self._folder / "scheduler.json").read_text())["address"])
        return ""

    def _start(self, kind: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--no-dashboard"]
        command += ["--scheduler-file", str(self._folder / "scheduler.json"), *options]
        # The workers import cluster_draws under the name that it has here.
        tests = HERE.parents[cluster_draws.__name__.count(".") - 1]
        python_path = os.pathsep.join([str(tests), os.environ.get("PYTHONPATH", "")])
        process = subprocess.Popen(
            command,
            cwd=self._folder,
            env={**os.environ, "PYTHONPATH": python_path},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._processes.append(process)
        return process

    def add_worker(self, *options: str) -> int:
        """Returns the id of the process: of the worker, or of its nanny."""
        folder = str(self._folder)
        return self._start("worker", "--nthreads", "1", "--local-directory", folder, *options).pid

    def worker_pids(self) -> list[int]:
        """Of those that are there just now."""
        with distributed.Client(self.address, set_as_default=False) as client:
            return sorted(client.run(os.getpid, on_error="ignore").values())

    def settled(self) -> list[int]:
        """Both workers, once they are there again."""
        until(lambda: len(self.worker_pids()) == 2)
        return self.worker_pids()

    def close(self) -> None:
        for process in self._processes:
            process.kill()  # a nanny's worker ends as soon as it sees that
            process.wait()


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A scheduler with two workers, that are started anew when they die: each has a nanny."""
    found = Cluster(tmp_path_factory.mktemp("dask"))
    try:
        found.add_worker("--nanny")
        found.add_worker("--nanny")
        found.settled()
        yield found
    finally:
        found.close()


@pytest.fixture
def library(tmp_path: Path, samples_dir: Path) -> Callable[..., list[Item]]:
    """Makes items of copies of a small sample, by their names."""

    def make(*names: str) -> list[Item]:
        (tmp_path / "in").mkdir()
        items = []
        for name in names:
            path = tmp_path / "in" / name
            if "missing" not in name:
                shutil.copy(samples_dir / "patch.step", path)
            items.append(Item(str(path), str(tmp_path / "out" / f"{name}.png"), 1000))
        return items

    return make


def begun(folder: Path) -> Counter[bytes]:
    """Drawings that were begun, in vain or not, by the name of the picture."""
    return Counter(folder.joinpath("begun").read_bytes().splitlines())


def comparable(outcomes: list[Outcome]) -> list[Outcome]:
    """Without what differs from run to run."""
    return sorted((replace(o, seconds=0.0, peak_memory=0) for o in outcomes), key=lambda o: o.path)


def draw(items: list[Item], dask: Cluster, settings: Settings = SETTINGS, **words: Any) -> Iterator[Outcome]:
    return draw_on_cluster(iter(items), settings, dask.address, draw=cluster_draws.draw, **words)


def test_killed_workers_cost_nothing_but_time(
    dask: Cluster,
    library: Callable[..., list[Item]],
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    """One with a nanny and one without are killed on the way; a crash, a hang, a file that is not there and
    names that are no text stand in the list. Everything else is drawn, and as on this machine."""
    dask.settled()
    alone = dask.add_worker("--no-nanny")
    until(lambda: len(dask.worker_pids()) == 3)
    nannied = next(pid for pid in dask.worker_pids() if pid != alone)
    names = ["hang.step", "crash.step", "missing.step", "two\nlines.step", os.fsdecode(b"\xff.step")]
    items = library(*names, *(f"slow {i}.step" for i in range(16)))
    monkeypatch.chdir(tmp_path)  # relative paths are those of this process
    relative = [replace(i, path=os.path.relpath(i.path), target=os.path.relpath(i.target)) for i in items]
    outcomes, tries = [], {}
    for outcome in draw(relative, dask, chunk=8):
        outcomes.append(outcome)
        name = os.fsencode(os.path.basename(outcome.target).replace("\n", "_"))
        tries[name] = begun(tmp_path)[name]
        if len(outcomes) == 4:
            os.kill(alone, signal.SIGKILL)
        if len(outcomes) == 8:
            os.kill(nannied, signal.SIGKILL)
    assert capfd.readouterr() == ("", "")
    assert begun(tmp_path) == tries  # none whose outcome was known
    pictures = {item.target: Path(item.target).read_bytes() for item in items if "slow" in item.path}
    shutil.rmtree(tmp_path / "out")
    here = draw_all(items, SETTINGS, 2, draw=cluster_draws.draw)
    here = (replace(o, path=os.path.relpath(o.path), target=os.path.relpath(o.target)) for o in here)
    assert comparable(outcomes) == comparable(list(here))
    assert pictures == {target: Path(target).read_bytes() for target in pictures}
    by_name = {os.path.basename(outcome.path): outcome for outcome in outcomes}
    assert [by_name[name].status for name in names] == ["failed"] * 3 + ["complete"] * 2
    assert sum(outcome.status == "complete" for outcome in outcomes) == len(items) - 3


def test_a_file_that_kills_workers_is_failed(dask: Cluster, library: Callable[..., list[Item]]) -> None:
    items = library("a.step", "murder.step", "b.step", "c.step", "d.step")
    outcomes = {os.path.basename(o.path): o for o in draw(items, dask, chunk=4)}
    murder = outcomes.pop("murder.step")
    assert murder.status == "failed"
    assert murder.reason == f"the worker died, {DEATHS} times while drawing it"
    assert {o.status for o in outcomes.values()} == {"complete"}
    assert len(outcomes) == 4


def test_the_command_does_on_a_cluster_what_it_does_here(
    dask: Cluster, library: Callable[..., list[Item]], tmp_path: Path
) -> None:
    library("a.step", "b.step", "c.step")
    (tmp_path / "in" / "empty.step").touch()
    results = []
    for where in ([], ["--scheduler", dask.address]):
        command = [
            "-m",
            "trimray.cli",
            "batch",
            "in",
            "-o",
            "out",
            "--size",
            "64",
            "-j",
            "1",
            "--report",
            "-",
        ]
        done = subprocess.run(
            [sys.executable, *command, *where], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        rows = [json.loads(line) for line in done.stdout.splitlines()]
        same = [
            {k: v for k, v in row.items() if k not in ("seconds", "peak_memory", "finished")} for row in rows
        ]
        pictures = {path.name: path.read_bytes() for path in (tmp_path / "out").glob("*.png")}
        results.append((done.returncode, done.stderr.partition(";")[0], same, pictures))
        shutil.rmtree(tmp_path / "out")
    assert results[0] == results[1]
    assert results[1][0] == 1
    assert len(results[1][3]) == 3


def test_closing_ends_everything_on_the_workers(dask: Cluster, library: Callable[..., list[Item]]) -> None:
    items = library("a.step", *(f"hang {i}.step" for i in range(6)))
    pids = dask.settled()
    outcomes = draw(items, dask, replace(SETTINGS, time_limit=None))
    assert next(outcomes).status == "complete"
    until(lambda: len(_drawing(pids)) >= 2)
    started = _drawing(pids)
    outcomes.close()  # type: ignore[attr-defined]
    until(lambda: not any(runs(pid) for pid in started))
    assert dask.worker_pids() == pids  # Dask's own processes are left alone


def _drawing(workers: list[int]) -> list[int]:
    """All processes below these."""
    parents = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            parents[int(folder.name)] = int(folder.joinpath("stat").read_text().rpartition(")")[2].split()[1])
    found = set(workers)
    while more := {pid for pid, parent in parents.items() if parent in found} - found:
        found |= more
    return sorted(found - set(workers))


def test_another_version_on_the_workers_is_one_line(
    dask: Cluster, library: Callable[..., list[Item]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "__version__", "99.0")
    with pytest.raises(
        UsageError, match=r"^the worker tcp://\S+ has trimray \S+, this machine 99\.0: install"
    ):
        list(draw(library("a.step"), dask))


def test_a_lost_scheduler_is_one_line(
    tmp_path: Path,
    library: Callable[..., list[Item]],
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It has no worker, which is told, and is then killed."""
    monkeypatch.setattr(cluster, "_LONELY", 0.5)
    lonely = Cluster(tmp_path)
    told: list[str] = []

    def tell(line: str) -> None:
        told.append(line)
        lonely.scheduler.kill()

    try:
        with pytest.raises(Error, match=r"^the connection to the scheduler tcp://\S+ was lost$"):
            list(draw(library("a.step"), lonely, tell=tell))
    finally:
        lonely.close()
    assert told == [f"{lonely.address} has no worker: waiting for one"]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "address", ["tcp://127.0.0.1:9", "nonsense://127.0.0.1:9", "tcp://no-host.invalid:1"]
)
def test_an_unreachable_scheduler_is_one_line(address: str, capfd: pytest.CaptureFixture[str]) -> None:
    outcomes = draw_on_cluster([], SETTINGS, address, connect_timeout=1.0)
    with pytest.raises(UsageError, match=f"^cannot reach the scheduler {address}: ") as raised:
        next(outcomes)
    assert raised.value.exit_code == 2
    assert "\n" not in str(raised.value)
    assert capfd.readouterr() == ("", "")


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"pip install 'trimray\[dask\]'"):
        next(draw_on_cluster([], SETTINGS, "tcp://127.0.0.1:9"))


class _Versions:
    """Stands in for a client whose cluster runs other versions."""

    def __init__(self, python: str, dask: str) -> None:
        self._other = {"packages": {"python": python, "distributed": dask}}

    def get_versions(self, check: bool) -> dict[str, Any]:
        own = {"packages": {"python": "3.11.7.final.0", "distributed": "2026.8.0"}}
        return {"client": own, "scheduler": own, "workers": {"tcp://worker:1": self._other}}


def _checked(client: _Versions) -> list[str]:
    told: list[str] = []
    cluster._Batch(client, "tcp://s:1", cluster.Stock([], 1, 1), {}, told.append).check_versions()
    return told


def test_another_python_is_refused_and_another_dask_is_told() -> None:
    assert _checked(_Versions("3.11.2.final.0", "2026.8.0")) == []
    with pytest.raises(UsageError, match=r"^the worker tcp://worker:1 runs Python 3\.12\.1"):
        _checked(_Versions("3.12.1.final.0", "2026.8.0"))
    (line,) = _checked(_Versions("3.11.7.final.0", "2025.1.0"))
    assert line.startswith("the worker tcp://worker:1 runs distributed 2025.1.0, this machine 2026.8.0")
