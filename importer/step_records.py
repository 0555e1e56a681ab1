"""Single records of a STEP file, by number: their type, their arguments, and the length units among them."""

import re
from functools import cached_property

_RECORD = re.compile(rb"#(\d+)\s*=\s*((?:[^;']|'[^']*')*);")
_SIMPLE = re.compile(r"\s*([A-Z_][A-Z_0-9]*)\s*\((.*)\)\s*\Z", re.DOTALL)
_PART = re.compile(r"([A-Z_][A-Z_0-9]*)\s*\(")
_UNICODE = re.compile(r"\\X2\\([0-9A-Fa-f]*)\\X0\\|\\X\\([0-9A-Fa-f]{2})|\\S\\(.)")
_PREFIXES = {
    "EXA": 1e18, "PETA": 1e15, "TERA": 1e12, "GIGA": 1e9, "MEGA": 1e6, "KILO": 1e3, "HECTO": 1e2, "DECA": 1e1,
    "DECI": 1e-1, "CENTI": 1e-2, "MILLI": 1e-3, "MICRO": 1e-6, "NANO": 1e-9, "PICO": 1e-12,
}  # fmt: skip
# References among units that are followed, one after the other.
_MOST_LINKS = 8


class StepRecords:
    """data: the whole file."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    @cached_property
    def _bodies(self) -> dict[int, bytes]:
        return {int(match[1]): match[2] for match in _RECORD.finditer(self.data)}

    def of_type(self, name: str) -> list[int]:
        """Numbers of the simple records of one type, in the order of the file."""
        word = name.encode()
        return [n for n, body in self._bodies.items() if body.startswith(word) and self.parts(n).get(name)]

    def parts(self, number: int) -> dict[str, list[str]]:
        """Type -> arguments of a record; several for a complex one, {} where there is no such record."""
        body = self._bodies.get(number, b"")
        try:
            text = body.decode().strip()
        except UnicodeDecodeError:
            text = body.decode("latin-1").strip()
        if text.startswith("("):
            return dict(_complex(text[1:-1]))
        match = _SIMPLE.match(text)
        return {match[1]: split(match[2])} if match else {}

    def length_mm(self, number: int, links: int = _MOST_LINKS) -> float | None:
        """Size of the length unit #number, None where it is none."""
        parts = self.parts(number)
        if links <= 0 or "LENGTH_UNIT" not in parts:
            return None
        if "SI_UNIT" in parts:
            prefix = parts["SI_UNIT"][0].strip(".") if parts["SI_UNIT"] else ""
            return 1000.0 * _PREFIXES.get(prefix, 1.0)
        if "CONVERSION_BASED_UNIT" in parts and len(parts["CONVERSION_BASED_UNIT"]) >= 2:
            measure = self.parts(reference(parts["CONVERSION_BASED_UNIT"][1]))
            for arguments in measure.values():
                factor = number_in(arguments[0]) if arguments else None
                base = self.length_mm(reference(arguments[1]), links - 1) if len(arguments) > 1 else None
                if factor is not None and base is not None:
                    return factor * base
        return None

    def measure_mm(self, number: int, dimension: int) -> float | None:
        """Size of an area (2) or volume (3) unit in mm^2 or mm^3, None where it is not understood."""
        length = self.length_mm(number)
        if length is not None:
            return float(length**dimension)
        elements = self.parts(number).get("DERIVED_UNIT")
        if not elements:
            return None
        factor, exponents = 1.0, 0.0
        for element in references(elements[0]):
            arguments = self.parts(element).get("DERIVED_UNIT_ELEMENT", [])
            base = self.length_mm(reference(arguments[0])) if len(arguments) == 2 else None
            exponent = number_in(arguments[1]) if len(arguments) == 2 else None
            if base is None or exponent is None or abs(exponent) > 10.0:
                return None
            factor, exponents = factor * base**exponent, exponents + exponent
        return factor if exponents == dimension else None

    def context_mm(self, number: int) -> float | None:
        """Size of the length unit of a representation's context."""
        arguments = self.parts(number).get("GLOBAL_UNIT_ASSIGNED_CONTEXT", [])
        for unit in references(arguments[0]) if arguments else []:
            length = self.length_mm(unit)
            if length is not None:
                return length
        return None


def split(text: str) -> list[str]:
    """Arguments at the top level, trimmed."""
    found: list[str] = []
    depth, start, quoted = 0, 0, False
    for i, c in enumerate(text):
        if c == "'":
            quoted = not quoted
        elif quoted:
            continue
        elif c in "()":
            depth += 1 if c == "(" else -1
        elif c == "," and depth == 0:
            found.append(text[start:i].strip())
            start = i + 1
    last = text[start:].strip()
    return [*found, last] if found or last else []


def _complex(text: str) -> list[tuple[str, list[str]]]:
    """The parts of a complex record: A(...) B(...)."""
    found: list[tuple[str, list[str]]] = []
    position = 0
    while match := _PART.search(text, position):
        depth, quoted, end = 1, False, match.end()
        while end < len(text) and depth:
            c = text[end]
            if c == "'":
                quoted = not quoted
            elif not quoted:
                depth += (c == "(") - (c == ")")
            end += 1
        found.append((match[1], split(text[match.end() : end - 1])))
        position = end
    return found


def reference(text: str) -> int:
    """12 of "#12", -1 for anything else."""
    text = text.strip()
    return int(text[1:]) if text.startswith("#") and text[1:].isdigit() else -1


def references(text: str) -> list[int]:
    """Of a list "(#1,#2)"."""
    return [int(n) for n in re.findall(r"#(\d+)", text)]


def number_in(text: str) -> float | None:
    """Of "1.5" or "LENGTH_MEASURE(1.5)"."""
    match = re.search(r"\(([^()]*)\)", text)
    try:
        return float(match[1] if match else text)
    except ValueError:
        return None


def text_of(argument: str) -> str:
    """What a string says, escapes undone."""
    plain = argument.strip()
    plain = plain[1:-1].replace("''", "'") if plain.startswith("'") else ""
    return _UNICODE.sub(_character, plain)


def _character(match: re.Match[str]) -> str:
    if match[1] is not None:
        return bytes.fromhex(match[1][: len(match[1]) // 4 * 4]).decode("utf-16-be", "replace")
    return chr(int(match[2], 16)) if match[2] else chr((ord(match[3]) + 128) & 0x10FFFF)
