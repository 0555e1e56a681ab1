"""What the text of an IGES file says: its entities, and a repair of sloppy bookkeeping.

An IGES file is 80-column lines; column 73 is the section (Start, Global, Directory, Parameter, Terminate),
columns 74-80 the line's number in it. A directory entry takes two D lines, and is named by the number of
the first: D1, D3, ...
"""

import re
from dataclasses import dataclass, field

_LINE = re.compile(rb"\r\n|\n|\r")
FACE_TYPES = (143, 144, 510)
# Surfaces that become faces when nothing trims them.
SURFACE_TYPES = (108, 114, 118, 120, 122, 128, 140, 190, 192, 194, 196, 198)
SOLID_TYPES = {
    150: "block", 152: "right angular wedge", 154: "right circular cylinder",
    156: "right circular cone frustum",
    158: "sphere", 160: "torus", 162: "solid of revolution", 164: "solid of linear extrusion",
    168: "ellipsoid",
    180: "Boolean tree", 182: "selected component", 184: "solid assembly", 430: "solid instance",
}  # fmt: skip


@dataclass(frozen=True)
class Entity:
    """A directory entry. number: the 1 of D1. subordinate: depends on another entity."""

    number: int
    type: int
    form: int
    subordinate: bool
    parameters: tuple[bytes, ...]  # without the type


@dataclass
class IgesText:
    """Sections of a file: lines without their last 8 columns."""

    start: list[bytes] = field(default_factory=list)
    global_: list[bytes] = field(default_factory=list)
    directory: list[tuple[bytes, bytes]] = field(
        default_factory=list
    )  # the two lines of an entry, 72 columns
    records: list[bytes] = field(default_factory=list)  # parameter data by entry, delimiters included
    problems: list[str] = field(default_factory=list)  # bookkeeping that OpenCascade would stumble over
    truncated: str | None = None

    @property
    def entities(self) -> list[Entity]:
        """All entities; parameters are split at commas, which is right for everything but strings."""
        result = []
        for index, ((first, second), record) in enumerate(zip(self.directory, self.records, strict=False)):
            status = first[64:72]
            body = record.partition(b";")[0].split(b",")
            subordinate = status[2:4].strip() not in (b"", b"0", b"00")
            result.append(
                Entity(2 * index + 1, _int(first[:8]), _int(second[32:40]), subordinate, tuple(body[1:]))
            )
        return result


def parse(data: bytes) -> IgesText:
    """Never fails; what is wrong is in ``problems`` and ``truncated``."""
    text = IgesText()
    sections: dict[bytes, list[tuple[bytes, int]]] = {letter: [] for letter in (b"S", b"G", b"D", b"P", b"T")}
    odd = 0
    for line in _LINE.split(data):
        if not line.strip(b" \0\x1a"):
            continue
        letter = line[72:73]
        if letter not in sections:
            odd += 1
            continue
        sections[letter].append((line[:72].ljust(72), _int(line[73:80])))
    for letter, lines in sections.items():
        if [number for _, number in lines] != list(range(1, len(lines) + 1)):
            text.problems.append(f"section {letter.decode()}: its lines are not numbered 1, 2, 3")
    if odd:
        text.problems.append(f"{odd} lines without a section letter in column 73")
    text.start = [line for line, _ in sections[b"S"]]
    text.global_ = [line for line, _ in sections[b"G"]]
    d_lines = [line for line, _ in sections[b"D"]]
    if len(d_lines) % 2:
        text.truncated = "the directory ends in the middle of an entry"
    text.directory = list(zip(d_lines[::2], d_lines[1::2], strict=False))
    _split_records(text, [line for line, _ in sections[b"P"]])
    if not sections[b"T"]:
        text.problems.append("no Terminate section")
    _check_global(text)
    return text


def _split_records(text: IgesText, lines: list[bytes]) -> None:
    """Fills ``records`` by the pointers of the directory, or, where these are wrong, by the delimiters."""
    pointers = [(_int(first[8:16]), _int(second[24:32])) for first, second in text.directory]
    by_pointer: list[bytes] = []
    for index, (begin, count) in enumerate(pointers):
        owners = {_int(line[64:72]) for line in lines[begin - 1 : begin - 1 + count]}
        if begin < 1 or count < 1 or begin - 1 + count > len(lines) or owners - {2 * index + 1}:
            break
        by_pointer.append(b"".join(line[:64] for line in lines[begin - 1 : begin - 1 + count]))
    if len(by_pointer) == len(pointers) and all(b";" in record for record in by_pointer):
        text.records = by_pointer
        return
    records: list[bytes] = []
    current = b""
    for line in lines:
        current += line[:64].rstrip() if line[:64].rstrip().endswith((b",", b";")) else line[:64]
        if current.rstrip().endswith(b";"):
            records.append(current)
            current = b""
    if current.strip() or len(records) < len(text.directory):
        text.truncated = (
            text.truncated or f"{len(text.directory)} directory entries, {len(records)} complete records"
        )
    text.records = records[: len(text.directory)]
    text.problems.append("directory and parameter section do not point at each other")


def _check_global(text: IgesText) -> None:
    """A global section without its 24 fields is replaced when the file is rewritten."""
    fields = b"".join(text.global_).count(b",")
    if fields < 12:
        text.problems.append(
            "the Global section has almost no fields: standard delimiters and millimetres are taken"
        )
        text.global_ = []


def rewrite(text: IgesText) -> bytes:
    """The same file with right bookkeeping."""
    global_ = text.global_ or _standard_global()
    out: list[bytes] = []
    _emit(out, b"S", text.start or [b"repaired".ljust(72)])
    _emit(out, b"G", global_)
    parameters: list[bytes] = []
    directory: list[bytes] = []
    for index, ((first, second), record) in enumerate(zip(text.directory, text.records, strict=False)):
        lines = _wrap(record)
        directory.append(first[:8] + b"%8d" % (len(parameters) + 1) + first[16:72])
        directory.append(second[:24] + b"%8d" % len(lines) + second[32:72])
        parameters += [line.ljust(64) + b"%8d" % (2 * index + 1) for line in lines]
    _emit(out, b"D", directory)
    _emit(out, b"P", parameters)
    sizes = (len(text.start) or 1, len(global_), len(directory), len(parameters))
    terminate = b"".join(
        b"%s%7d" % (letter, size) for letter, size in zip((b"S", b"G", b"D", b"P"), sizes, strict=True)
    )
    _emit(out, b"T", [terminate.ljust(72)])
    return b"\n".join(out) + b"\n"


def _emit(out: list[bytes], letter: bytes, lines: list[bytes]) -> None:
    out += [line[:72].ljust(72) + letter + b"%7d" % number for number, line in enumerate(lines, start=1)]


def _wrap(record: bytes) -> list[bytes]:
    """Lines of at most 64 columns, broken behind commas."""
    lines = [b""]
    for token in re.findall(rb"[^,;]*[,;]", record):
        token = token.strip()
        if len(lines[-1]) + len(token) > 64:
            lines.append(b"")
        lines[-1] += token
    return lines


def _standard_global() -> list[bytes]:
    text = (
        b"1H,,1H;,7Hunknown,7Hunknown,7Hunknown,7Hunknown,32,38,6,308,15,7Hunknown,1.0,2,2HMM,1,0.01,"
        b"15H20000101.000000,1.0E-06,1.0E+06,7Hunknown,7Hunknown,11,0,15H20000101.000000;"
    )
    return [text[start : start + 72].ljust(72) for start in range(0, len(text), 72)]


def _int(column: bytes) -> int:
    try:
        return int(column)
    except ValueError:
        return 0
