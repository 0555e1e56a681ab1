"""The manual, made from the table of options: `python -m trimray.cli.manual table|man`.

The table stands in docs/cli.md between its two marks, the manual page is docs/trimray.1; a test keeps both
current.
"""

from __future__ import annotations

import sys

from .option import Option
from .options import OPTIONS

EXIT_CODES = (
    (0, "complete"),
    (1, "done, but some faces could not be drawn, the file is damaged, or some inputs of several failed"),
    (2, "wrong usage"),
    (3, "input unreadable, or without a face that can be drawn"),
    (4, "output not written"),
    (5, "time or memory limit reached"),
    (6, "nothing to do: batch found no file"),
    (7, "differences found by check, roundtrip or compare"),
    (70, "internal error"),
    (130, "interrupted"),
)
_COMMANDS = (
    ("render IN... -o OUT", "Draw IN to OUT. Faces that cannot be drawn are named on stderr."),
    (
        "turntable IN... -o OUT",
        "Draw one full turn of IN to OUT: an animated WebP or GIF, or numbered pictures, such as %04d.png.",
    ),
    ("mesh IN... -o OUT", "Write a watertight mesh of IN to OUT, within --deviation of the exact surfaces."),
    ("info IN... [--json]", "Say what is in each IN."),
    ("bench IN... [--json]", "Say what each IN costs to draw, by tracer."),
    ("check IN...", "Hold each IN against itself: what it declares against what arrived, and what is wrong."),
    ("roundtrip IN...", "Write each IN, read the written bytes back, and compare both; then once more."),
    ("compare A B", "Compare two models."),
    (
        "batch PATH... -o DIR",
        "Draw every model in PATH to a picture of its own in DIR, each in isolation; unchanged ones stay.",
    ),
    ("batch merge DIR", "Join what the shards of a batch know."),
    (
        "thumbnailer install|uninstall [--user|--system]",
        "Register trimray-thumbnailer and the types of models with file managers, or take that back.",
    ),
    ("thumbnailer cache DIR...", "Make the thumbnails of all models in folders ahead."),
    ("doctor", "Check that everything trimray needs is there and works."),
    ("completion bash|zsh|fish", "Print a completion script."),
    ("--version", "Print versions."),
)


def options_table() -> str:
    """Markdown: flag, where it may be set, default, meaning."""
    lines = ["| option | of | default | meaning |", "|---|---|---|---|"]
    for option in OPTIONS:
        flags = ", ".join(f"`{flag}`" for flag in _flags(option)).replace("|", "\\|")
        values = f": one of `{' '.join(option.choices)}`" if option.choices else ""
        only = "" if option.config else " Not in the configuration file."
        text = f"{option.help.rstrip('.')}{values}.{only}".replace("|", "\\|")
        lines.append(f"| {flags} | {', '.join(option.commands)} | {_default(option)} | {text} |")
    return "\n".join(lines) + "\n"


def man_page() -> str:
    """The manual page in man(7) macros."""
    lines = [
        '.TH TRIMRAY 1 "" "trimray" "User Commands"',
        ".SH NAME",
        "trimray \\- exact pictures of STEP and IGES files, and watertight meshes of them",
        ".SH SYNOPSIS",
    ]
    for usage, about in _COMMANDS:
        lines += [".TP", f".B trimray {_roff(usage)}", _roff(about)]
    lines += [
        ".SH DESCRIPTION",
        "IN is a STEP, IGES, BREP, STL, OBJ, PLY or OFF file, also compressed, or \\- for stdin.",
        "Files of triangles have no unit: theirs is taken as mm.",
        "OUT is a PNG, JPEG, WebP, TIFF or EXR file, for mesh an STL, PLY, OBJ, OFF or GLB file, and holds",
        "all IN together; a folder, or a path with {name}, takes each IN by itself;",
        "\\- is stdout, which carries data only.",
        "PATH is a file, or a folder that is searched for them.",
        ".SH OPTIONS",
    ]
    for option in OPTIONS:
        lines.append(".TP")
        lines.append(f".B {_roff(', '.join(_flags(option)))}")
        choices = f" One of {', '.join(option.choices)}." if option.choices else ""
        default = f" Default: {option.default}." if isinstance(option.default, str) else ""
        default += "".join(
            f" Default of {command}: {'off' if value is False else value}."
            for command, value in option.defaults.items()
        )
        lines.append(_roff(f"({', '.join(option.commands)}) {option.help}{choices}{default}"))
    lines.append(".SH EXIT STATUS")
    for code, meaning in EXIT_CODES:
        lines += [".TP", f".B {code}", _roff(meaning[0].upper() + meaning[1:] + ".")]
    lines += [
        ".SH ENVIRONMENT",
        _roff("TRIMRAY_NAME sets the option --name; NO_COLOR and FORCE_COLOR decide on colour;"),
        _roff("SOURCE_DATE_EPOCH is the date in a picture, which otherwise bears none."),
        ".SH FILES",
        ".TP",
        _roff("$XDG_CONFIG_HOME/trimray/config.toml"),
        _roff('Options by name, such as size = "1024,768"; the environment and the command line come first.'),
        ".TP",
        _roff("$XDG_CACHE_HOME/trimray"),
        "Imported models. Safe to delete.",
    ]
    return "\n".join(lines) + "\n"


def _flags(option: Option) -> list[str]:
    """As they are typed, the last one with what it takes."""
    flags = [*option.flags]
    if option.metavar or option.choices:
        flags[-1] += f" {option.metavar or option.name.upper()}"
    return flags


def _default(option: Option) -> str:
    texts = [_default_text(option.default)]
    texts += [f"{command}: {_default_text(value)}" for command, value in option.defaults.items()]
    return "; ".join(text for text in texts if text)


def _default_text(value: str | bool | None) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return "" if value is None else f"`{value}`"


def _roff(text: str) -> str:
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


if __name__ == "__main__":
    sys.stdout.write(man_page() if sys.argv[1:] == ["man"] else options_table())
