"""Registers the thumbnailer with the desktop, and takes that back: a .thumbnailer entry and MIME types."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from trimray import Error, OutputError
from trimray.image_io import write_file

from .base_folders import base_folder
from .mime import TRIANGLES, TYPES, Known, known_types, missing_types, package
from .sealed import opened, seal

PROGRAM = "trimray-thumbnailer"
ENTRY, PACKAGE = "trimray.thumbnailer", "trimray.xml"
_DATABASE_TOOL = "update-mime-database"
# What the tool makes beside packages/ of a database without a type.
_DATABASE_FILES = (
    *("aliases", "generic-icons", "globs", "globs2", "icons", "magic", "mime.cache", "subclasses"),
    *("treemagic", "types", "version", "XMLnamespaces"),
)
# Folders that install makes in the data folder, or that the tool makes for our types.
_MADE = ("mime", "mime/model", "mime/packages", "thumbnailers")
_FOLDERS = "X-Trimray-Folders="

# Hears of every step before it is done: "write", "remove" or "run", and on what.
Tell = Callable[[str, str], None]


@dataclass(frozen=True)
class Place:
    """data: the folder that takes the files. others: all folders in which the desktop looks for such."""

    data: str
    others: tuple[str, ...]

    @property
    def entry(self) -> str:
        return os.path.join(self.data, "thumbnailers", ENTRY)

    @property
    def package(self) -> str:
        return os.path.join(self.data, "mime", "packages", PACKAGE)

    @property
    def database(self) -> str:
        return os.path.join(self.data, "mime")


def user_place(environment: Mapping[str, str] = os.environ) -> Place:
    """$XDG_DATA_HOME, by default ~/.local/share. Raises OutputError where there is no home."""
    data = base_folder(environment, "XDG_DATA_HOME", ".local/share")
    if data is None:
        raise OutputError("no home: set HOME or XDG_DATA_HOME, or give --system")
    return Place(data, (data, *_data_folders(environment)))


def system_place(environment: Mapping[str, str] = os.environ) -> Place:
    """/usr/local/share, the administrator's: /usr/share is that of the distribution's packages. Where the
    desktop does not look there, the first folder of $XDG_DATA_DIRS."""
    folders = _data_folders(environment)
    usual = "/usr/local/share"
    return Place(usual if usual in folders else folders[0], folders)


def _data_folders(environment: Mapping[str, str]) -> tuple[str, ...]:
    text = environment.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share"
    folders = [folder.rstrip("/") or "/" for folder in text.split(":") if os.path.isabs(folder)]
    return tuple(dict.fromkeys(folders)) or ("/usr/local/share", "/usr/share")


def install(place: Place, program: str, tell: Tell, *, dry_run: bool = False) -> list[str]:
    """Writes what is not there already. Returns remarks, a line each, about what the user should know: those
    that begin with "!" are of something that is missing. Raises OutputError: not permitted; a file of that
    name which is not as we wrote it.
    """
    remarks: list[str] = []
    known = known_types(place.others, PACKAGE)
    types = missing_types(known)
    others = _other_thumbnailers(place)
    folders = _recorded_folders(place) or _missing_folders(place)
    changed = False
    if types:
        text = seal(package(types), xml=True)
        changed = _write(place.package, text, tell, dry_run)
    elif _check_ours(place.package):
        changed = _remove(place.package, tell, dry_run)
    _write(place.entry, seal(_entry(program, known, others, folders)), tell, dry_run)
    if changed:
        remarks += _update_database(place, tell, dry_run)
    ours = {name for mime in TYPES for name in (mime.name, *mime.aliases)}
    for name in sorted({path for mime, path in others.items() if mime in ours}):
        remarks.append(f"{name} claims some of these types, too; the file manager chooses")
    if left := [mime for mime in TRIANGLES if mime in others]:
        remarks.append(f"{', '.join(left)}: left to {others[left[0]]}")
    return remarks


def uninstall(place: Place, tell: Tell, *, dry_run: bool = False) -> list[str]:
    """Removes what install wrote, unless it was changed since. Remarks and errors as of install."""
    remarks: list[str] = []
    folders = _recorded_folders(place)
    changed = False
    for path in (place.package, place.entry):
        if not os.path.lexists(path):
            continue
        if _content(path) is None:
            remarks.append(f"!{path}: left there, since it is not as we wrote it")
            continue
        _remove(path, tell, dry_run)
        changed = changed or path == place.package
    if changed:
        remarks += _update_database(place, tell, dry_run)
    if changed and "mime" in folders and not dry_run and _only_generated(place.database):
        for name in _DATABASE_FILES:
            if os.path.lexists(path := os.path.join(place.database, name)):
                _remove(path, tell, dry_run)
    if not dry_run:
        _remove_empty(place.data, folders)
    return remarks


def find_program() -> str:
    """The path of our thumbnailer: beside this Python, or on PATH. Raises OutputError."""
    beside = os.path.join(os.path.dirname(sys.executable), PROGRAM)
    path = beside if os.access(beside, os.X_OK) else shutil.which(PROGRAM)
    if path is None:
        raise OutputError(f"nothing installed: {PROGRAM} is neither beside {sys.executable} nor on PATH")
    return os.path.abspath(path)


def outside_of_sandbox(program: str) -> list[str]:
    """What the thumbnailer needs that GNOME's sandbox does not show: it has /usr and nothing else."""
    needed = (program, sys.prefix, sys.base_prefix, os.path.dirname(os.path.dirname(__file__)))
    hidden = (path for path in needed if not f"{os.path.realpath(path)}/".startswith("/usr/"))
    return list(dict.fromkeys(hidden))


