"""Bytes that are no model, or one that no machine can hold."""

from __future__ import annotations

import gzip
import io
import random
import zipfile
import zlib

BOMB = 1 << 30  # bytes when unpacked
_BLOCK = 64 << 20
_HEADER = (
    b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
    b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\n"
)
_END = b"ENDSEC;\nEND-ISO-10303-21;\n"
_HTML = b"<!DOCTYPE html><html><body><h1>404 Not Found</h1>\nPlease log in.</body></html>\n"


def not_models() -> dict[str, bytes]:
    """By file name; every one must fail."""
    words = random.Random("junk")
    png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x08\2\0\0\0\x90wS\xde" + words.randbytes(300)
    elf = b"\x7fELF\2\1\1" + b"\0" * 9 + words.randbytes(4000)
    files = {
        "nothing.step": b"",
        "nothing.igs": b"",
        "nothing.stl": b"",
        "nothing.brep": b"",
        "nothing.stpZ": b"",
        "one-byte.step": b"I",
        "zeros.step": bytes(70_000),
        "spaces.step": b" " * 70_000,
        "newlines.igs": b"\n" * 70_000,
        "picture.step": png,
        "program.iges": elf,
        "page.step": _HTML,
        "page.stp": _HTML * 1000,
        "text.brep": b"Dear reader, this is no model.\n" * 50,
        "magic-alone.step": b"ISO-10303-21;",
        "header-alone.step": _HEADER,
        "no-data.step": _HEADER + b"DATA;\n" + _END,
        "no-geometry.step": _HEADER + b"DATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\n" + _END,
        "endless-text.step": _HEADER + b"DATA;\n#1=PRODUCT('" + b"a" * 3_000_000,
        "endless-comment.step": b"/*" + b" *" * 100_000,
        "pit.step": _HEADER + b"DATA;\n#1=POINT(" + b"(" * 1_000_000 + b";\n" + _END,
        "pit-closed.step": _HEADER + b"DATA;\n#1=P(" + b"(" * 300_000 + b")" * 300_000 + b");\n" + _END,
        "self.step": _HEADER + b"DATA;\n#1=SHAPE_DEFINITION_REPRESENTATION(#1,#1);\n" + _END,
        "header-then-noise.step": _HEADER + words.randbytes(20_000),
        "wide.step": b"\xff\xfe" + (_HEADER + b"DATA;\n" + _END).decode().encode("utf-16-le"),
        "magic.brep": b"DBRep_DrawableShape\n\nCASCADE Topology V3, (c) Open Cascade\n",
        "many.brep": b"DBRep_DrawableShape\n\nCASCADE Topology V3, (c) Open Cascade\nLocations 0\n"
        b"Curve2ds 2000000000\n",
        "start-alone.igs": b" " * 72 + b"S      1\n",
        "open.stl": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
        "cut.stl": b"\0" * 80 + (1000).to_bytes(4, "little") + bytes(500),
        "counts-alone.stl": b"\0" * 80 + b"\xff\xff\xff\xff",
        "none.stl": b"\0" * 84,
        "gzip-of-nothing.stpZ": gzip.compress(b"", mtime=0),
        "gzip-of-noise.step.gz": gzip.compress(words.randbytes(5000), mtime=0),
        "gzip-cut.step.gz": gzip.compress(words.randbytes(5000), mtime=0)[:2000],
        "gzip-damaged.stpZ": gzip.compress(_HEADER, mtime=0)[:-8] + b"\0" * 8,
        "gzip-of-gzip.stpZ": gzip.compress(gzip.compress(_HEADER, mtime=0), mtime=0),
        "zip-cut.stpZ": _zip({"a.stp": words.randbytes(5000)})[:3000],
        "zip-without-model.stpZ": _zip({"readme.txt": b"hello"}),
        "zip-of-nothing.stpZ": _zip({}),
        "zip-of-folder.stpZ": _zip({"a.stp/": b""}),
        "zip-encrypted.stpZ": _encrypted(_zip({"a.stp": _HEADER})),
        "zip-upwards.stpZ": _zip({"../../../../tmp/trimray-escape.stp": _HEADER}),
    }
    for i in range(20):
        suffix = words.choice((".step", ".stp", ".igs", ".iges", ".brep", ".stpZ"))
        files[f"noise-{i}{suffix}"] = words.randbytes(words.choice((10, 1000, 100_000)))
    return files


def bombs() -> dict[str, bytes]:
    """Small files that unpack to BOMB bytes."""
    start = b"ISO-10303-21;\n".ljust(_BLOCK)
    member = gzip.compress(start, mtime=0) + gzip.compress(bytes(_BLOCK), 1, mtime=0) * (BOMB // _BLOCK - 1)
    return {"bomb.step.gz": member, "bomb.stpZ": _zip_bomb(start)}


def laughs(sphere: bytes, levels: int = 12) -> bytes:
    """Ten copies of ten copies of ... a sphere, by mapped items: 10 to the ``levels`` instances.

    sphere: samples/torture/sphere.step, whose numbers are used."""
    records = []
    below = 10
    for level in range(levels):
        base = 1000 + level * 100
        records.append(f"#{base}=REPRESENTATION_MAP(#11,#{below});")
        items = []
        for i in range(10):
            point, axis, item = base + 10 + i, base + 30 + i, base + 50 + i
            records.append(f"#{point}=CARTESIAN_POINT('',({(i + 1) * 3.0**level},0.,0.));")
            records.append(f"#{axis}=AXIS2_PLACEMENT_3D('',#{point},#13,#14);")
            records.append(f"#{item}=MAPPED_ITEM('',#{base},#{axis});")
            items.append(f"#{item}")
        below = base + 90
        records.append(f"#{below}=SHAPE_REPRESENTATION('',(#11,{','.join(items)}),#27);")
    text = sphere.decode()
    text = text.replace(
        "#3 = SHAPE_DEFINITION_REPRESENTATION(#4,#10)", f"#3=SHAPE_DEFINITION_REPRESENTATION(#4,#{below})"
    )
    head, end, tail = text.rpartition("ENDSEC;")
    return (head + "\n".join(records) + "\n" + end + tail).encode()


def _zip(members: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
    return out.getvalue()


def _encrypted(data: bytes) -> bytes:
    """The flag of encryption set in both headers."""
    out = bytearray(data)
    out[6] |= 1
    out[data.index(b"PK\1\2") + 8] |= 1
    return bytes(out)


def _zip_bomb(start: bytes) -> bytes:
    """A member whose header says 1 kB."""
    squeeze = zlib.compressobj(9, zlib.DEFLATED, -15)
    body = squeeze.compress(start) + squeeze.flush(zlib.Z_FULL_FLUSH)
    zeros = squeeze.compress(bytes(_BLOCK)) + squeeze.flush(zlib.Z_FULL_FLUSH)
    body += zeros * (BOMB // _BLOCK - 1) + squeeze.flush()
    data = bytearray(_zip({"a.stp": b""}))
    sizes = (1234).to_bytes(4, "little") + len(body).to_bytes(4, "little") + (1000).to_bytes(4, "little")
    local_end = 30 + len(b"a.stp")
    empty = data.index(b"PK\1\2") - local_end
    central = bytearray(data[local_end + empty :])
    local = bytearray(data[:local_end])
    local[14:26] = sizes
    central[16:28] = sizes
    end = central.index(b"PK\5\6")
    central[end + 16 : end + 20] = (local_end + len(body)).to_bytes(4, "little")
    return bytes(local) + body + bytes(central)
