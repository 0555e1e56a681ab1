"""MIME types of the models that we draw, as a package of the shared MIME database.

What another package defines is its own: of such a type we add missing aliases alone, and a pattern of names
that belongs to another type is left to that.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from xml.etree import ElementTree
from xml.sax.saxutils import escape, quoteattr

_NAMESPACE = "http://www.freedesktop.org/standards/shared-mime-info"


@dataclass(frozen=True)
class MimeType:
    """globs: of names, in any case. magic: texts at the beginning of a file. parents: types that a file of
    this type is, too."""

    name: str
    comment: str
    globs: tuple[str, ...]
    magic: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    parents: tuple[str, ...] = ()


TYPES = (
    MimeType(
        "model/step",
        "STEP 3D model",
        ("*.step", "*.stp", "*.p21"),
        ("ISO-10303-21;",),
        ("application/step", "application/x-step", "model/x-step"),
        ("text/plain",),
    ),
    # Packed with zip or gzip, whatever the name says, so no content tells it.
    MimeType("model/step+zip", "compressed STEP 3D model", ("*.stpz",), aliases=("application/step+zip",)),
    MimeType(
        "model/iges",
        "IGES 3D model",
        ("*.igs", "*.iges"),
        aliases=("application/iges", "application/x-iges", "model/x-iges"),
        parents=("text/plain",),
    ),
    # No registered name; "x-" says so.
    MimeType(
        "model/x-brep",
        "OpenCascade 3D model",
        ("*.brep", "*.brp"),
        ("DBRep_DrawableShape", "CASCADE Topology V", "\\nCASCADE Topology V", "Open CASCADE Topology V"),
        ("application/x-brep",),
    ),
)
# Of files of triangles, those that the database of a desktop usually knows. Others draw them, too.
TRIANGLES = ("model/stl", "model/obj")


@dataclass
class Known:
    """What other packages define. globs: pattern to type."""

    types: set[str] = field(default_factory=set)
    aliases: set[str] = field(default_factory=set)
    globs: dict[str, str] = field(default_factory=dict)


def known_types(data_folders: Iterable[str], own: str) -> Known:
    """Of the packages under DIR/mime/packages. own: name of our package's file, which is left out. A package
    that cannot be read is none."""
    known = Known()
    for folder in data_folders:
        packages = os.path.join(folder, "mime", "packages")
        try:
            names = sorted(os.listdir(packages))
        except OSError:
            continue
        for name in names:
            if name.endswith(".xml") and name != own:
                _read(os.path.join(packages, name), known)
    return known


def _read(path: str, known: Known) -> None:
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError, ValueError):
        return
    for element in root.iter(f"{{{_NAMESPACE}}}mime-type"):
        name = element.get("type", "")
        globs = [glob.get("pattern", "").lower() for glob in element.iter(f"{{{_NAMESPACE}}}glob")]
        aliases = {alias.get("type", "") for alias in element.iter(f"{{{_NAMESPACE}}}alias")}
        known.aliases |= aliases
        known.globs |= dict.fromkeys(globs, name)
        # An addition of aliases alone, such as ours, makes no type.
        if globs or element.find(f"{{{_NAMESPACE}}}magic") is not None:
            known.types.add(name)


def missing_types(known: Known) -> list[MimeType]:
    """Of TYPES, what other packages leave to us."""
    missing = []
    for mime in TYPES:
        aliases = tuple(a for a in mime.aliases if a not in known.aliases and a not in known.types)
        if mime.name in known.types:
            missing.append(MimeType(mime.name, "", (), aliases=aliases))
        elif mime.name not in known.aliases:
            globs = tuple(glob for glob in mime.globs if glob not in known.globs)
            missing.append(MimeType(mime.name, mime.comment, globs, mime.magic, aliases, mime.parents))
    return [mime for mime in missing if mime.globs or mime.magic or mime.aliases]


def package(types: list[MimeType]) -> str:
    """The package's XML, without its head."""
    lines = [f'<mime-info xmlns="{_NAMESPACE}">']
    for mime in types:
        lines.append(f"  <mime-type type={quoteattr(mime.name)}>")
        if mime.comment:
            lines.append(f"    <comment>{escape(mime.comment)}</comment>")
        lines += (f"    <sub-class-of type={quoteattr(parent)}/>" for parent in mime.parents)
        if mime.magic:
            lines.append('    <magic priority="50">')
            lines += (
                f'      <match type="string" value={quoteattr(text)} offset="0"/>' for text in mime.magic
            )
            lines.append("    </magic>")
        lines += (f"    <glob pattern={quoteattr(glob)}/>" for glob in mime.globs)
        lines += (f"    <alias type={quoteattr(alias)}/>" for alias in mime.aliases)
        lines.append("  </mime-type>")
    return "\n".join([*lines, "</mime-info>"]) + "\n"
