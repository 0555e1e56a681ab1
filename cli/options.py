"""The one table of options: command line, environment (TRIMRAY_*), configuration file and manual are made
from it."""

from __future__ import annotations

from . import values
from .batch_options import BATCH_OPTIONS
from .fidelity_options import FIDELITY, FIDELITY_OPTIONS
from .option import Option
from .thumbnailer_options import THUMBNAILER_OPTIONS

_ALL = ("render", "turntable", "mesh", "info", "bench", *FIDELITY, "batch")
_ANY = (*_ALL, "thumbnailer")
_WRITING = ("render", "turntable", "mesh")
_VIEWING = (*_WRITING, "bench", "batch")
_DRAWING = ("render", "turntable")
_PLAIN = (*_DRAWING, "batch")

_FIRST: tuple[Option, ...] = (
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
        parse=values.size,
        commands=_VIEWING,
        defaults={"batch": "256,256"},
    ),
    Option(
        "view",
        ("--view",),
        "iso, front, back, left, right, top, bottom, or azimuth and elevation in degrees.",
        "NAME|AZ,EL",
        "iso",
        parse=values.view,
        commands=_VIEWING,
    ),
    Option(
        "up",
        ("--up",),
        "Axis of the model that points up: z, y, x, -z, -y, -x.",
        "AXIS",
        "z",
        parse=values.up,
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
    Option("samples", ("--samples",), "Rays per pixel.", "N", "4", parse=values.samples, commands=_PLAIN),
    Option(
        "background",
        ("--background",),
        "A colour (name or #rrggbb[aa]), two for a gradient from top to bottom, or transparent.",
        "COLOR[,COLOR]",
        "white",
        parse=values.background,
        commands=_PLAIN,
    ),
    Option(
        "format",
        ("--format",),
        "png, jpg, webp, tiff or exr; by default the extension of OUT, or of --template, else png.",
        "NAME",
        parse=values.format,
        commands=("render", "batch"),
    ),
    Option(
        "sequence_format",
        ("--format",),
        "webp or gif; png, jpg, webp, tiff or exr where OUT has a number in it, such as %04d; by default "
        "OUT's extension, else webp.",
        "NAME",
        parse=values.sequence_format,
        commands=("turntable",),
    ),
    Option(
        "frames",
        ("--frames",),
        "Pictures of one full turn.",
        "N",
        "60",
        parse=values.frames,
        commands=("turntable",),
    ),
    Option(
        "fps",
        ("--fps",),
        "Frames a second of webp and gif.",
        "N",
        "30",
        parse=values.fps,
        commands=("turntable",),
    ),
    Option(
        "mesh_format",
        ("--format",),
        "stl, ply, obj, off or glb; by default OUT's extension, else stl.",
        "NAME",
        parse=values.mesh_format,
        commands=("mesh",),
    ),
    Option(
        "deviation",
        ("--deviation",),
        "Largest distance of the mesh from the exact surfaces: 0.05mm, 0.1% of the model's diagonal, or "
        "0.3px of the picture that --view, --size, --projection and --up make, for which alone the mesh is.",
        "MM|%|PX",
        "0.1%",
        parse=values.deviation,
        commands=("mesh",),
    ),
    Option(
        "angle",
        ("--angle",),
        "Largest turn of the surface along a triangle's side; default: any.",
        "DEGREES",
        parse=values.degrees,
        commands=("mesh",),
    ),
    Option(
        "aov",
        ("--aov",),
        "Planes to write, of: color depth position normal uv face instance time seed_id seed_uv. Several "
        "need exr; one other than color is shown in false colours elsewhere.",
        "NAME[,NAME]",
        "color",
        parse=values.aov,
        multiple=True,
        commands=_DRAWING,
    ),
    Option(
        "orientation",
        ("--orientation/--no-orientation",),
        "Tint faces that turn their inner side to the eye.",
        default=False,
        flag=True,
        commands=_DRAWING,
    ),
    Option(
        "shadows",
        ("--shadows/--no-shadows",),
        "Shadows of the two lamps that stand beside the camera.",
        default=False,
        flag=True,
        commands=_DRAWING,
    ),
    Option(
        "ambient_occlusion",
        ("--ambient-occlusion",),
        "Rays per sample, such as 16, that darken corners into which little light comes; 0 for none.",
        "N",
        "0",
        parse=values.occlusion,
        commands=_DRAWING,
    ),
    Option(
        "reflections",
        ("--reflections",),
        "Reflections, as of polished parts: number of bounces; 0 for none.",
        "N",
        "0",
        parse=values.reflections,
        commands=_DRAWING,
    ),
    Option(
        "mode",
        ("--mode",),
        "Tracer; all give the same picture. reference is the slow one that judges the others.",
        default="hybrid",
        choices=("hybrid", "standard", "reference"),
        commands=_DRAWING,
    ),
    Option(
        "seeds",
        ("--seeds",),
        "What draws a coarse mesh first, to tell the hybrid tracer where to look; the picture is the same.",
        default="auto",
        choices=("auto", "none", "osmesa", "egl", "embree"),
        commands=(*_DRAWING, "bench"),
    ),
    Option(
        "seed_process",
        ("--seed-process",),
        "Seeds interpolate uv, or are the mean of a triangle's corners.",
        default="uv",
        choices=("uv", "id"),
        commands=_DRAWING,
    ),
    Option(
        "repeat",
        ("--repeat",),
        "Pictures a figure; it is their median.",
        "N",
        "5",
        parse=values.repeat,
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
        parse=values.mm,
        commands=_ALL,
    ),
    Option(
        "time_limit",
        ("--time-limit",),
        "Longest time for one input, or none.",
        "SECONDS",
        parse=values.seconds,
        commands=_ANY,
        defaults={"batch": "30", "thumbnailer": "30"},
    ),
    Option(
        "memory_limit",
        ("--memory-limit",),
        "Most memory for reading one input, or none; of batch and thumbnailer, for drawing it too.",
        "BYTES",
        parse=values.bytes,
        commands=_ANY,
        defaults={"batch": "2G", "thumbnailer": "2G"},
    ),
    Option(
        "jobs",
        ("-j", "--jobs"),
        "Threads; 0 for all cores. The output is the same for any number.",
        "N",
        "0",
        parse=values.jobs,
        commands=_WRITING,
    ),
    Option(
        "cache",
        ("--cache/--no-cache",),
        "Keep imported models under $XDG_CACHE_HOME/trimray, and use them.",
        default=True,
        flag=True,
        commands=_ALL,
        defaults={"batch": False},
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
        commands=(*_WRITING, "batch", "thumbnailer"),
    ),
    Option(
        "json",
        ("--json",),
        "Print JSON.",
        default=False,
        flag=True,
        config=False,
        commands=("info", "bench", *FIDELITY),
    ),
)

# What all commands have.
_LAST: tuple[Option, ...] = (
    Option(
        "progress",
        ("--progress",),
        "auto is a bar on a terminal, otherwise none; with json every line on stderr is an object.",
        default="auto",
        choices=("auto", "none", "plain", "json"),
        commands=_ANY,
    ),
    Option("quiet", ("-q", "--quiet"), "Errors only.", default=False, flag=True, commands=_ANY),
    Option(
        "verbose",
        ("-v", "--verbose"),
        "Say more: times, warnings; twice: notes, tracebacks of internal errors.",
        count=True,
        config=False,
        commands=_ANY,
    ),
    Option(
        "print_config",
        ("--print-config",),
        "Print the options in force as a configuration file, and stop.",
        default=False,
        flag=True,
        config=False,
        commands=_ANY,
    ),
)

OPTIONS = (*_FIRST, *FIDELITY_OPTIONS, *BATCH_OPTIONS, *THUMBNAILER_OPTIONS, *_LAST)


def options_of(command: str) -> tuple[Option, ...]:
    return tuple(option for option in OPTIONS if command in option.commands)
