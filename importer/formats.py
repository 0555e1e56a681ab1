"""What kind of file this is: by its content first, by its extension second."""

import re
from typing import Literal

Format = Literal["step", "iges", "brep", "binbrep", "gzip", "zip", "unknown"]

kSniffBytes = 4096

_EXTENSIONS: dict[str, Format] = {
    ".step": "step", ".stp": "step", ".p21": "step", ".iges": "iges", ".igs": "iges",
    ".brep": "brep", ".brp": "brep",
}  # fmt: skip
_STEP = re.compile(rb"\A(?:\xef\xbb\xbf)?(?:\s|/\*.*?\*/)*ISO-10303-21\s*;", re.DOTALL)
_SECTION = re.compile(rb"[SCBGDPT] *\d+ *\Z")


def sniff(head: bytes, name: str = "") -> Format:
    """Format of a file from its first ``kSniffBytes`` bytes and, only where these leave it open, its name."""
    if head.startswith(b"\x1f\x8b"):
        return "gzip"
    if head.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        return "zip"
    if _STEP.match(head):
        return "step"
    text = head.lstrip()
    if text.startswith((b"DBRep_DrawableShape", b"CASCADE Topology")):
        return "brep"
    if text.startswith(b"Open CASCADE Topology"):
        return "binbrep"
    if _is_iges(head):
        return "iges"
    if b"\0" in head or not text:
        return "unknown"
    return _EXTENSIONS.get(extension(name), "unknown")


def extension(name: str) -> str:
    """Last extension in lower case, ".step"; "" when there is none."""
    stem, dot, last = name.rpartition(".")
    return f".{last.lower()}" if dot and stem else ""


def _is_iges(head: bytes) -> bool:
    """The first full line is 80 columns with a section letter in column 73."""
    lines = re.split(rb"\r\n|\n|\r", head)
    for line in lines[:-1] if len(lines) > 1 else lines:
        if line.strip():
            return len(line) >= 74 and line[72:73] in b"SCBG" and bool(_SECTION.match(line[72:80].rstrip()))
    return False
