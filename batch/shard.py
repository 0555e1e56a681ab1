"""A library in shares: --shard k/n, and the variables by which job arrays number their tasks."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass

from trimray import UsageError

from .targets import STATE_NAME


@dataclass(frozen=True)
class Shard:
    """Share number k, 1 to n. Which file is in it depends on nothing but the file's path relative to the PATH
    it was found under: all tasks agree, also when files come and go while they start."""

    k: int = 1
    n: int = 1

    def __contains__(self, relative: str) -> bool:
        if self.n == 1:
            return True
        digest = hashlib.blake2b(os.fsencode(relative), digest_size=8).digest()
        return int.from_bytes(digest, "big") % self.n == self.k - 1

    def __str__(self) -> str:
        return f"{self.k}/{self.n}"

    @property
    def state_name(self) -> str:
        """Of the file that keeps the state of this share."""
        return f"{STATE_NAME}.sqlite" if self.n == 1 else f"{STATE_NAME}.{self.k}-of-{self.n}.sqlite"


_STATE = re.compile(re.escape(STATE_NAME) + r"\.(\d+)-of-(\d+)\.sqlite")


def shard_of_state(name: str) -> Shard | None:
    """The inverse of state_name; None for the state of no shard."""
    found = _STATE.fullmatch(name)
    return Shard(int(found[1]), int(found[2])) if found else None


def parse_shard(text: str, environment: Mapping[str, str] | None = None) -> Shard:
    """k/n, or auto/n: number k from the job array's variable. Raises UsageError."""
    first, slash, last = text.strip().partition("/")
    if slash and last.isascii() and last.isdigit() and int(last) >= 1:
        n = int(last)
        if first == "auto":
            array = _array(os.environ if environment is None else environment)
            if array is None:
                raise UsageError(f"--shard: '{text}', but there is no variable of a job array")
            if not 1 <= array.k <= n:
                raise UsageError(f"--shard: {array.variable} makes this share {array.k} of {n}")
            return Shard(array.k, n)
        if first.isascii() and first.isdigit() and 1 <= int(first) <= n:
            return Shard(int(first), n)
    raise UsageError(f"--shard: '{text}' is not k/n with 1 <= k <= n, such as 3/16, nor auto/n")


def shard_of_environment(environment: Mapping[str, str] | None = None) -> tuple[Shard, str] | None:
    """The share and the name of the variable that says so; None outside of job arrays. Raises UsageError
    where the number of shares is not told."""
    array = _array(os.environ if environment is None else environment)
    if array is None:
        return None
    if array.n is None:
        raise UsageError(
            f"{array.variable} is set, which does not tell the number of tasks: give --shard auto/N, or "
            "--shard 1/1 to draw all files"
        )
    if not 1 <= array.k <= array.n:
        raise UsageError(f"{array.variable} makes this share {array.k} of {array.n}: give --shard k/n")
    return Shard(array.k, array.n), array.variable


@dataclass(frozen=True)
class _Array:
    variable: str
    k: int
    n: int | None


def _array(environment: Mapping[str, str]) -> _Array | None:
    """Slurm's array may begin anywhere and go in steps; AWS Batch and Kubernetes count from 0, PBS from 1."""

    def number(name: str, usual: int | None = None) -> int | None:
        text = environment.get(name, "")
        if not text:
            return usual
        if not (text.isascii() and text.isdigit()):
            raise UsageError(f"{name}: '{text}' is not a number; --shard k/n comes first")
        return int(text)

    slurm = number("SLURM_ARRAY_TASK_ID")
    if slurm is not None:
        low = number("SLURM_ARRAY_TASK_MIN", 0) or 0
        step = number("SLURM_ARRAY_TASK_STEP", 1) or 1
        high = number("SLURM_ARRAY_TASK_MAX")
        n = number("SLURM_ARRAY_TASK_COUNT")
        if n is None and high is not None:
            n = (high - low) // step + 1
        if (slurm - low) % step:
            raise UsageError("SLURM_ARRAY_TASK_ID is not one of its array's: give --shard k/n")
        return _Array("SLURM_ARRAY_TASK_ID", (slurm - low) // step + 1, n)
    aws = number("AWS_BATCH_JOB_ARRAY_INDEX")
    if aws is not None:
        return _Array("AWS_BATCH_JOB_ARRAY_INDEX", aws + 1, number("AWS_BATCH_JOB_ARRAY_SIZE"))
    kubernetes = number("JOB_COMPLETION_INDEX")
    if kubernetes is not None:
        return _Array("JOB_COMPLETION_INDEX", kubernetes + 1, None)
    pbs = number("PBS_ARRAY_INDEX")
    return None if pbs is None else _Array("PBS_ARRAY_INDEX", pbs, None)
