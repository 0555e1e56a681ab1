"""What OpenCascade's transfer of a STEP or IGES file says about its entities."""

from collections.abc import Iterator
from typing import Any

from OCP.Interface import Interface_CheckIterator


def checks(iterator: Interface_CheckIterator) -> Iterator[tuple[int, list[str], list[str]]]:
    """(entity number, fails, warnings) of every non-empty check."""
    iterator.Start()
    while iterator.More():
        check = iterator.Value()
        fails = fails_of(check)
        warnings = [message_text(check.CWarning(i)) for i in range(1, check.NbWarnings() + 1)]
        if fails or warnings:
            yield iterator.Number(), fails, warnings
        iterator.Next()


def fails_of(check: Any) -> list[str]:
    return [message_text(check.CFail(i)) for i in range(1, check.NbFails() + 1)]


def binders_of(process: Any) -> dict[Any, Any]:
    """What the transfer made of each entity it touched; process: Transfer_TransientProcess or None."""
    if process is None:
        return {}
    return {process.Mapped(i): process.MapItem(i) for i in range(1, process.NbMapped() + 1)}


def why_lost(binder: Any, untouched: str) -> str | None:
    """Why an entity gave no shape, None when it gave one. untouched: the reason where it has no binder."""
    if binder is None:
        return untouched
    if binder.HasResult():
        return None
    return "; ".join(fails_of(binder.Check())[:3]) or "OpenCascade made no face of it"


def message_text(message: object) -> str:
    return message if isinstance(message, str) else str(getattr(message, "ToCString", lambda: message)())
