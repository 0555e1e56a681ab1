"""What the text of a STEP file says before OpenCascade interprets it: header, faces, references, its end."""

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

_TAIL = 4096
_BEFORE = re.compile(rb"#(\d+)\s*=\s*\Z")
_BEHIND = re.compile(rb"\s*\(")
_TESSELLATED = re.compile(rb"#(\d+)\s*=\s*((?:COMPLEX_|CUBIC_BEZIER_)?TRIANGULATED_FACE)\s*\(")
_TESSELLATED_SET = re.compile(rb"#(\d+)\s*=\s*((?:COMPLEX_)?TRIANGULATED_SURFACE_SET)\s*\(")
_SURFACE = re.compile(
    rb"#(\d+)\s*=\s*(?:\(\s*BOUNDED_SURFACE\s*\(\s*\)\s*)?(B_SPLINE_SURFACE(?:_WITH_KNOTS)?|BEZIER_SURFACE|"
    rb"RECTANGULAR_TRIMMED_SURFACE|CURVE_BOUNDED_SURFACE|RATIONAL_B_SPLINE_SURFACE|QUASI_UNIFORM_SURFACE|UNIFORM_SURFACE)\s*\("
)
_SET = re.compile(rb"=\s*GEOMETRIC_(?:CURVE_)?SET\s*\(\s*'(?:[^']|'')*'\s*,\s*\(([^)]*)\)")
_RECORD_START = re.compile(rb"#(\d+)\s*=")
_RECORD_KIND = re.compile(rb"#(\d+)\s*=\s*([A-Z_0-9]+)\s*\(")
_REFERENCE = re.compile(rb"#(\d+)")
_SCHEMA = re.compile(rb"FILE_SCHEMA\s*\(\s*\(\s*'((?:[^']|'')*)'")
_FILE_NAME = re.compile(rb"FILE_NAME\s*\((.*?)\)\s*;", re.DOTALL)
_STRING = re.compile(rb"'((?:[^']|'')*)'")
_DOCUMENT = re.compile(rb"=\s*DOCUMENT_FILE\s*\(\s*'((?:[^']|'')*)'")
_FILE_SUFFIX = re.compile(r"\.(?:stp|step|stpz|p21)\Z", re.IGNORECASE)


# A record with a run of lists of numbers behind _WITH_KNOTS: multiplicities, then knots.
_KNOTS = re.compile(
    rb"#(\d+)\s*=(?=[^;#]*(?:BOUNDED_|B_SPLINE_))[^;]*?_WITH_KNOTS\s*\("
    rb"[^;]*?((?:\([-+\d.,Ee\s]+\)\s*,\s*)+)\.[A-Z_]+\.\s*\)"
)
_LIST = re.compile(rb"\(([-+\d.,Ee\s]+)\)")


@dataclass(frozen=True)
class FaceText:
    id: int  # 12 for #12
    kind: str


