"""The commands and their arguments; what they do stands in the modules named after them."""

from __future__ import annotations

import importlib
from typing import Any

import click

from . import config
from .option import Option
from .options import options_of
from .output import speak_json

_CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


class _Text(click.ParamType):  # type: ignore[type-arg,unused-ignore]  # generic since click 8.4
    """A value that the table's parse function checks."""

    def __init__(self, option: Option) -> None:
        self.name = option.metavar or "text"
        self._parse = option.parse
        self._flag, self._key = option.flags[-1], f"{option.name}: "

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if self._parse is None or not isinstance(value, str):
            return value
        from trimray import UsageError

        try:
            return self._parse(value)
        except UsageError as error:
            raise click.UsageError(f"{self._flag}: {str(error).removeprefix(self._key)}", ctx) from None


def _parameter(option: Option, command: str) -> click.Option:
    envvar = f"TRIMRAY_{option.name.upper()}" if option.config else None
    common: dict[str, Any] = {"help": option.help, "envvar": envvar, "show_envvar": False}
    flags = [*option.flags, option.name]
    if option.count:
        return click.Option(flags, count=True, **common)
    if option.flag:
        return click.Option(flags, is_flag=True, default=option.default_of(command), **common)
    kind: Any = click.Choice(option.choices) if option.choices else _Text(option)
    default: Any = option.default_of(command)
    shown = default is not None
    if option.multiple:
        default = [default] if shown else []
    return click.Option(
        flags,
        type=kind,
        default=default,
        metavar=option.metavar or None,
        multiple=option.multiple,
        show_default=shown,
        **common,
    )


class _Command(click.Command):
    """A command whose options come from the table, and their defaults from the configuration file."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> click.Context:
        if "-h" not in args and "--help" not in args:
            extra.setdefault("default_map", config.read())
        return super().make_context(info_name, args, parent, **extra)


class _Group(click.Group):
    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            from trimray.views import did_you_mean

            known = self.list_commands(ctx)
            hint = did_you_mean(name, known) or f", one of: {', '.join(known)}"
            raise click.UsageError(f"unknown command '{name}'{hint}", ctx)
        return super().resolve_command(ctx, args)


def _version(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    if value and not context.resilient_parsing:
        from .doctor import version_text
        from .output import write_stdout

        write_stdout(version_text())
        context.exit(0)


@click.group(cls=_Group, context_settings=_CONTEXT)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_version,
    help="Versions, and exit.",
)
def app() -> None:
    """Exact pictures of STEP and IGES files, and watertight meshes of them.

    Exit codes: 0 complete; 1 done, but something is missing; 2 wrong usage; 3 input unreadable or without
    faces; 4 output not written; 5 time or memory limit; 6 nothing to do; 7 differences found; 70 internal
    error; 130 interrupted.
    """


def _command(name: str, about: str, metavar: str = "IN...", *, given: bool = False) -> None:
    """Runs ``run`` of the module of that name, which is imported when it is wanted.

    metavar: of the inputs; without them only the command itself knows whether that is wrong, where they
    are optional. given: it wants to know which options stand on the command line."""
    parameters: list[click.Parameter] = [click.Argument(["inputs"], nargs=-1, metavar=metavar)]
    parameters += [_parameter(option, name) for option in options_of(name)]

    def callback(**values: Any) -> int:
        context = click.get_current_context()
        if values.pop("print_config"):
            from .output import write_stdout

            write_stdout(config.show(context, name))
            return 0
        speak_json(values["progress"] == "json")
        if not values["inputs"] and not metavar.startswith("["):
            raise click.UsageError("missing input: give a file, or - for stdin", context)
        if given:
            values["given"] = _given(context, values)
        code: int = importlib.import_module(f".{name}", __package__).run(**values)
        return code

    app.add_command(
        _Command(name, params=parameters, callback=callback, help=about, context_settings=_CONTEXT)
    )


def _given(context: click.Context, values: dict[str, Any]) -> set[str]:
    """Names of those that stand on the command line."""
    sources = {name: context.get_parameter_source(name) for name in values}
    return {name for name, source in sources.items() if source is not None and source.name == "COMMANDLINE"}


_command(
    "render",
    "Draw IN (STEP, IGES, BREP, STL, OBJ, PLY, OFF, also compressed; - for stdin) to OUT: several of them as "
    "one scene, or each by itself into a folder.\n\n"
    "Faces that cannot be drawn are named on stderr.",
)
_command(
    "turntable",
    "Draw one full turn of IN to OUT: an animated WebP or GIF, or numbered pictures (frames/%04d.png), all "
    "of one framing.",
)
_command(
    "mesh",
    "Write a watertight mesh of IN to OUT (STL, PLY, OBJ, OFF, GLB), no farther from the exact surfaces than "
    "--deviation: several IN as one mesh, or each by itself into a folder.\n\n"
    "Faces that cannot be meshed are named on stderr.",
)
_command(
    "info",
    "Say what is in each IN: faces by kind, parts, unit, bounds, colours, what cannot be drawn.",
)
_command(
    "bench",
    "Say what each IN costs to draw: surfaces, triangles, boxes, intersections and frames per second of the "
    "standard and the hybrid tracer.",
)
_command(
    "check",
    "Hold each IN against itself: what the file declares (entities, volumes, areas, centroids) against what "
    "arrived, faces that OpenCascade finds wrong, open and loose edges, gaps. Exit code 7 where something is "
    "wrong.",
)
_command(
    "roundtrip",
    "Write each IN, read the written bytes back, and compare both: structure, topology, mass, geometry and "
    "pictures; then once more. Exit code 7 where something differs.",
)
_command(
    "compare",
    "Compare two models: structure, topology, mass, geometry and pictures. Exit code 7 where they differ.",
    "A B",
)
_command(
    "batch",
    "Draw every model in the files and folders PATH to a picture of its own in DIR, each in isolation, so "
    "that one that crashes, hangs or wants too much memory costs that one alone. Pictures of unchanged files "
    "stay.\n\n"
    "trimray batch merge DIR joins what the shards of a run (--shard) know. A folder named so is ./merge.",
    "[PATH...]",
    given=True,
)
_command(
    "thumbnailer",
    "install and uninstall register trimray-thumbnailer and the types of models with file managers, or take "
    "that back (--user, --system, --dry-run).\n\n"
    "cache DIR... makes the thumbnails of all models in folders ahead (--size, -j, --time-limit, "
    "--memory-limit), in the cache that file managers share.",
    "install|uninstall|cache DIR...",
    given=True,
)


@app.command(context_settings=_CONTEXT)
def doctor() -> int:
    """Check that everything trimray needs is there and works."""
    from .doctor import run

    return run()


@app.command(context_settings=_CONTEXT)
@click.argument("shell", type=click.Choice(("bash", "zsh", "fish")))
def completion(shell: str) -> int:
    """Print the completion script of a shell: eval "$(trimray completion bash)"."""
    from click.shell_completion import get_completion_class

    from .output import write_stdout

    maker = get_completion_class(shell)
    assert maker is not None
    write_stdout(maker(app, {}, "trimray", "_TRIMRAY_COMPLETE").source())
    return 0
