"""Chunks of a cluster's batch: their sizes, and what becomes of those that come back undone."""

from __future__ import annotations

from collections.abc import Iterator

from trimray.batch.chunks import CHUNK_BYTES, DEATHS, RETURNS, Chunk, Stock
from trimray.batch.record import Item


def items(count: int, size: int = 1000) -> list[Item]:
    return [Item(f"{i}.step", f"{i}.png", size) for i in range(count)]


def all_of(stock: Stock, takers: int) -> list[Chunk]:
    return list(iter(lambda: stock.next(takers), None))


def test_chunks_hold_every_item_once_in_order() -> None:
    chunks = all_of(Stock(items(1000), 32, 1), takers=4)
    assert [item for chunk in chunks for item in chunk.items] == items(1000)


def test_chunks_are_full_first_and_single_at_last() -> None:
    sizes = [len(chunk.items) for chunk in all_of(Stock(items(1000), 32, 1), takers=4)]
    assert sizes[0] == 32
    assert sizes[-4:] == [1, 1, 1, 1]
    assert sizes == sorted(sizes, reverse=True)


def test_few_items_are_shared_by_all_takers() -> None:
    assert all(len(chunk.items) == 1 for chunk in all_of(Stock(items(10), 32, 1), takers=8))


def test_large_files_go_one_by_one() -> None:
    large, small = items(5, CHUNK_BYTES), items(200)
    sizes = [len(chunk.items) for chunk in all_of(Stock(large + small, 16, 1), takers=2)]
    assert sizes[:5] == [1, 1, 1, 1, 1]
    assert sizes[5] == 16


def test_items_are_taken_as_they_are_needed() -> None:
    taken = 0

    def endless() -> Iterator[Item]:
        nonlocal taken
        while True:
            taken += 1
            yield Item("x.step", f"{taken}.png", 10)

    stock = Stock(endless(), 32, 1)
    for _ in range(10):
        assert stock.next(3) is not None
    assert taken <= 10 * 32 + 2 * 3 * 32


def test_after_a_death_what_was_being_drawn_goes_alone() -> None:
    stock = Stock([], 32, 2)
    chunk = Chunk(items(6), begun=True, finished={0, 2})
    assert stock.give_back(chunk) == []
    rest = items(6)
    assert [c.items for c in all_of(stock, 1)] == [[rest[1]], [rest[3]], [rest[4], rest[5]]]


def test_a_file_that_costs_several_workers_is_failed() -> None:
    stock = Stock([], 32, 1)
    assert stock.give_back(Chunk(items(3), begun=True)) == []
    suspect = stock.next(1)
    for _ in range(DEATHS - 2):
        assert suspect is not None
        suspect.begun = True
        assert stock.give_back(suspect) == []
        others, suspect = stock.next(1), stock.next(1)
        assert others is not None and len(others.items) == 2
        stock.give_back(others)
    assert suspect is not None and suspect.items == items(1)
    suspect.begun = True
    (outcome,) = stock.give_back(suspect)
    assert outcome.status == "failed"
    assert outcome.exit_code == 3
    assert outcome.reason == f"the worker died, {DEATHS} times while drawing it"


def test_a_chunk_that_nobody_began_is_not_blamed() -> None:
    stock = Stock(items(4), 4, 1)
    chunk = Chunk(items(4))
    for _ in range(RETURNS):
        assert stock.give_back(chunk) == []
        again = stock.next(1)
        assert again is not None and again.items == items(4)
        chunk = again
    outcomes = stock.give_back(chunk)
    assert [outcome.status for outcome in outcomes] == ["failed"] * 4
    assert "before they began" in outcomes[0].reason


def test_a_finished_chunk_leaves_nothing() -> None:
    stock = Stock([], 4, 1)
    assert stock.give_back(Chunk(items(2), begun=True, finished={0, 1})) == []
    assert stock.next(1) is None
