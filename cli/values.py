"""Texts of options to values. Every function raises trimray.UsageError, and imports what it needs when it is
called, so that the table of options costs nothing."""

from __future__ import annotations


def size(text: str) -> object:
    from trimray.views import parse_size

    return parse_size(text)


def view(text: str) -> object:
    from trimray.views import parse_view

    parse_view(text)
    return text


def samples(text: str) -> object:
    from trimray.views import parse_samples

    return parse_samples(text)


def occlusion(text: str) -> object:
    from trimray.views import MAX_OCCLUSION_RAYS, parse_count

    return parse_count("ambient_occlusion", text, MAX_OCCLUSION_RAYS)


def reflections(text: str) -> object:
    from trimray.views import MAX_REFLECTIONS, parse_count

    return parse_count("reflections", text, MAX_REFLECTIONS)


def background(text: str) -> object:
    from trimray.views import parse_background

    parse_background(text)
    return text


def aov(text: str) -> object:
    from trimray.views import parse_aovs

    parse_aovs(text)
    return text


def up(text: str) -> object:
    from trimray.views import UP_AXES, choose

    return choose("up", text.lower().lstrip("+"), UP_AXES)


def format(text: str) -> object:
    from trimray.formats import format_of

    return format_of("", text)


def usage(message: str) -> Exception:
    from trimray import UsageError

    return UsageError(message)


def number(text: str, units: dict[str, float], what: str) -> float:
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
        raise usage(f"'{text}' is not {what}")
    return value


def seconds(text: str) -> object:
    if text.strip().lower() == "none":
        return None
    return number(text, {"s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0}, "a positive time, such as 30 or 2m")


def bytes(text: str) -> object:
    if text.strip().lower() == "none":
        return None
    powers = {"k": 10, "m": 20, "g": 30}
    units = {letter + tail: float(1 << power) for letter, power in powers.items() for tail in ("", "b", "ib")}
    return int(number(text, units, "a positive size in bytes, such as 500M or 2G"))


def mm(text: str) -> object:
    return number(text, {"mm": 1.0}, "a positive length in mm")


def repeat(text: str) -> object:
    return count(text, "a number of pictures", least=1)


def jobs(text: str) -> object:
    return count(text, "a number of threads")


def workers(text: str) -> object:
    return count(text, "a number of processes")


def count(text: str, what: str, least: int = 0) -> int:
    body = text.strip()
    if not (body.isascii() and body.isdigit()) or int(body) < least:
        raise usage(f"'{text}' is not {what}")
    return int(body)


def mesh_format(text: str) -> object:
    from trimray.formats import mesh_format_of

    return mesh_format_of("", text)


def deviation(text: str) -> object:
    from trimray.tri_mesh import parse_deviation

    parse_deviation(text)
    return text


def degrees(text: str) -> object:
    return number(text, {"deg": 1.0, "°": 1.0}, "a positive angle in degrees")


def frames(text: str) -> object:
    from trimray.turntable import parse_frames

    return parse_frames(text)


def fps(text: str) -> object:
    value = number(text, {"fps": 1.0}, "a positive number of frames a second")
    if value > 100.0:
        raise usage(f"'{text}' is more than 100 frames a second")
    return value


def sequence_format(text: str) -> object:
    from trimray.formats import ANIMATIONS, format_of

    name = text.lower()
    return name if name in ANIMATIONS else format_of("", text)
