"""What kind of file this is: by its content first, by its extension second."""

import re
from typing import Literal

Format = Literal["step", "iges", "brep", "binbrep", "stl", "obj", "ply", "off", "gzip", "zip", "unknown"]
TRIANGLES: tuple[Format, ...] = ("stl", "obj", "ply", "off")
MODELS: tuple[Format, ...] = ("step", "iges", "brep", "binbrep", *TRIANGLES)

SNIFF_BYTES = 4096

_EXTENSIONS: dict[str, Format] = {
    ".step": "step", ".stp": "step", ".p21": "step", ".iges": "iges", ".igs": "iges",
    ".brep": "brep", ".brp": "brep", ".stl": "stl", ".obj": "obj", ".ply": "ply", ".off": "off",
}  # fmt: skip
_STEP = re.compile(rb"\A(?:\xef\xbb\xbf)?(?:\s|/\*.*?\*/)*ISO-10303-21\s*;", re.DOTALL)
_OFF = re.compile(rb"\A(?:\s|#[^\n]*\n)*(?:ST)?C?N?4?n?OFF\b")
_OBJ_WORDS = frozenset(
    b"v vt vn vp f fo l p o g s mg usemtl mtllib usemap maplib vc bevel c_interp d_interp lod".split()
)
_OBJ_VERTEX = re.compile(rb"v(?:\s+[-+.\deE]+){3}")
_SECTION = re.compile(rb"[SCBGDPT] *\d+ *\Z")


def sniff(head: bytes, name: str = "", size: int | None = None) -> Format:
    """Format of a file from its first ``SNIFF_BYTES`` bytes and, only where these leave it open, its name.

    size: of the file; a binary STL file shows by nothing else.
    """
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
    if head.startswith((b"ply\n", b"ply\r")):
        return "ply"
    if _is_binary_stl(head, size):
        return "stl"
    if _is_iges(head):
        return "iges"
    if _OFF.match(head):
        return "off"
    if text[:6].lower().startswith(b"solid") and b"facet" in head.lower():
        return "stl"
    kind = _EXTENSIONS.get(extension(name), "unknown")
    if kind == "stl":
        return kind  # cut off, which its reader says
    if b"\0" in head or not text:
        return "unknown"
    return "obj" if kind == "unknown" and _is_obj(head) else kind


def extension(name: str) -> str:
    """Last extension in lower case, ".step"; "" when there is none."""
    stem, dot, last = name.rpartition(".")
    return f".{last.lower()}" if dot and stem else ""


def names_model(name: str) -> bool:
    """Is the name's extension that of a model?"""
    return extension(name) in _EXTENSIONS


def _is_binary_stl(head: bytes, size: int | None) -> bool:
    """80 bytes of anything, the number of triangles, 50 bytes for each."""
    return size is not None and len(head) >= 84 and size == 84 + 50 * int.from_bytes(head[80:84], "little")


def _is_obj(head: bytes) -> bool:
    """Every line begins with a word of the format, and one is a vertex."""
    lines = [line.strip() for line in head.splitlines()]
    lines = [line for line in lines if line and not line.startswith(b"#")]
    known = all(line.split(None, 1)[0] in _OBJ_WORDS for line in lines[:-1])
    return known and any(_OBJ_VERTEX.match(line) for line in lines[:-1])


def _is_iges(head: bytes) -> bool:
    """The first full line is 80 columns with a section letter in column 73."""
    lines = re.split(rb"\r\n|\n|\r", head)
    for line in lines[:-1] if len(lines) > 1 else lines:
        if line.strip():
            return len(line) >= 74 and line[72:73] in b"SCBG" and bool(_SECTION.match(line[72:80].rstrip()))
    return False