def command_of(program: str) -> str:
    """As the entry names it: by its bare name where every desktop finds it."""
    name = os.path.basename(program)
    return name if shutil.which(name, path="/usr/local/bin:/usr/bin:/bin") == program else program


def _entry(program: str, known: Known, others: Mapping[str, str], folders: list[str]) -> str:
    """The text of the .thumbnailer file. Raises OutputError for a path that cannot be written in one."""
    command = command_of(program)
    if not command.isprintable():
        raise OutputError(f"{command!a}: the path of a thumbnailer must be printable")
    quoted = command
    if not command.replace("/", "").replace("-", "").replace("_", "").replace(".", "").isalnum():
        inner = "".join(f"\\{char}" if char in '"`$\\' else char for char in command)
        quoted = f'"{inner}"'
    types = [name for mime in TYPES for name in (mime.name, *mime.aliases)]
    types += [mime for mime in TRIANGLES if mime in known.types and mime not in others]
    exec_line = f"{quoted.replace('%', '%%')} -s %s %i %o"
    return (
        "[Thumbnailer Entry]\n"
        f"TryExec={_value(command)}\n"
        f"Exec={_value(exec_line)}\n"
        f"MimeType={';'.join(types)};\n"
        f"{_FOLDERS}{';'.join(folders)}\n"
    )


def _value(text: str) -> str:
    """A value of a key file."""
    return text.replace("\\", "\\\\")


def _other_thumbnailers(place: Place) -> dict[str, str]:
    """MIME type to the entry of another program that draws it."""
    found: dict[str, str] = {}
    for folder in place.others:
        folder = os.path.join(folder, "thumbnailers")
        try:
            names = sorted(os.listdir(folder))
        except OSError:
            continue
        for name in names:
            path = os.path.join(folder, name)
            if not name.endswith(".thumbnailer") or name == ENTRY:
                continue
            try:
                with open(path, encoding="utf-8", errors="replace") as file:
                    lines = file.read(1 << 20).splitlines()
            except OSError:
                continue
            for line in lines:
                key, _, value = line.partition("=")
                if key.strip() == "MimeType":
                    for mime in value.split(";"):
                        found.setdefault(mime.strip(), path)
    return found


def _content(path: str) -> str | None:
    """Of a file that is as we wrote it; None of any other."""
    try:
        with open(path, "rb") as file:
            return opened(file.read(1 << 20))
    except OSError:
        return None


def _check_ours(path: str) -> bool:
    """Is there a file of ours? Raises OutputError where there is one that is not as we wrote it."""
    if not os.path.lexists(path):
        return False
    if _content(path) is None:
        raise OutputError(f"{path}: left alone, since it is not as we wrote it; remove it to install anew")
    return True


def _write(path: str, text: str, tell: Tell, dry_run: bool) -> bool:
    """False: it was there already."""
    if _check_ours(path):
        with open(path, "rb") as file:
            if file.read() == text.encode():
                return False
    tell("write", path)
    if not dry_run:
        try:
            os.makedirs(os.path.dirname(path), exist_ok=True)
        except OSError as error:
            raise OutputError(f"{path}: not written: {error.strerror or error}") from None
        write_file(path, text.encode())
    return True


def _remove(path: str, tell: Tell, dry_run: bool) -> bool:
    tell("remove", path)
    if not dry_run:
        try:
            os.unlink(path)
        except OSError as error:
            raise OutputError(f"{path}: not removed: {error.strerror or error}") from None
    return True


def _missing_folders(place: Place) -> list[str]:
    return [name for name in _MADE if not os.path.isdir(os.path.join(place.data, name))]


def _recorded_folders(place: Place) -> list[str]:
    """Those that install made, as the entry says; [] without one of ours."""
    for line in (_content(place.entry) or "").splitlines():
        if line.startswith(_FOLDERS):
            return [name for name in line[len(_FOLDERS) :].split(";") if name]
    return []


def _remove_empty(data: str, folders: list[str]) -> None:
    for name in sorted(folders, reverse=True):
        if name in _MADE:
            path = os.path.join(data, name)
            if os.path.isdir(path) and not os.listdir(path):
                os.rmdir(path)


def _only_generated(database: str) -> bool:
    """Is there nothing in the database but what the tool made of our package?"""
    packages = os.path.join(database, "packages")
    return not (os.path.isdir(packages) and os.listdir(packages))


def _update_database(place: Place, tell: Tell, dry_run: bool) -> list[str]:
    tool = shutil.which(_DATABASE_TOOL)
    if tool is None:
        return [
            f"!{_DATABASE_TOOL} is not there: the types are not in force until it runs on {place.database} "
            "(package shared-mime-info)"
        ]
    tell("run", f"{_DATABASE_TOOL} {place.database}")
    if dry_run:
        return []
    try:
        done = subprocess.run(
            [tool, place.database], capture_output=True, text=True, errors="replace", timeout=120, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Error(f"{_DATABASE_TOOL}: {error}") from None
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1]
        return [f"!{_DATABASE_TOOL} failed: {last}"]
    return []
