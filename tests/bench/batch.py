"""Files a second of a batch beside loops over single commands, on parts of KiCad: `scripts/bench batch`.

    scripts/bench batch [--count 300] [--rounds 3] [--folder DIR] [--only NAME...] [--json FILE]

The files are of the Debian package kicad-packages3d, which is downloaded once into the folder (apt-get,
379 MB): of all its *.step, those whose path in the package has the smallest SHA-256. They are dealt into
rounds; in each round all contenders draw the same files in turn, 256 x 256 px, nothing cached, so that
whatever else the machine does falls on all of them. A round of the batch includes its start.

    batch        trimray batch -j 2
    loop         a shell loop over trimray render, one after another, each with all cores
    loop x 2     the same by xargs -P 2, each with one thread
    f3d, x 2     F3D in the same ways, where it is: the command f3d on PATH or in TRIMRAY_F3D, or a Python
                 interpreter there that has F3D's package (pip install f3d), which has no command

files/s counts what was asked for, drawn or not; "pictures" how many there are. "cpu s" is processor time a
file, of user and system, which the machine's load changes less than the rest. The ratio is the rate of the
batch over that of the contender, of all rounds; "by cpu" the same of processor time.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import resource
import shutil
import subprocess
import sys
import time
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "kicad-packages3d"
SIZE = 256

# $1: folder of the files; $2: of the pictures.
_LOOP = 'for file in "$1"/*.step; do {one}; done'
_XARGS = 'printf "%s\\0" "$1"/*.step | xargs -0 -P 2 -I @ {one}'
_F3D = """
import sys, f3d
engine = f3d.Engine.create(True)
engine.window.size = {size}, {size}
engine.scene.add(sys.argv[1])
engine.window.render_to_image().save(sys.argv[2])
"""


@dataclass
class Result:
    """Sums over rounds."""

    files: int = 0
    pictures: int = 0
    seconds: float = 0.0
    cpu_seconds: float = 0.0

    @property
    def rate(self) -> float:
        return self.files / self.seconds


def files_of(folder: Path, count: int) -> list[Path]:
    """The first files by the hash of their path; downloads the package when it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    packages = sorted(folder.glob(f"{PACKAGE}_*.deb"))
    if not packages:
        subprocess.run(["apt-get", "download", PACKAGE], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        packages = sorted(folder.glob(f"{PACKAGE}_*.deb"))
    names = folder / "names"
    if not names.is_file():
        listing = f'dpkg-deb --fsys-tarfile "{packages[0].name}" | tar -t > names.new && mv names.new names'
        subprocess.run(listing, shell=True, cwd=folder, check=True)
    steps = [name for name in names.read_text().splitlines() if name.endswith(".step")]
    chosen = sorted(steps, key=lambda name: hashlib.sha256(name.encode()).hexdigest())[:count]
    missing = [name for name in chosen if not (folder / name).is_file()]
    if missing:
        (folder / "missing").write_text("\n".join(missing))
        extract = f'dpkg-deb --fsys-tarfile "{packages[0].name}" | tar -x --verbatim-files-from -T missing'
        subprocess.run(extract, shell=True, cwd=folder, check=True)
    return [folder / name for name in chosen]


def contenders() -> dict[str, list[str]]:
    """Command lines by name; the folders of the files and of the pictures are appended."""
    trimray = str(Path(sys.executable).with_name("trimray"))
    render = f"'{trimray}' render -q --no-cache --size {SIZE}"
    batch = f'\'{trimray}\' batch -q -j 2 --size {SIZE} --report "$2/report.jsonl" "$1" -o "$2"'
    found = {
        "batch": batch,
        "loop": _LOOP.format(one=f'{render} "$file" -o "$2/"'),
        "loop x 2": _XARGS.format(one=f'{render} -j 1 @ -o "$2/"'),
    }
    f3d = os.environ.get("TRIMRAY_F3D") or shutil.which("f3d")
    if f3d:
        python = Path(f3d).name.startswith("python")
        code = _F3D.format(size=SIZE)
        one = f"'{f3d}' -c '{code}'" if python else f"'{f3d}' --resolution={SIZE},{SIZE}"
        output = "" if python else "--output="
        found["f3d"] = _LOOP.format(one=f'{one} "$file" {output}"$2/${{file##*/}}.png"')
        found["f3d x 2"] = _XARGS.format(one=f'{one} @ {output}"$2"/@.png').replace(
            'printf "%s\\0" "$1"/*.step', 'cd "$1" && printf "%s\\0" *.step'
        )
    return {name: ["bash", "-c", script, name] for name, script in found.items()}


def measure(command: list[str], source: Path, output: Path, result: Result) -> None:
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    with (output.parent / "messages").open("ab") as messages:
        subprocess.run([*command, str(source), str(output)], stdout=messages, stderr=messages, check=False)
    result.seconds += time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    result.cpu_seconds += after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    result.files += len(list(source.iterdir()))
    result.pictures += len(list(output.glob("*.png")))


def show(results: dict[str, Result], statuses: Counter[str], equal: list[int]) -> None:
    first = results.get("batch")
    print(
        f"\n{'contender':10} {'files':>6} {'pictures':>8} {'files/s':>8} {'ratio':>6} {'cpu s':>7} "
        f"{'by cpu':>7}"
    )
    for name, r in results.items():
        ratio = by_cpu = ""
        if first is not None and name != "batch":
            ratio = f"{first.rate / r.rate:.2f}"
            by_cpu = f"{r.cpu_seconds / r.files / (first.cpu_seconds / first.files):.2f}"
        cpu = r.cpu_seconds / r.files
        print(f"{name:10} {r.files:6} {r.pictures:8} {r.rate:8.2f} {ratio:>6} {cpu:7.3f} {by_cpu:>7}")
    if statuses:
        print("batch: " + ", ".join(f"{number} {status}" for status, number in statuses.most_common()))
    if equal[1]:
        print(f"pictures of batch and loop, byte by byte: {equal[0]} of {equal[1]} are equal")
    load = ", ".join(f"{x:.1f}" for x in os.getloadavg())
    print(f"load of the machine in the last 1, 5, 15 minutes: {load}; {os.cpu_count()} cores", flush=True)


def same_pictures(one: Path, other: Path) -> tuple[int, int]:
    """Equal ones, and those that both have."""
    pairs = [(path, other / path.name) for path in one.glob("*.png") if (other / path.name).is_file()]
    return sum(a.read_bytes() == b.read_bytes() for a, b in pairs), len(pairs)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="scripts/bench batch", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=300, help="files")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "bench" / "kicad")
    parser.add_argument("--only", nargs="+", default=[], help="contenders; default: all")
    parser.add_argument("--json", type=Path, help="also write the results here")
    args = parser.parse_args(arguments)
    files = files_of(args.folder.resolve(), args.count)
    commands = {n: c for n, c in contenders().items() if not args.only or n in args.only}
    print(f"{len(files)} files, {sum(f.stat().st_size for f in files) / 1e6:.0f} MB; {', '.join(commands)}")
    results = {name: Result() for name in commands}
    statuses: Counter[str] = Counter()
    equal = [0, 0]
    work = args.folder.resolve() / "work"
    shutil.rmtree(work, ignore_errors=True)
    for k in range(args.rounds):
        source = work / f"round{k}"
        source.mkdir(parents=True)
        for number, file in enumerate(files[k :: args.rounds]):
            os.link(file, source / f"{number:03}_{file.name}")
        for name, command in commands.items():
            measure(command, source, work / name.replace(" ", ""), results[name])
        report = work / "batch" / "report.jsonl"
        if report.is_file():
            statuses.update(json.loads(line)["status"] for line in report.read_text().splitlines())
        if {"batch", "loop"} <= commands.keys():
            equal = [a + b for a, b in zip(equal, same_pictures(work / "batch", work / "loop"), strict=True)]
        show(results, statuses, equal)
        if args.json:
            rows = {name: asdict(result) for name, result in results.items()}
            args.json.write_text(json.dumps(rows, indent=2) + "\n")
    return 0
