"""Runs a program as GNOME's file manager does, in bubblewrap under a filter of system calls.

After libgnome-desktop/gnome-desktop-thumbnail-script.c of GNOME/gnome-desktop: the arguments of its
add_bwrap, but for the caches of fonts and GStreamer, which nothing of ours reads; and the calls that its
setup_seccomp, taken from Flatpak, refuses.
"""

from __future__ import annotations

import errno
import os
import platform
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import trimray

# Where the sandbox shows the virtual environment and the package. In an installation that GNOME can use both
# lie under /usr; in a test they lie anywhere, and these read-only binds are all that is added to GNOME's.
ENVIRONMENT, PACKAGE = "/opt/environment", "/opt/package"

# Numbers of x86-64: acct add_key chroot get_mempolicy keyctl mbind migrate_pages modify_ldt mount move_pages
# perf_event_open pivot_root ptrace quotactl request_key set_mempolicy setns syslog umount2 unshare uselib.
_REFUSED = (
    *(163, 248, 161, 239, 250, 237, 256, 154, 165, 279, 298),
    *(155, 101, 179, 249, 238, 308, 103, 166, 272, 134),
)
# clone3 open_tree move_mount fsopen fsconfig fsmount fspick mount_setattr.
_UNKNOWN = (435, 428, 429, 430, 431, 432, 433, 442)
_CLONE, _SOCKET, _IOCTL, _PERSONALITY = 56, 41, 16, 135
_CLONE_NEWUSER, _TIOCSTI, _TIOCLINUX = 0x10000000, 0x5412, 0x541C
_FAMILIES = (0, 1, 2, 10, 16)  # unspecified, Unix, IPv4, IPv6, netlink
_X86_64 = 0xC000003E
_ALLOW, _ERROR = 0x7FFF0000, 0x00050000


@dataclass(frozen=True)
class Done:
    """outputs: names and bytes of all that the program left in /tmp."""

    code: int
    text: str
    outputs: dict[str, bytes]


def why_not() -> str:
    """Why nothing can be run so on this machine; "" where it can."""
    if shutil.which("bwrap") is None:
        return "no bubblewrap (bwrap)"
    command = ["bwrap", "--ro-bind", "/", "/", "--unshare-all", "true"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return f"no namespaces here: {done.stderr.strip()}" if done.returncode else ""


def run(program: list[str], source: Path, python: bool = True) -> Done:
    """program: as in the Exec line, %i and %o standing for input and output. python: show ours."""
    extension = source.suffix[1:]
    inside = f"/tmp/gnome-desktop-file-to-thumbnail.{extension}"
    names = {"%i": inside, "%o": "/tmp/gnome-desktop-thumbnailer.png"}
    with tempfile.TemporaryDirectory(prefix="gnome-desktop-thumbnailer-") as folder, _filter() as descriptor:
        command = [
            "bwrap",
            *("--ro-bind", "/usr", "/usr"),
            *("--ro-bind-try", "/etc/ld.so.cache", "/etc/ld.so.cache"),
            *_merged(),
            *("--ro-bind-try", "/etc/alternatives", "/etc/alternatives"),
            *("--proc", "/proc", "--dev", "/dev", "--chdir", "/"),
            *("--setenv", "GIO_USE_VFS", "local", "--unshare-all", "--die-with-parent"),
            *("--bind", folder, "/tmp", "--ro-bind", str(source), inside),
            *(("--seccomp", str(descriptor)) if descriptor is not None else ()),
            *(_python() if python else ()),
            *(names.get(word, word) for word in program),
        ]
        passed = () if descriptor is None else (descriptor,)
        # GNOME hands its own environment on; what of it does not exist inside must not matter.
        environment = {"PATH": os.environ["PATH"], "HOME": "/home/nobody", "XDG_CACHE_HOME": "/home/nobody/c"}
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            env=environment,
            pass_fds=passed,
            timeout=300,
            check=False,
        )
        # bubblewrap leaves an empty file where it bound the input; GNOME removes it.
        Path(folder, os.path.basename(inside)).unlink(missing_ok=True)
        outputs = {path.name: path.read_bytes() for path in Path(folder).iterdir()}
        return Done(done.returncode, done.stdout + done.stderr, outputs)


def _merged() -> list[str]:
    """Links of / into /usr where the system has merged them, binds where not."""
    words: list[str] = []
    for name in ("bin", "lib64", "lib", "sbin"):
        if os.path.exists(f"/{name}"):
            merged = os.path.exists(f"/usr/{name}") and os.path.samefile(f"/{name}", f"/usr/{name}")
            words += (
                ("--symlink", f"/usr/{name}", f"/{name}") if merged else ("--ro-bind", f"/{name}", f"/{name}")
            )
    return words


def _python() -> list[str]:
    words = ["--ro-bind", sys.prefix, ENVIRONMENT]
    base = os.path.realpath(sys.base_prefix)
    if not base.startswith("/usr/"):
        words += ["--ro-bind", base, base]
    package = Path(trimray.__file__).parent
    if not package.is_relative_to(sys.prefix):  # a development tree, which may be made of links
        words += ["--setenv", "PYTHONPATH", PACKAGE]
        for path in filter(Path.exists, package.iterdir()):
            words += ["--ro-bind", str(path.resolve()), f"{PACKAGE}/trimray/{path.name}"]
    return words


@contextmanager
def _filter() -> Iterator[int | None]:
    """A descriptor of the compiled filter; None on another architecture, where none is made."""
    if platform.machine() != "x86_64":
        yield None
        return
    with tempfile.TemporaryFile() as file:
        file.write(b"".join(struct.pack("<HBBI", *line) for line in _program()))
        file.seek(0)
        yield file.fileno()


def _program() -> list[tuple[int, int, int, int]]:
    """Classic BPF over struct seccomp_data: number at 0, architecture at 4, arguments from 16 on."""
    load, equal, bits, answer = 0x20, 0x15, 0x45, 0x06
    lines = [(load, 0, 0, 4), (equal, 1, 0, _X86_64), (answer, 0, 0, _ALLOW), (load, 0, 0, 0)]
    for number in _REFUSED:
        lines += [(equal, 0, 1, number), (answer, 0, 0, _ERROR | errno.EPERM)]
    for number in _UNKNOWN:
        lines += [(equal, 0, 1, number), (answer, 0, 0, _ERROR | errno.ENOSYS)]
    refuse, allow = (answer, 0, 0, _ERROR | errno.EPERM), (answer, 0, 0, _ALLOW)
    by_argument = {
        _CLONE: [(load, 0, 0, 16), (bits, 0, 1, _CLONE_NEWUSER), refuse, allow],
        _PERSONALITY: [(load, 0, 0, 16), (equal, 1, 0, 0), refuse, allow],
        _IOCTL: [(load, 0, 0, 24), (equal, 1, 0, _TIOCSTI), (equal, 0, 1, _TIOCLINUX), refuse, allow],
        _SOCKET: [
            (load, 0, 0, 16),
            *((equal, len(_FAMILIES) - at, 0, family) for at, family in enumerate(_FAMILIES)),
            (answer, 0, 0, _ERROR | errno.EAFNOSUPPORT),
            allow,
        ],
    }
    for number, block in by_argument.items():
        lines += [(equal, 0, len(block), number), *block]
    return [*lines, allow]
