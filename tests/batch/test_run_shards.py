"""Shards of one batch, and what merging their states makes of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from trimray import OutputError, UsageError
from trimray.batch import Summary
from trimray.batch.merge import merge
from trimray.batch.shard import Shard

from .run_stand_in import Drawer, rows


def test_shards_make_the_whole(
    go: Callable[..., Summary], draw: Drawer, library: Path, tmp_path: Path
) -> None:
    for k in range(40):
        (library / f"n{k}.step").write_text(f"good {k}")
    for k in (1, 3):
        go(shard=Shard(k, 3))
    merged = merge(str(tmp_path / "out"))
    assert merged.missing == [Shard(2, 3)] and merged.summary.exit_code == 1
    draw.stop_after = 1
    with pytest.raises(KeyboardInterrupt):
        go(shard=Shard(2, 3))
    draw.stop_after = None
    merged = merge(str(tmp_path / "out"))
    assert merged.unfinished == [Shard(2, 3)] and merged.missing == []
    assert merged.summary.statuses["pending"] > 0
    go(shard=Shard(2, 3), resume=True)
    assert len(draw.names) == 44
    merged = merge(str(tmp_path / "out"))
    assert merged.missing == merged.unfinished == []
    assert merged.summary.total == 44 and merged.summary.statuses == {"complete": 43, "failed": 1}
    assert merged.summary.exit_code == 1
    # A run without shards knows what the shards knew.
    assert go().skipped == 44 and draw.names == []


def test_what_was_drawn_after_the_shards_is_not_forgotten(
    go: Callable[..., Summary], library: Path, tmp_path: Path
) -> None:
    for k in (1, 2):
        go(shard=Shard(k, 2))
    merge(str(tmp_path / "out"))
    (library / "a.step").write_text("bad now")
    go()
    merged = merge(str(tmp_path / "out"))
    assert merged.summary.statuses == {"complete": 2, "failed": 2}
    assert rows(merged.summary)["a.step"].reason == "no model"


def test_shards_agree_on_pictures_that_would_clash(
    go: Callable[..., Summary], library: Path, tmp_path: Path
) -> None:
    (library / "a.iges").write_text("good iges")
    for k in range(1, 9):
        go(shard=Shard(k, 8))
    assert (tmp_path / "out/a.step.png").read_text() == "good a"
    assert (tmp_path / "out/a.iges.png").read_text() == "good iges"


def test_an_empty_share_is_no_failure(go: Callable[..., Summary], library: Path) -> None:
    summaries = [go([str(library / "a.step")], shard=Shard(k, 3)) for k in (1, 2, 3)]
    assert [s.exit_code for s in summaries] == [0, 0, 0] and sum(s.total for s in summaries) == 1


def test_what_cannot_be_merged_is_refused(go: Callable[..., Summary], tmp_path: Path) -> None:
    go()
    with pytest.raises(UsageError, match="no state of a shard"):
        merge(str(tmp_path / "out"))
    go(shard=Shard(1, 2))
    go(shard=Shard(1, 3))
    with pytest.raises(UsageError, match="states of 2 and 3 shards"):
        merge(str(tmp_path / "out"))
    with pytest.raises(OutputError, match="No such file"):
        merge(str(tmp_path / "nowhere"))
