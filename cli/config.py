"""The configuration file: $XDG_CONFIG_HOME/trimray/config.toml, keys as in the table of options."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import click

from .options import OPTIONS, options_of


def path() -> Path:
    """$XDG_CONFIG_HOME/trimray/config.toml, by default under ~/.config."""
    base = os.environ.get("XDG_CONFIG_HOME", "")
    return (Path(base) if os.path.isabs(base) else Path.home() / ".config") / "trimray" / "config.toml"


def read() -> dict[str, Any]:
    """Option name to value (text, or bool for flags); {} when there is no file. Raises click.UsageError."""
    try:
        text = path().read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError, RuntimeError):
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise click.UsageError(f"{path()}: {getattr(error, 'strerror', None) or error}") from None
    import tomllib

    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise click.UsageError(f"{path()}: {error}") from None
    known = {option.name: option for option in OPTIONS if option.config}
    result: dict[str, Any] = {}
    for key, value in values.items():
        name = key.replace("-", "_")
        if name not in known:
            from trimray.views import did_you_mean

            raise click.UsageError(f"{path()}: unknown option '{key}'{did_you_mean(name, known)}")
        result[name] = _as_text(key, value, known[name].flag, known[name].multiple)
    return result


def _as_text(key: str, value: object, flag: bool, multiple: bool) -> Any:
    if flag or isinstance(value, bool):
        if not (flag and isinstance(value, bool)):
            raise click.UsageError(f"{path()}: {key} is {'true or false' if flag else 'not true or false'}")
        return value
    if isinstance(value, list):
        value = ",".join(str(x) for x in value)
    if not isinstance(value, str | int | float):
        raise click.UsageError(f"{path()}: {key} is not a value")
    return [str(value)] if multiple else str(value)


def show(context: click.Context, command: str) -> str:
    """The options in force as TOML, each with where it comes from."""
    lines = [f"# trimray {command}: options in force. Configuration file: {path()}"]
    for option in options_of(command):
        if not option.config:
            continue
        value = context.params[option.name]
        source = context.get_parameter_source(option.name)
        origin = {
            "COMMANDLINE": "command line",
            "ENVIRONMENT": f"TRIMRAY_{option.name.upper()}",
            "DEFAULT_MAP": "file",
        }
        where = origin.get(source.name if source else "", "default")
        if value is None or value == ():
            lines.append(f"# {option.name} is not set")
        else:
            lines.append(f"{option.name} = {_toml(value)}  # {where}")
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, tuple):
        value = ",".join(str(x) for x in value)
    return json.dumps(str(value), ensure_ascii=False)
