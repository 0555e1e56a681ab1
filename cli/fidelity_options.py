"""The part of the table of options that check, roundtrip and compare have."""

from __future__ import annotations

from . import values
from .option import Option

FIDELITY = ("check", "roundtrip", "compare")
_COMPARING = ("roundtrip", "compare")

FIDELITY_OPTIONS: tuple[Option, ...] = (
    Option(
        "profile",
        ("--profile",),
        "Tolerances: strict is what the same surfaces written anew keep, lenient what a conversion may cost.",
        default="default",
        choices=("strict", "default", "lenient"),
        commands=FIDELITY,
    ),
    Option(
        "via",
        ("--via",),
        "What is written and read back; store is STEP from the surfaces that trimray itself keeps.",
        default="step",
        choices=("step", "iges", "brep", "store"),
        commands=("roundtrip",),
    ),
    Option(
        "schema",
        ("--schema",),
        "Of the STEP file.",
        default="ap242",
        choices=("ap203", "ap214", "ap242"),
        commands=("roundtrip",),
    ),
    Option(
        "writer",
        ("--writer",),
        "A command that writes in place of OpenCascade, with {in} and {out} for the paths, such as "
        '"convert.sh {in} {out}"; no shell runs it. --via says what it writes.',
        "CMD",
        config=False,
        commands=("roundtrip",),
    ),
    Option(
        "keep",
        ("--keep",),
        "Keep the written file here; of several IN, a path with {name}.",
        "FILE",
        config=False,
        commands=("roundtrip",),
    ),
    Option(
        "twice",
        ("--twice/--once",),
        "Write and read what was written once more: a stable writer changes nothing then.",
        default=True,
        flag=True,
        commands=("roundtrip",),
    ),
    Option(
        "pictures",
        ("--pictures/--no-pictures",),
        "Compare pictures too: six views and iso.",
        default=True,
        flag=True,
        commands=_COMPARING,
    ),
    Option(
        "picture_size",
        ("--size",),
        "Size of these pictures in pixels; one number is a square.",
        "W,H",
        "384,384",
        parse=values.size,
        commands=_COMPARING,
    ),
    Option(
        "junit",
        ("--junit",),
        "Write JUnit XML, a test case a value, for build servers; - is stdout.",
        "FILE",
        config=False,
        commands=FIDELITY,
    ),
    Option(
        "html",
        ("--html",),
        "Write one self-contained page: what differs, and the pictures beside and over each other.",
        "FILE",
        config=False,
        commands=FIDELITY,
    ),
)
