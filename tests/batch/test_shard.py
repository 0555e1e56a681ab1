"""Shares of a library: disjoint, complete, even, and the same for all tasks of a job array."""

from __future__ import annotations

from collections import Counter

import pytest

from trimray import UsageError
from trimray.batch.shard import Shard, parse_shard, shard_of_environment, shard_of_state

PATHS = [f"folder{k % 37}/part-{k}.step" for k in range(8000)]


def test_every_file_is_in_one_share_and_the_shares_are_even() -> None:
    shards = [Shard(k, 16) for k in range(1, 17)]
    shares = Counter(shard.k for path in PATHS for shard in shards if path in shard)
    assert sum(shares.values()) == len(PATHS)
    assert max(shares.values()) < 1.2 * 500 and min(shares.values()) > 0.8 * 500


def test_a_share_does_not_depend_on_the_other_files() -> None:
    """As it would if files were dealt out in turn: then a new one would move all that follow it."""
    shard = Shard(2, 5)
    assert [p for p in PATHS[:500] if p in shard] == [
        p for p in PATHS if p in shard and p in set(PATHS[:500])
    ]
    assert b"caf\xe9".decode("utf-8", "surrogateescape") in Shard(1, 1)


@pytest.mark.parametrize(("text", "k", "n"), [("1/1", 1, 1), ("3/16", 3, 16), (" 16/16 ", 16, 16)])
def test_k_of_n(text: str, k: int, n: int) -> None:
    assert parse_shard(text, {}) == Shard(k, n)


@pytest.mark.parametrize("text", ["0/4", "5/4", "1/0", "1", "a/b", "1/4/2", "-1/4", "1/", "/4", "", "²/4"])
def test_what_is_no_share_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="--shard"):
        parse_shard(text, {})


def slurm(k: int, low: int, high: int, step: int, count: int) -> dict[str, str]:
    values = {"ID": k, "MIN": low, "MAX": high, "STEP": step, "COUNT": count}
    return {f"SLURM_ARRAY_TASK_{name}": str(value) for name, value in values.items()}


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        (slurm(1, 1, 8, 1, 8), Shard(1, 8)),
        (slurm(0, 0, 7, 1, 8), Shard(1, 8)),
        (slurm(7, 0, 7, 1, 8), Shard(8, 8)),
        (slurm(30, 10, 40, 10, 4), Shard(3, 4)),
        ({"AWS_BATCH_JOB_ARRAY_INDEX": "0", "AWS_BATCH_JOB_ARRAY_SIZE": "5"}, Shard(1, 5)),
        ({"AWS_BATCH_JOB_ARRAY_INDEX": "4", "AWS_BATCH_JOB_ARRAY_SIZE": "5"}, Shard(5, 5)),
    ],
)
def test_job_arrays_tell_the_share(environment: dict[str, str], expected: Shard) -> None:
    told = shard_of_environment(environment)
    assert told is not None
    assert told[0] == expected and told[1] in environment


def test_outside_of_job_arrays_nothing_is_told() -> None:
    assert shard_of_environment({}) is None
    assert shard_of_environment({"SLURM_ARRAY_TASK_ID": "", "HOME": "/"}) is None


@pytest.mark.parametrize(
    ("environment", "text", "expected"),
    [
        ({"JOB_COMPLETION_INDEX": "0"}, "auto/3", Shard(1, 3)),
        ({"JOB_COMPLETION_INDEX": "2"}, "auto/3", Shard(3, 3)),
        ({"PBS_ARRAY_INDEX": "3"}, "auto/3", Shard(3, 3)),
        (slurm(5, 1, 8, 1, 8), "auto/16", Shard(5, 16)),
    ],
)
def test_where_the_size_is_not_told_it_is_given(
    environment: dict[str, str], text: str, expected: Shard
) -> None:
    assert parse_shard(text, environment) == expected


def test_arrays_that_make_no_sense_are_refused() -> None:
    for variable in ("JOB_COMPLETION_INDEX", "PBS_ARRAY_INDEX"):
        with pytest.raises(UsageError, match=f"{variable} is set.*auto/N"):
            shard_of_environment({variable: "1"})
    with pytest.raises(UsageError, match="share 9 of 8"):
        shard_of_environment(slurm(9, 1, 9, 1, 8))
    with pytest.raises(UsageError, match="not one of its array"):
        shard_of_environment(slurm(4, 1, 9, 2, 5))
    with pytest.raises(UsageError, match="not a number"):
        shard_of_environment({"SLURM_ARRAY_TASK_ID": "x"})
    with pytest.raises(UsageError, match="no variable of a job array"):
        parse_shard("auto/4", {})
    with pytest.raises(UsageError, match="share 5 of 4"):
        parse_shard("auto/4", {"JOB_COMPLETION_INDEX": "4"})


def test_every_share_has_a_state_of_its_own() -> None:
    assert Shard().state_name == "trimray-batch.sqlite"
    assert Shard(3, 16).state_name == "trimray-batch.3-of-16.sqlite"
    assert shard_of_state("trimray-batch.3-of-16.sqlite") == Shard(3, 16)
    for name in ("trimray-batch.sqlite", "trimray-batch.3-of-16.sqlite-wal", "x.3-of-16.sqlite"):
        assert shard_of_state(name) is None
