"""Names, folders, links and things that are no files. The bytes are those of one good model."""

from __future__ import annotations

import os
import socket
from pathlib import Path

from .entry import Entry, write

_NAMES: tuple[bytes, ...] = (
    b"with spaces in it.step",
    b" leading and trailing .step",
    b'it\'s "quoted".step',
    b"new\nline.step",
    b"\nleading newline.step",
    b"tab\tand\rreturn.step",
    b"-o.step",
    b"--help.step",
    b"-.step",
    "Zylinderkopf äöü ß 杯头 عمود.step".encode(),
    "nfd a\u0308.step".encode(),
    "nfc \u00e4.step".encode(),
    "emoji \U0001f980\u202egnp.step".encode(),
    b"not utf-8 \xff\xfe \xe4.step",
    b"bell\x07 escape \x1b[31mred\x1b[0m.step",
    b"$(touch trimray-owned);`id`;&|>out<in *?[a-z]!.step",
    b"<img src=x onerror=alert(1)>.step",
    b"</script><script>alert(1)</script>.step".replace(b"/", b"\xe2\x88\x95"),
    b"a&amp;b 100%25 %s %d %n {name} {parent} {{}}.step",
    b"back\\slash\\..\\up.step",
    b"trailing dots....step",
    b"con.step",
    b"nul.tar.step",
    b"UPPER.STEP",
    b"Mixed.StP",
    b"many.dots.in.the.name.v1.2.step",
    b"~.step",
    b"#1.step",
    b"file:__tmp.step",
    b"\xef\xbb\xbfbom.step",
    b"\x7f\x01\x02.step",
    b"x" * 250 + b".step",
    b"y" * 251 + b".stp",
    "\u00e9".encode() * 124 + b".step",
)


def odd_names(root: Path, model: str, data: bytes) -> list[Entry]:
    entries = [write(root, Entry(b"names/" + n, "names", "good", alias=model), data) for n in _NAMES]
    collide = (
        *(b"same/part.step", b"same/part.stp", b"same/part.STEP", b"same/Part.step", b"same/part.png.step"),
        *(b"same/part.step.step", b"same/" + b"z" * 250 + b".step", b"same/" + b"z" * 250 + b".STEP"),
    )
    entries += [write(root, Entry(p, "names", "good", alias=model), data) for p in collide]
    deep = b"deep/" + b"/".join([b"d" * 200] * 14) + b"/part.step"
    wide = b"deep/" + b"/".join([b"%d" % i for i in range(200)]) + b"/part.step"
    folder = b"folder.step/inside.step"
    entries += [
        write(root, Entry(p, "folders", "good", alias=model), data)
        for p in (deep, wide, folder, b"-rf/inside.step", b"*/inside.step")
    ]
    hidden = (b"names/.hidden.step", b"folder.step/.git/inside.step")
    entries += [write(root, Entry(p, "hidden", "absent"), data) for p in hidden]
    (root / "empty folder.step").mkdir()
    (root / "empty").mkdir()
    return entries


def links(root: Path, model: str, data: bytes) -> list[Entry]:
    """Links of every kind; loops of folders must end, and name nothing twice."""
    folder = root / "links"
    entries = [write(root, Entry(b"links/real.step", "links", "good", alias=model), data)]
    os.link(folder / "real.step", folder / "hard.step")
    (folder / "soft.step").symlink_to("real.step")
    (folder / "chain.step").symlink_to("soft.step")
    entries += [
        Entry(p, "links", "good", alias=model)
        for p in (b"links/hard.step", b"links/soft.step", b"links/chain.step")
    ]
    (folder / "nowhere.step").symlink_to("missing.step")
    (folder / "itself.step").symlink_to("itself.step")
    (folder / "ping.step").symlink_to("pong.step")
    (folder / "pong.step").symlink_to("ping.step")
    entries += [
        Entry(b"links/" + p, "links", "bad")
        for p in (b"nowhere.step", b"itself.step", b"ping.step", b"pong.step")
    ]
    (folder / "loop").symlink_to(".")
    (folder / "up").symlink_to("..")
    (folder / "down").mkdir()
    (folder / "down" / "up.step").symlink_to("../../links")
    return entries


def no_files(root: Path) -> list[Entry]:
    """Things that block, or never end, when they are opened and read."""
    folder = root / "devices"
    folder.mkdir()
    os.mkfifo(folder / "fifo.step")
    here = os.open(".", os.O_RDONLY)
    try:
        os.chdir(folder)  # the address of a socket is short
        with socket.socket(socket.AF_UNIX) as end:
            end.bind("socket.step")
    finally:
        os.fchdir(here)
        os.close(here)
    for name, target in (
        ("zero.step", "/dev/zero"),
        ("random.step", "/dev/urandom"),
        ("tty.step", "/dev/tty"),
        ("stdin.step", "/dev/stdin"),
        ("memory.step", "/proc/self/mem"),
        ("kernel.step", "/proc/self/status"),
    ):
        (folder / name).symlink_to(target)
    (folder / "fifo-link.step").symlink_to("fifo.step")
    return [Entry(b"devices/" + os.fsencode(p.name), "devices", "bad") for p in sorted(folder.iterdir())]
