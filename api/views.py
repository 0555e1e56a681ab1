"""What render()'s words mean: views, axes, colours, sizes. Wrong ones are named, with the nearest right
one."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Sequence

from .importer.errors import UsageError

# Azimuth and elevation in degrees; azimuth 0 is the front, 90 the right side.
VIEWS: dict[str, tuple[float, float]] = {
    "iso": (45.0, math.degrees(math.atan(math.sqrt(0.5)))),
    "front": (0.0, 0.0),
    "right": (90.0, 0.0),
    "back": (180.0, 0.0),
    "left": (270.0, 0.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
}

# Names as _core.UpAxis has them.
UP_AXES = {"x": "X", "y": "Y", "z": "Z", "-x": "MINUS_X", "-y": "MINUS_Y", "-z": "MINUS_Z"}
PROJECTIONS = ("orthographic", "perspective")
MODES = ("hybrid", "standard", "reference")
CAST_MODES = ("standard", "reference")
# What a picture is of, and what its making was like.
AOVS = ("color", "depth", "position", "normal", "uv", "face", "instance")
MAKING_AOVS = ("seed_id", "seed_uv", "time")
MAX_SIZE_PX = 32768
MAX_SAMPLES = 1024
MAX_OCCLUSION_RAYS = 1024
MAX_REFLECTIONS = 16

# The sixteen of HTML 4, orange, and the two spellings of grey.
COLORS = {
    "black": "#000000", "silver": "#c0c0c0", "gray": "#808080", "grey": "#808080", "white": "#ffffff",
    "maroon": "#800000", "red": "#ff0000", "purple": "#800080", "fuchsia": "#ff00ff", "magenta": "#ff00ff",
    "green": "#008000", "lime": "#00ff00", "olive": "#808000", "yellow": "#ffff00", "navy": "#000080",
    "blue": "#0000ff", "teal": "#008080", "aqua": "#00ffff", "cyan": "#00ffff", "orange": "#ffa500",
    "lightgray": "#d3d3d3", "lightgrey": "#d3d3d3", "transparent": "#00000000",
}  # fmt: skip

Rgba = tuple[float, float, float, float]
View = str | Sequence[float]
Background = str | Sequence[float] | Sequence[str]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """ ", did you mean X?" or ""."""
    near = difflib.get_close_matches(word.lower(), list(known), n=1, cutoff=0.6)
    return f", did you mean '{near[0]}'?" if near else ""


def choose(what: str, word: object, known: Iterable[str]) -> str:
    """The word itself when it is known. Raises UsageError with the nearest and all known words."""
    known = tuple(known)
    if isinstance(word, str) and word in known:
        return word
    text = str(word)
    raise UsageError(f"{what}: unknown '{text}'{did_you_mean(text, known) or ','} one of: {', '.join(known)}")


def parse_view(view: View) -> tuple[float, float]:
    """(azimuth, elevation) in degrees from a name, "AZ,EL" or two numbers. Raises UsageError."""
    if isinstance(view, str):
        if view in VIEWS:
            return VIEWS[view]
        if "," not in view:
            hint = did_you_mean(view, VIEWS) or ","
            raise UsageError(
                f"view: unknown '{view}'{hint} one of: {', '.join(VIEWS)}, or AZIMUTH,ELEVATION in degrees"
            )
        view = view.split(",")  # type: ignore[assignment]
    try:
        azimuth, elevation = (float(x) for x in view)
    except (TypeError, ValueError):
        raise UsageError(f"view: '{_shown(view)}' is not AZIMUTH,ELEVATION in degrees") from None
    if not math.isfinite(azimuth) or not -90.0 <= elevation <= 90.0:
        raise UsageError(f"view: '{_shown(view)}' needs a finite azimuth and an elevation from -90 to 90")
    return azimuth, elevation


def parse_size(size: Sequence[int] | str) -> tuple[int, int]:
    """(width, height) in px from two numbers, "W,H", "WxH" or "N" for a square. Raises UsageError."""
    shown = _shown(size)
    parts: Sequence[object] = re.split(r"[,xX]", size) if isinstance(size, str) else size
    try:
        if isinstance(size, str) and len(parts) == 1:
            parts = [parts[0], parts[0]]
        if any(isinstance(p, float) and not p.is_integer() for p in parts):
            raise ValueError
        width, height = (int(p) for p in parts)  # type: ignore[call-overload]
    except (TypeError, ValueError):
        raise UsageError(f"size: '{shown}' is not WIDTH,HEIGHT in pixels") from None
    if not (1 <= width <= MAX_SIZE_PX and 1 <= height <= MAX_SIZE_PX):
        raise UsageError(f"size: '{shown}' is not within 1 and {MAX_SIZE_PX} pixels")
    return width, height


def parse_samples(samples: int | str) -> int:
    """Rays per pixel. Raises UsageError."""
    try:
        count = int(samples)
    except (TypeError, ValueError):
        count = 0
    if isinstance(samples, float) and samples != count:
        count = 0
    if not 1 <= count <= MAX_SAMPLES:
        raise UsageError(f"samples: '{samples}' is not a whole number from 1 to {MAX_SAMPLES}")
    return count


def parse_count(what: str, count: int | str, most: int) -> int:
    """A whole number from 0 to most. Raises UsageError."""
    try:
        number = int(count)
    except (TypeError, ValueError):
        number = -1
    if not 0 <= number <= most or (isinstance(count, float) and count != number):
        raise UsageError(f"{what}: '{count}' is not a whole number from 0 to {most}")
    return number


def parse_aovs(aovs: object) -> tuple[str, ...]:
    """Names of AOVS and MAKING_AOVS, each once, in their order. Takes a sequence or "a,b". Raises
    UsageError."""
    names = aovs.replace(" ", "").split(",") if isinstance(aovs, str) else list(aovs)  # type: ignore[call-overload]
    if not names:
        raise UsageError("aovs: nothing asked for")
    known = (*AOVS, *MAKING_AOVS)
    asked = {choose("aov", name, known) for name in names}
    return tuple(name for name in known if name in asked)


def parse_background(background: Background) -> tuple[Rgba, Rgba]:
    """Top and bottom of the picture, sRGB-encoded, straight alpha. Raises UsageError.

    A colour is a name, "#rgb", "#rrggbb", "#rrggbbaa", "transparent", or 3 or 4 numbers in [0, 1]; two
    colours (a pair, or one text with a comma) are a vertical gradient from top to bottom.
    """
    if isinstance(background, str):
        colors = [_text_color(part.strip()) for part in background.split(",")]
    else:
        items = list(background)
        if len(items) in (3, 4) and all(isinstance(x, int | float) for x in items):
            colors = [_number_color(items)]  # type: ignore[arg-type]
        else:
            colors = [_text_color(c) if isinstance(c, str) else _number_color(c) for c in items]  # type: ignore[arg-type]
    if len(colors) not in (1, 2):
        raise UsageError(f"background: '{_shown(background)}' is {len(colors)} colours, expected one or two")
    return colors[0], colors[-1]


def _text_color(text: str) -> Rgba:
    code = COLORS.get(text.lower(), text)
    match = re.fullmatch(r"#([0-9a-fA-F]{3,4}|[0-9a-fA-F]{6}|[0-9a-fA-F]{8})", code)
    if match is None:
        raise UsageError(
            f"background: unknown colour '{text}'{did_you_mean(text, COLORS) or ','} a name or #rrggbb[aa]"
        )
    digits = match[1]
    if len(digits) < 6:
        digits = "".join(2 * d for d in digits)
    values = [int(digits[i : i + 2], 16) / 255.0 for i in range(0, len(digits), 2)]
    return _rgba(values)


def _number_color(color: Sequence[float]) -> Rgba:
    try:
        values = [float(x) for x in color]
    except (TypeError, ValueError):
        values = []
    if len(values) not in (3, 4) or not all(0.0 <= x <= 1.0 for x in values):
        raise UsageError(f"background: '{_shown(color)}' is not 3 or 4 numbers from 0 to 1")
    return _rgba(values)


def _rgba(values: Sequence[float]) -> Rgba:
    return (values[0], values[1], values[2], values[3] if len(values) == 4 else 1.0)


def _shown(value: object) -> str:
    if isinstance(value, str):
        return value
    try:
        return ",".join(str(x) for x in value)  # type: ignore[attr-defined]
    except TypeError:
        return str(value)
