"""Finds the models under files and folders: each once, however it is reached, the largest first."""

from __future__ import annotations

import fnmatch
import os
import re
import stat
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from trimray import UsageError
from trimray.importer.archive import is_model_name

from .record import Outcome

_FolderId = tuple[int, int]


@dataclass(frozen=True, slots=True)
class File:
    """path: absolute, as the file system gives it (surrogateescape). parent: of the file, relative to the
    PATH that it was found under, "" at the top. size: bytes, mtime_ns: 0 for what is no readable regular
    file."""

    path: str
    parent: str
    size: int = 0
    mtime_ns: int = 0

    @property
    def name(self) -> str:
        return self.path.rpartition("/")[2]

    @property
    def relative(self) -> str:
        """The same on every machine, wherever the library is mounted."""
        return f"{self.parent}/{self.name}" if self.parent else self.name


@dataclass
class Found:
    """files: the largest first, ties by path. failures: folders that could not be searched."""

    files: list[File] = field(default_factory=list)
    failures: list[Outcome] = field(default_factory=list)


def find(paths: Sequence[str], *, include: Sequence[str] = (), leave_out: str | None = None) -> Found:
    """paths: files are taken whatever they are, missing ones too, so that each is told of; folders are
    searched for files whose extension is that of a model, in any case, or that match one of include.

    include: patterns of fnmatch, in any case, of the name or of the path relative to the folder. leave_out:
    a folder that is not searched when it lies in one of paths: that of the pictures.

    Names that begin with "." are left out unless they are in paths. Links to folders are followed, after
    all that is no link; a folder is searched once, for the first of paths that leads to it. Raises
    UsageError for an empty path, or one that holds NUL.
    """
    places = [absolute(path) for path in paths]
    search = _Search(places, _wanted(include), leave_out)
    for place in places:
        search.take(place)
    search.found.files.sort(key=lambda file: (-file.size, file.path))
    return search.found


def absolute(path: str) -> str:
    """Without resolving links, unless ".." makes that necessary. Raises UsageError."""
    if not path or "\0" in path:
        raise UsageError("a path holds a NUL byte" if path else "an empty path")
    if ".." in path.split("/"):
        return os.path.realpath(path)
    return os.path.abspath(path)


class _Wanted:
    def __init__(self, include: Iterable[str]) -> None:
        patterns = [fnmatch.translate(pattern.removeprefix("./").lower()) for pattern in include]
        self._match = re.compile("|".join(patterns)).match if patterns else None

    def __call__(self, parent: str, name: str) -> bool:
        if self._match is None:
            return is_model_name(name)
        low = name.lower()
        return bool(self._match(low) or (parent and self._match(f"{parent.lower()}/{low}")))


def _wanted(include: Sequence[str]) -> _Wanted:
    if any(not pattern for pattern in include):
        raise UsageError("--include: an empty pattern")
    return _Wanted(include)


class _Search:
    def __init__(self, places: list[str], wanted: _Wanted, leave_out: str | None) -> None:
        self.found = Found()
        self._wanted = wanted
        self._searched: set[_FolderId] = set()
        # Names taken already, in the folders that hold a file of the paths.
        self._taken: dict[_FolderId, set[str]] = {}
        self._is_folder = {place: os.path.isdir(place) for place in places}
        for place in places:
            if not self._is_folder[place] and (parent := _folder_id(os.path.dirname(place))):
                self._taken.setdefault(parent, set())
        out = _folder_id(leave_out) if leave_out else None
        self._out = out if all(_folder_id(place) != out for place in places) else None

    def take(self, place: str) -> None:
        if self._is_folder[place]:
            self._walk(place)
            return
        taken = self._taken.get(_folder_id(os.path.dirname(place)) or (0, 0), set())
        name = os.path.basename(place)
        if name in taken:
            return
        taken.add(name)
        size, mtime_ns = _facts(place)
        self.found.files.append(File(place, "", size, mtime_ns))

    def _walk(self, top: str) -> None:
        """Without recursion, since folders may be nested deeper than Python's stack."""
        folders = [(top, "")]
        links: deque[tuple[str, str]] = deque()
        while folders or links:
            folder, parent = folders.pop() if folders else links.popleft()
            try:
                about = os.stat(folder)
                here = (about.st_dev, about.st_ino)
                if here in self._searched or here == self._out:
                    continue
                self._searched.add(here)
                with os.scandir(folder) as entries:
                    below, linked = self._entries(entries, parent, self._taken.get(here))
            except OSError as error:
                self._fail(folder, error)
                continue
            folders += sorted(below, reverse=True)
            links += sorted(linked)

    def _entries(
        self, entries: Iterator[os.DirEntry[str]], parent: str, taken: set[str] | None
    ) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
        """Takes the files; returns the folders and the links to folders: path, path relative to the top."""
        folders: list[tuple[str, str]] = []
        links: list[tuple[str, str]] = []
        for entry in entries:
            name = entry.name
            if name.startswith("."):
                continue
            if entry.is_dir(follow_symlinks=False):
                folders.append((entry.path, f"{parent}/{name}" if parent else name))
            elif entry.is_symlink() and _leads_to_folder(entry):
                links.append((entry.path, f"{parent}/{name}" if parent else name))
            elif self._wanted(parent, name):
                if taken is not None:
                    if name in taken:
                        continue
                    taken.add(name)
                size, mtime_ns = _facts(entry)
                self.found.files.append(File(entry.path, parent, size, mtime_ns))
        return folders, links

    def _fail(self, folder: str, error: OSError) -> None:
        reason = f"folder not searched: {error.strerror or error}"
        self.found.failures.append(Outcome(folder, "", "failed", exit_code=3, reason=reason))


def _folder_id(path: str) -> _FolderId | None:
    try:
        about = os.stat(path)
    except (OSError, ValueError):
        return None
    return about.st_dev, about.st_ino


def _leads_to_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:  # a link that leads to itself
        return False


def _facts(entry: os.DirEntry[str] | str) -> tuple[int, int]:
    """Bytes and time of modification of a regular file; zeros for all else."""
    try:
        about = os.stat(entry) if isinstance(entry, str) else entry.stat()
    except OSError:
        return 0, 0
    return (about.st_size, about.st_mtime_ns) if stat.S_ISREG(about.st_mode) else (0, 0)
