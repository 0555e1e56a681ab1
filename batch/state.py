"""What became of every file, in an SQLite file beside the pictures: a row a file, committed when it is known.

The file is open to one process at a time. SQLite's own lock sees to that, which the kernel takes back when
the process ends, however it ends; and since nobody shares the file, its journal (WAL) needs no shared memory
and works on network file systems too.
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import Any

from trimray import OutputError, __version__

from .record import STATUSES, Outcome

SCHEMA = 1
_MAGIC = b"SQLite format 3\0"
_APPLICATION = 0x74726179  # "tray", in the header of the file

_TABLES = """
CREATE TABLE settings (id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE);
CREATE TABLE runs (
    id INTEGER PRIMARY KEY,
    paths TEXT NOT NULL,    -- JSON array
    options TEXT NOT NULL,  -- JSON object
    version TEXT NOT NULL,
    started TEXT NOT NULL,
    finished TEXT           -- NULL: not yet, or interrupted
);
CREATE TABLE files (
    path BLOB PRIMARY KEY,
    target BLOB NOT NULL,   -- relative to the folder of this file
    run INTEGER NOT NULL,   -- the last one that the file was part of
    status TEXT NOT NULL DEFAULT 'pending',
    exit_code INTEGER NOT NULL DEFAULT 0,
    reason TEXT NOT NULL DEFAULT '',
    size INTEGER NOT NULL DEFAULT 0,
    mtime_ns INTEGER NOT NULL DEFAULT 0,
    sha256 TEXT NOT NULL DEFAULT '',
    settings INTEGER REFERENCES settings (id),
    version TEXT NOT NULL DEFAULT '',
    attempt INTEGER NOT NULL DEFAULT 0,
    seconds REAL NOT NULL DEFAULT 0,
    peak_memory INTEGER NOT NULL DEFAULT 0,
    drawn INTEGER NOT NULL DEFAULT 0,
    not_drawn INTEGER NOT NULL DEFAULT 0,
    covered REAL NOT NULL DEFAULT 0,
    finished TEXT           -- NULL: never
) WITHOUT ROWID;
"""


@dataclass(frozen=True, slots=True)
class Row:
    """One file. path: of the input, absolute. target: of the picture, relative to the folder of the state, ""
    where none was to be made. status: of record.STATUSES, or "pending". size, mtime_ns: of the input when it
    was found. settings: their key. attempt: how often these bytes were tried under these settings. finished:
    UTC, "" for never. The others as in record.Outcome."""

    path: str
    target: str
    status: str
    exit_code: int
    reason: str
    size: int
    mtime_ns: int
    sha256: str
    settings: str
    version: str
    attempt: int
    seconds: float
    peak_memory: int
    drawn: int
    not_drawn: int
    covered: float
    finished: str

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    def outcome(self, folder: str) -> Outcome | None:
        """folder: of the pictures. None when there is none yet."""
        for status in STATUSES:
            if status == self.status:
                return Outcome(
                    path=self.path,
                    target=os.path.join(folder, self.target) if self.target else "",
                    status=status,
                    exit_code=self.exit_code,
                    reason=self.reason,
                    sha256=self.sha256,
                    seconds=self.seconds,
                    peak_memory=self.peak_memory,
                    drawn=self.drawn,
                    not_drawn=self.not_drawn,
                    covered=self.covered,
                )
        return None


@dataclass(frozen=True)
class Run:
    """One call of a batch. finished: UTC, "" when it was interrupted."""

    id: int
    paths: tuple[str, ...]
    options: dict[str, Any]
    started: str
    finished: str


_COLUMNS = (
    "f.path, f.target, f.status, f.exit_code, f.reason, f.size, f.mtime_ns, f.sha256, coalesce(s.key, ''), "
    "f.version, f.attempt, f.seconds, f.peak_memory, f.drawn, f.not_drawn, f.covered, "
    "coalesce(f.finished, '')"
)
_FROM = "FROM files f LEFT JOIN settings s ON s.id = f.settings"
_NAMES = (*Row.__dataclass_fields__, "run")
_ADOPT = (
    f"INSERT OR REPLACE INTO files ({', '.join(_NAMES)}) VALUES ({', '.join(f':{name}' for name in _NAMES)})"
)


class State:
    """Of one thread. Every method raises OutputError, one line, when the file cannot be used."""

    def __init__(self, path: str, *, create: bool = True) -> None:
        """Opens the file, or makes it. Raises OutputError also when another process has it open, when it is
        damaged, or of a newer version."""
        self._path = path
        if not create and not os.path.exists(path):
            raise OutputError(f"{path}: there is no such state of a batch")
        if not _may_be_state(path):
            raise OutputError(f"{path}: the state of the batch is damaged; move it away to begin anew")
        with self._errors():
            self._base = sqlite3.connect(path, timeout=0.0, isolation_level=None)
        try:
            with self._errors():
                self._open()
        except BaseException:
            self._base.close()
            raise

    def _open(self) -> None:
        run = self._base.execute
        run("PRAGMA locking_mode = EXCLUSIVE")
        run("BEGIN EXCLUSIVE")  # takes the lock, which stays
        schema = run("PRAGMA user_version").fetchone()[0]
        application = run("PRAGMA application_id").fetchone()[0]
        empty = run("SELECT count(*) FROM sqlite_schema").fetchone()[0] == 0
        if not empty and (application != _APPLICATION or schema < 1):
            raise OutputError(f"{self._path}: not the state of a batch")
        if schema > SCHEMA:
            raise OutputError(
                f"{self._path}: written by a newer trimray (schema {schema}, this one knows {SCHEMA})"
            )
        if empty:
            for statement in _TABLES.split(";\n"):
                run(statement)
            run(f"PRAGMA application_id = {_APPLICATION}")
            run(f"PRAGMA user_version = {SCHEMA}")
        run("COMMIT")
        run("PRAGMA journal_mode = WAL")
        # A crash of the machine, not of the process, may take back the last rows: their files are redone.
        run("PRAGMA synchronous = NORMAL")

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            name = getattr(error, "sqlite_errorname", "")
            if name.startswith(("SQLITE_BUSY", "SQLITE_LOCKED")):
                raise OutputError(f"{self._path}: another batch is at work on this folder") from None
            if name.startswith(("SQLITE_NOTADB", "SQLITE_CORRUPT")):
                raise OutputError(
                    f"{self._path}: the state of the batch is damaged ({error}); move it away to begin anew"
                ) from None
            raise OutputError(f"{self._path}: {error}") from None

    def close(self) -> None:
        self._base.close()

    def __enter__(self) -> State:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @contextmanager
    def together(self) -> Iterator[None]:
        """All changes within are one, and much faster so."""
        with self._errors():
            self._base.execute("BEGIN")
            try:
                yield
            except BaseException:
                self._base.execute("ROLLBACK")
                raise
            self._base.execute("COMMIT")

    def begin(self, paths: Iterable[str], options: dict[str, Any]) -> int:
        """A new run; returns its number."""
        words = (json.dumps(list(paths)), json.dumps(options, sort_keys=True), __version__, now())
        with self._errors():
            done = self._base.execute(
                "INSERT INTO runs (paths, options, version, started) VALUES (?, ?, ?, ?)", words
            )
        return int(done.lastrowid or 0)

    def finish(self, run: int) -> None:
        with self._errors():
            self._base.execute("UPDATE runs SET finished = ? WHERE id = ?", (now(), run))

    def last_run(self) -> Run | None:
        with self._errors():
            found = self._base.execute(
                "SELECT id, paths, options, started, coalesce(finished, '') FROM runs "
                "ORDER BY id DESC LIMIT 1"
            ).fetchone()
        if found is None:
            return None
        try:
            return Run(found[0], tuple(json.loads(found[1])), json.loads(found[2]), found[3], found[4])
        except ValueError as error:
            raise OutputError(
                f"{self._path}: the state of the batch is damaged ({error}); move it away to begin anew"
            ) from None

    def row(self, path: str) -> Row | None:
        with self._errors():
            found = self._base.execute(
                f"SELECT {_COLUMNS} {_FROM} WHERE f.path = ?", (os.fsencode(path),)
            ).fetchone()
        return None if found is None else _row(found)

    def rows(self, run: int | None = None) -> Iterator[Row]:
        """Those of a run, or all, by path (bytes), one by one."""
        which, words = ("", ()) if run is None else ("WHERE f.run = ?", (run,))
        with self._errors():
            for found in self._base.execute(f"SELECT {_COLUMNS} {_FROM} {which} ORDER BY f.path", words):
                yield _row(found)

    def pending(self, run: int) -> list[str]:
        """Targets of the files of a run that are still to be drawn."""
        with self._errors():
            found = self._base.execute(
                "SELECT target FROM files WHERE run = ? AND status = 'pending'", (run,)
            ).fetchall()
        return [os.fsdecode(target) for (target,) in found]

    def counts(self, run: int) -> dict[tuple[str, int], int]:
        """Files of a run by status and exit code."""
        with self._errors():
            found = self._base.execute(
                "SELECT status, exit_code, count(*) FROM files WHERE run = ? GROUP BY 1, 2", (run,)
            ).fetchall()
        return {(status, code): number for status, code, number in found}

    def enroll(self, run: int, path: str, target: str, *, pending: bool) -> None:
        """Makes a file part of a run. pending: it will be drawn, again where it was before."""
        again = ", status = 'pending'" if pending else ""
        with self._errors():
            self._base.execute(
                "INSERT INTO files (path, target, run) VALUES (?, ?, ?) ON CONFLICT (path) DO UPDATE SET "
                f"target = excluded.target, run = excluded.run{again}",
                (os.fsencode(path), os.fsencode(target), run),
            )

    def record(
        self,
        run: int,
        outcome: Outcome,
        target: str,
        *,
        size: int,
        mtime_ns: int,
        settings: str,
        attempt: int,
    ) -> None:
        """What became of a file; on disk when this returns. target: relative."""
        words = asdict(outcome) | {"target": target, "size": size, "mtime_ns": mtime_ns, "settings": settings}
        words |= {"version": __version__, "attempt": attempt, "finished": now()}
        self.adopt(run, Row(**words))

    def adopt(self, run: int, row: Row) -> None:
        """Takes over a row as it stands."""
        values = asdict(row)
        values["path"], values["target"] = os.fsencode(row.path), os.fsencode(row.target)
        values["reason"] = _storable(row.reason)
        values["finished"] = row.finished or None
        values["run"] = run
        with self._errors():
            values["settings"] = self._settings_id(row.settings) if row.settings else None
            self._base.execute(_ADOPT, values)

    def describe(self, run: int, paths: Iterable[str], options: dict[str, Any]) -> None:
        """What a run is of."""
        words = (json.dumps(list(paths)), json.dumps(options, sort_keys=True), run)
        with self._errors():
            self._base.execute("UPDATE runs SET paths = ?, options = ? WHERE id = ?", words)

    def touch(self, path: str, size: int, mtime_ns: int) -> None:
        """The bytes of the file are what they were, whatever its date says."""
        with self._errors():
            self._base.execute(
                "UPDATE files SET size = ?, mtime_ns = ? WHERE path = ?", (size, mtime_ns, os.fsencode(path))
            )

    def forget_gone(self, run: int) -> list[Row]:
        """Removes the rows of files that are no part of the run and no longer there; returns them."""
        with self._errors():
            found = self._base.execute(f"SELECT {_COLUMNS} {_FROM} WHERE f.run != ?", (run,))
            gone = [row for row in map(_row, found) if not os.path.lexists(row.path)]
            self._base.executemany("DELETE FROM files WHERE path = ?", [(os.fsencode(r.path),) for r in gone])
        return gone

    def _settings_id(self, key: str) -> int:
        found = self._base.execute("SELECT id FROM settings WHERE key = ?", (key,)).fetchone()
        if found is None:
            found = [self._base.execute("INSERT INTO settings (key) VALUES (?)", (key,)).lastrowid]
        return int(found[0])


def _may_be_state(path: str) -> bool:
    """SQLite takes what is too short for a database as an empty one, and would overwrite it."""
    try:
        with open(path, "rb") as file:
            head = file.read(len(_MAGIC))
    except OSError:
        return True  # SQLite says why
    return head in (b"", _MAGIC)


def now() -> str:
    """UTC, to the millisecond."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")[:-3] + "Z"


def _row(found: tuple[Any, ...]) -> Row:
    return Row(os.fsdecode(found[0]), os.fsdecode(found[1]), *found[2:])


def _storable(text: str) -> str:
    """SQLite's text is UTF-8: bytes of a name that are not stand as \\udcXX."""
    return text.encode("utf-8", "backslashreplace").decode()
