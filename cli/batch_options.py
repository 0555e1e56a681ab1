"""The part of the table of options that batch alone has."""

from __future__ import annotations

from . import values
from .option import Option

_BATCH = ("batch",)

BATCH_OPTIONS: tuple[Option, ...] = (
    Option(
        "folder",
        ("-o", "--output"),
        "Folder of the pictures and of the state; made where it is missing.",
        "DIR",
        config=False,
        commands=_BATCH,
    ),
    Option(
        "include",
        ("--include",),
        "Take the files whose name, or path below PATH, matches, in any case, instead of those with the "
        "extension of a model. May be given several times.",
        "GLOB",
        multiple=True,
        config=False,
        commands=_BATCH,
    ),
    Option(
        "template",
        ("--template",),
        "Path of each picture in DIR, with fields: {parent} is the file's folder below PATH, {name} its name "
        "without extensions, {ext} these, {format} the extension of the picture. Default: "
        "{parent}/{name}.{format}.",
        "TEXT",
        config=False,
        commands=_BATCH,
    ),
    Option(
        "workers",
        ("-j", "--jobs"),
        "Processes that draw; 0 for one a core. With --scheduler: for each thread of a worker; 0 for one.",
        "N",
        "0",
        parse=values.workers,
        commands=(*_BATCH, "thumbnailer"),
    ),
    Option(
        "resume",
        ("--resume",),
        "Go on with an interrupted run: files of the same size and date are taken as unchanged. Without "
        "PATH, with the paths and options of the last run.",
        default=False,
        flag=True,
        config=False,
        commands=_BATCH,
    ),
    Option(
        "retry_failed",
        ("--retry-failed",),
        "Try again what failed or is degraded.",
        default=False,
        flag=True,
        config=False,
        commands=_BATCH,
    ),
    Option(
        "shard",
        ("--shard",),
        "Draw share K of N alone; auto/N takes K from the variable of a job array. Default: what such a "
        "variable says.",
        "K/N",
        config=False,
        commands=_BATCH,
    ),
    Option(
        "scheduler",
        ("--scheduler",),
        "Draw on the Dask cluster of this scheduler, such as tcp://host:8786; its workers must find PATH and "
        "DIR under the same names. Needs trimray[dask].",
        "ADDRESS",
        commands=_BATCH,
    ),
    Option(
        "lines",
        ("--report",),
        "Write what became of every file as JSON lines; - is stdout.",
        "FILE",
        config=False,
        commands=_BATCH,
    ),
    Option(
        "gallery",
        ("--gallery",),
        "Write DIR/index.html, a page that shows all pictures in DIR; of shards, it is for batch merge.",
        default=False,
        flag=True,
        config=False,
        commands=_BATCH,
    ),
)