class StepText:
    """data: the whole file."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    @cached_property
    def faces(self) -> list[FaceText]:
        """ADVANCED_FACE and FACE_SURFACE records in file order."""
        found = [*self._records("ADVANCED_FACE"), *self._records("FACE_SURFACE")]
        return [face for _, face in sorted(found, key=lambda entry: entry[0])]

    def _records(self, kind: str) -> Iterator[tuple[int, FaceText]]:
        """(position, record) of all records of that kind; faster than an expression over the file."""
        word = kind.encode()
        position = self.data.find(word)
        while position >= 0:
            before = _BEFORE.search(self.data, max(0, position - 40), position)
            if before and _BEHIND.match(self.data, position + len(word)):
                yield position, FaceText(int(before[1]), kind)
            position = self.data.find(word, position + len(word))

    @cached_property
    def tessellated(self) -> list[FaceText]:
        """Faces that AP242 gives as triangles only."""
        if b"TRIANGULATED_" not in self.data:
            return []
        return [FaceText(int(m[1]), m[2].decode()) for m in _TESSELLATED.finditer(self.data)]

    @cached_property
    def tessellated_sets(self) -> list[FaceText]:
        """Sets of triangles that are no faces."""
        if b"TRIANGULATED_" not in self.data:
            return []
        return [FaceText(int(m[1]), m[2].decode()) for m in _TESSELLATED_SET.finditer(self.data)]

    @cached_property
    def bounded_surfaces(self) -> list[FaceText]:
        """Surfaces with an extent of their own, which may stand for a face when no face uses them."""
        return [FaceText(int(m[1]), m[2].decode()) for m in _SURFACE.finditer(self.data)]

    @cached_property
    def loose_surfaces(self) -> list[FaceText]:
        """Bounded surfaces that are members of a geometric set: each becomes a face."""
        members = {int(r) for m in _SET.finditer(self.data) for r in _REFERENCE.findall(m[1])}
        return [s for s in self.bounded_surfaces if s.id in members] if members else []

    @cached_property
    def unused_surfaces(self) -> list[FaceText]:
        """Bounded surfaces that nothing refers to."""
        uses: dict[int, int] = {}
        for match in _REFERENCE.finditer(self.data):
            uses[int(match[1])] = uses.get(int(match[1]), 0) + 1
        return [s for s in self.bounded_surfaces if uses.get(s.id, 0) <= 1]

    @cached_property
    def record_ids(self) -> list[bytes]:
        """Numbers of all records as they are written, in file order."""
        return _RECORD_START.findall(self.data)

    @cached_property
    def external_files(self) -> list[str]:
        """Names of the model files that this one refers to."""
        if b"DOCUMENT_FILE" not in self.data:
            return []
        names = [m[1].decode("utf-8", "replace") for m in _DOCUMENT.finditer(self.data)]
        return [name for name in dict.fromkeys(names) if _FILE_SUFFIX.search(name)]

    def knot_defects(self) -> Iterator[FaceText]:
        """Splines whose knots do not ascend or do not fit their multiplicities, each with what is wrong as
        its kind. OpenCascade reads such knots as something else, without a word."""
        if b"_WITH_KNOTS" not in self.data:
            return
        for match in _KNOTS.finditer(self.data):
            lists = _LIST.findall(match[2])
            half = len(lists) // 2
            for multiplicities, knots in zip(lists[:half], lists[half : 2 * half], strict=True):
                try:
                    values = [float(x) for x in knots.split(b",")]
                except ValueError:
                    continue
                defect = ""
                if multiplicities.count(b",") + 1 != len(values):
                    defect = f"{len(values)} knots, but {multiplicities.count(b',') + 1} multiplicities"
                elif any(b <= a for a, b in itertools.pairwise(values)):
                    defect = "its knots do not ascend"
                if defect:
                    yield FaceText(int(match[1]), defect)
                    break

    def record(self, number: int) -> bytes:
        """Text of record #number up to its semicolon, b"" when there is none."""
        match = re.search(rb"#%d\s*=([^;]*);" % number, self.data)
        return match[1] if match else b""

    def member(self, number: int, position: int) -> int:
        """The record that record #number refers to as its parameter of that position (1 is the first), or,
        where that is none, as that member of its list; 0 where there is none."""
        record = _STRING.sub(b"''", self.record(number)).partition(b"(")[2]
        plain = re.sub(rb"\([^()]*\)", b"()", record).split(b",")
        if 0 < position <= len(plain) and (
            match := _REFERENCE.fullmatch(plain[position - 1].strip(b" \r\n)"))
        ):
            return int(match[1])
        lists = [_REFERENCE.findall(found) for found in re.findall(rb"\(([^()]*)\)", record)]
        members = next((found for found in lists if found), [])
        return int(members[position - 1]) if 0 < position <= len(members) else 0

    def header(self) -> dict[str, str]:
        """schema, originating_system and preprocessor, as far as they are given."""
        head = self.data[:65536]
        facts: dict[str, str] = {}
        if match := _SCHEMA.search(head):
            facts["schema"] = _text(match[1])
        if match := _FILE_NAME.search(head):
            strings = _STRING.findall(match[1])
            if len(strings) >= 6:
                facts["preprocessor"], facts["originating_system"] = _text(strings[-3]), _text(strings[-2])
        return {key: value for key, value in facts.items() if value.strip()}

    def broken_off(self) -> str | None:
        """Why the file is incomplete, or None. "" when only the closing line is missing."""
        if b"END-ISO-10303-21" in self.data[-_TAIL:]:
            return None
        if b"DATA" not in self.data:
            return "truncated: it ends before the DATA section"
        if re.search(rb"ENDSEC\s*;[\s\0]*\Z", self.data[-_TAIL:]):
            return ""
        return f"truncated: it ends at byte {len(self.data)} in the middle of the DATA section"

    def not_a_number(self) -> FaceText | None:
        """The first record with NaN or infinity in a list of numbers."""
        lower = self.data.lower()
        for word in (b"nan", b"inf"):
            position = lower.find(word)
            while position >= 0:
                end = lower.find(b"ity", position, position + 8)
                stop = position + 3 if end < 0 else end + 3
                behind = lower[stop : stop + 1]
                before = lower[max(0, position - 1) : position]
                if before and before in b"(,-+ " and behind and behind in b",) ":
                    record = _RECORD_KIND.search(self.data, self.data.rfind(b";", 0, position) + 1)
                    # A quote between the record's start and here: a word of a name, not a number.
                    if record and self.data.count(b"'", record.start(), position) % 2 == 0:
                        return FaceText(int(record[1]), record[2].decode())
                position = lower.find(word, position + 3)
        return None

    def grid_defect(self, number: int) -> str | None:
        """What is wrong with the control points or weights of a B-spline surface, or None."""
        record = self.record(number)
        weights = re.search(rb"RATIONAL_B_SPLINE_SURFACE\s*\(\s*\((.*?)\)\s*\)\s*\)", record, re.DOTALL)
        poles = re.search(
            rb"B_SPLINE_SURFACE(?:_WITH_KNOTS)?\s*\([^#]*\((\(.*?\))\s*\)\s*,\s*\.", record, re.DOTALL
        )
        if poles is None:
            return None
        rows = [len(_REFERENCE.findall(row)) for row in poles[1].split(b")") if b"#" in row]
        if weights is not None:
            weight_rows = [
                row.count(b",") + 1 for row in re.findall(rb"\(([^()]*)", b"(" + weights[1].lstrip(b"( "))
            ]
            if weight_rows != rows:
                return f"{sum(rows)} control points but {sum(weight_rows)} weights"
        for reference in _REFERENCE.findall(poles[1]):
            point = self.record(int(reference))
            if not point:
                return f"control point #{int(reference)} does not exist"
            if re.search(rb"nan|inf|ind|\d[Ee][+]?\d{3}", point.rpartition(b"(")[2], re.IGNORECASE):
                return f"control point #{int(reference)} is not a finite number"
        return None


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", "replace").replace("''", "'")
