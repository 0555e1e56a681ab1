"""The one table of options: command line, environment (TRIMRAY_*), configuration file and manual are made
from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Option:
    """name: key in the configuration file; TRIMRAY_NAME in the environment. parse: the text to the value;
    raises trimray.UsageError. config: may stand in the configuration file and the environment."""

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


def _size(text: str) -> object:
    from trimray.views import parse_size

    return parse_size(text)


def _view(text: str) -> object:
    from trimray.views import parse_view

    parse_view(text)
    return text


def _samples(text: str) -> object:
    from trimray.views import parse_samples

    return parse_samples(text)


def _occlusion(text: str) -> object:
    from trimray.views import MAX_OCCLUSION_RAYS, parse_count

    return parse_count("ambient_occlusion", text, MAX_OCCLUSION_RAYS)


def _reflections(text: str) -> object:
    from trimray.views import MAX_REFLECTIONS, parse_count

    return parse_count("reflections", text, MAX_REFLECTIONS)


def _background(text: str) -> object:
    from trimray.views import parse_background

    parse_background(text)
    return text


def _aov(text: str) -> object:
    from trimray.views import parse_aovs

    parse_aovs(text)
    return text


def _up(text: str) -> object:
    from trimray.views import UP_AXES, choose

    return choose("up", text.lower().lstrip("+"), UP_AXES)


def _format(text: str) -> object:
    from trimray.formats import format_of

    return format_of("", text)


def _usage(message: str) -> Exception:
    from trimray import UsageError

    return UsageError(message)


def _number(text: str, units: dict[str, float], what: str) -> float:
    body = text.strip().lower()
    factor = 1.0
    for unit in sorted(units, key=len, reverse=True):
        if body.endswith(unit):
            body, factor = body[: -len(unit)], units[unit]
            break
    try:
        value = float(body) * factor
    except ValueError:
        value = -1.0
    if not 0.0 < value < float("inf"):
        raise _usage(f"'{text}' is not {what}")
    return value


def _seconds(text: str) -> object:
    return _number(text, {"s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0}, "a positive time, such as 30 or 2m")


def _bytes(text: str) -> object:
    powers = {"k": 10, "m": 20, "g": 30}
    units = {letter + tail: float(1 << power) for letter, power in powers.items() for tail in ("", "b", "ib")}
    return int(_number(text, units, "a positive size in bytes, such as 500M or 2G"))


def _mm(text: str) -> object:
    return _number(text, {"mm": 1.0}, "a positive length in mm")


def _repeat(text: str) -> object:
    if not text.strip().isdigit() or int(text) < 1:
        raise _usage(f"'{text}' is not a number of pictures")
    return int(text)


def _jobs(text: str) -> object:
    if not text.strip().isdigit():
        raise _usage(f"'{text}' is not a number of threads")
    return int(text)


def _mesh_format(text: str) -> object:
    from trimray.formats import mesh_format_of

    return mesh_format_of("", text)


def _deviation(text: str) -> object:
    from trimray.tri_mesh import parse_deviation

    parse_deviation(text)
    return text


def _degrees(text: str) -> object:
    return _number(text, {"deg": 1.0, "°": 1.0}, "a positive angle in degrees")


_ALL = ("render", "mesh", "info", "bench")
_WRITING = ("render", "mesh")
_VIEWING = ("render", "mesh", "bench")

OPTIONS: tuple[Option, ...] = (
    Option(
        "output",
        ("-o", "--output"),
        "File to write, of all inputs together; a folder, or a path with {name}, takes each by itself; "
        "- is stdout.",
        "OUT",
        config=False,
        commands=_WRITING,
    ),
    Option(
        "size",
        ("--size",),
        "Picture size in pixels; one number is a square.",
        "W,H",
        "512,512",
        parse=_size,
        commands=_VIEWING,
    ),
    Option(
        "view",
        ("--view",),
        "iso, front, back, left, right, top, bottom, or azimuth and elevation in degrees.",
        "NAME|AZ,EL",
        "iso",
        parse=_view,
        commands=_VIEWING,
    ),
    Option(
        "up",
        ("--up",),
        "Axis of the model that points up: z, y, x, -z, -y, -x.",
        "AXIS",
        "z",
        parse=_up,
        commands=_VIEWING,
    ),
    Option(
        "projection",
        ("--projection",),
        "Parallel or central projection.",
        default="orthographic",
        choices=("orthographic", "perspective"),
        commands=_VIEWING,
    ),
    Option("samples", ("--samples",), "Rays per pixel.", "N", "4", parse=_samples),
    Option(
        "background",
        ("--background",),
        "A colour (name or #rrggbb[aa]), two for a gradient from top to bottom, or transparent.",
        "COLOR[,COLOR]",
        "white",
        parse=_background,
    ),
    Option(
        "format",
        ("--format",),
        "png, jpeg, webp, tiff or exr; by default OUT's extension, else png.",
        "NAME",
        parse=_format,
    ),
    Option(
        "mesh_format",
        ("--format",),
        "stl, ply, obj, off or glb; by default OUT's extension, else stl.",
        "NAME",
        parse=_mesh_format,
        commands=("mesh",),
    ),
    Option(
        "deviation",
        ("--deviation",),
        "Largest distance of the mesh from the exact surfaces: 0.05mm, 0.1% of the model's diagonal, or "
        "0.3px of the picture that --view, --size, --projection and --up make, for which alone the mesh is.",
        "MM|%|PX",
        "0.1%",
        parse=_deviation,
        commands=("mesh",),
    ),
    Option(
        "angle",
        ("--angle",),
        "Largest turn of the surface along a triangle's side; default: any.",
        "DEGREES",
        parse=_degrees,
        commands=("mesh",),
    ),
    Option(
        "aov",
        ("--aov",),
        "Planes to write, of: color depth position normal uv face instance time seed_id seed_uv. Several "
        "need exr; one other than color is shown in false colours elsewhere.",
        "NAME[,NAME]",
        "color",
        parse=_aov,
        multiple=True,
    ),
    Option(
        "orientation",
        ("--orientation/--no-orientation",),
        "Tint faces that turn their inner side to the eye.",
        default=False,
        flag=True,
    ),
    Option(
        "shadows",
        ("--shadows/--no-shadows",),
        "Shadows of the two lamps that stand beside the camera.",
        default=False,
        flag=True,
    ),
    Option(
        "ambient_occlusion",
        ("--ambient-occlusion",),
        "Rays per sample, such as 16, that darken corners into which little light comes; 0 for none.",
        "N",
        "0",
        parse=_occlusion,
    ),
    Option(
        "reflections",
        ("--reflections",),
        "Reflections, as of polished parts: number of bounces; 0 for none.",
        "N",
        "0",
        parse=_reflections,
    ),
    Option(
        "mode",
        ("--mode",),
        "Tracer; all give the same picture. reference is the slow one that judges the others.",
        default="hybrid",
        choices=("hybrid", "standard", "reference"),
    ),
    Option(
        "seeds",
        ("--seeds",),
        "What draws a coarse mesh first, to tell the hybrid tracer where to look; the picture is the same.",
        default="auto",
        choices=("auto", "none", "osmesa", "egl", "embree"),
        commands=("render", "bench"),
    ),
    Option(
        "seed_process",
        ("--seed-process",),
        "Seeds interpolate uv, or are the mean of a triangle's corners.",
        default="uv",
        choices=("uv", "id"),
    ),
    Option(
        "repeat",
        ("--repeat",),
        "Pictures a figure; it is their median.",
        "N",
        "5",
        parse=_repeat,
        config=False,
        commands=("bench",),
    ),
    Option(
        "heal",
        ("--heal",),
        "Repairs on import: OpenCascade's own, none, or its own with every change reported.",
        default="default",
        choices=("default", "off", "strict"),
        commands=_ALL,
    ),
    Option(
        "precision",
        ("--precision",),
        "Below this length points are equal and IGES faces are sewn; default: the file's.",
        "MM",
        parse=_mm,
        commands=_ALL,
    ),
    Option(
        "time_limit",
        ("--time-limit",),
        "Longest time for one input.",
        "SECONDS",
        parse=_seconds,
        commands=_ALL,
    ),
    Option(
        "memory_limit",
        ("--memory-limit",),
        "Most memory for reading one input.",
        "BYTES",
        parse=_bytes,
        commands=_ALL,
    ),
    Option(
        "jobs",
        ("-j", "--jobs"),
        "Threads; 0 for all cores. The output is the same for any number.",
        "N",
        "0",
        parse=_jobs,
        commands=_WRITING,
    ),
    Option(
        "cache",
        ("--cache/--no-cache",),
        "Keep imported models under $XDG_CACHE_HOME/trimray, and use them.",
        default=True,
        flag=True,
        commands=_ALL,
    ),
    Option(
        "report",
        ("--report",),
        "Write what became of every input as JSON; - is stdout.",
        "FILE",
        config=False,
        commands=_WRITING,
    ),
    Option(
        "dry_run",
        ("--dry-run",),
        "Say what would be written, and stop.",
        default=False,
        flag=True,
        config=False,
        commands=_WRITING,
    ),
    Option(
        "json", ("--json",), "Print JSON.", default=False, flag=True, config=False, commands=("info", "bench")
    ),
    Option(
        "progress",
        ("--progress",),
        "auto is a bar on a terminal, otherwise none.",
        default="auto",
        choices=("auto", "none", "plain", "json"),
        commands=_ALL,
    ),
    Option("quiet", ("-q", "--quiet"), "Errors only.", default=False, flag=True, commands=_ALL),
    Option(
        "verbose",
        ("-v", "--verbose"),
        "Say more: times, warnings; twice: notes, tracebacks of internal errors.",
        count=True,
        config=False,
        commands=_ALL,
    ),
    Option(
        "print_config",
        ("--print-config",),
        "Print the options in force as a configuration file, and stop.",
        default=False,
        flag=True,
        config=False,
        commands=_ALL,
    ),
)


def options_of(command: str) -> tuple[Option, ...]:
    return tuple(option for option in OPTIONS if command in option.commands)
