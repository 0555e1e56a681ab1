"""The part of the table of options that thumbnailer alone has."""

from __future__ import annotations

from .option import Option

_THUMBNAILER = ("thumbnailer",)

THUMBNAILER_OPTIONS: tuple[Option, ...] = (
    Option(
        "system",
        ("--system/--user",),
        "Install for all users, under /usr/local/share, or for this one, under $XDG_DATA_HOME.",
        default=False,
        flag=True,
        config=False,
        commands=_THUMBNAILER,
    ),
    Option(
        "thumbnails",
        ("--size",),
        "Which thumbnails to make: of 128, 256, 512 or 1024 px.",
        default="large",
        choices=("normal", "large", "x-large", "xx-large"),
        commands=_THUMBNAILER,
    ),
)
