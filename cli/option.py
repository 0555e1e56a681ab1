"""A row of the table of options."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Option:
    """name: key in the configuration file; TRIMRAY_NAME in the environment. parse: the text to the value;
    raises trimray.UsageError. config: may stand in the configuration file and the environment. defaults: of
    commands that have one of their own."""

    name: str
    flags: tuple[str, ...]
    help: str
    metavar: str = ""
    default: str | bool | None = None
    choices: tuple[str, ...] = ()
    parse: Callable[[str], Any] | None = None
    flag: bool = False
    count: bool = False
    multiple: bool = False
    config: bool = True
    commands: tuple[str, ...] = ("render",)
    defaults: Mapping[str, str | bool | None] = field(default_factory=dict)

    def default_of(self, command: str) -> str | bool | None:
        return self.defaults.get(command, self.default)
