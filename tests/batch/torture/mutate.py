"""Damage to a model's bytes, named by an operation and a seed, so that a recipe stands for a file."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from dataclasses import dataclass

_REFERENCE = re.compile(rb"#\d+")
_REAL = re.compile(rb"-?\d+\.\d*(?:E[-+]?\d+)?")
_KEYWORD = re.compile(rb"=\s*([A-Z_0-9]+)\s*\(")


@dataclass(frozen=True)
class Recipe:
    """model: path under the samples or the models; operation: of OPERATIONS."""

    model: str
    operation: str
    seed: int

    def make(self, data: bytes) -> bytes:
        """data: the model's bytes."""
        words = random.Random(f"{self.model} {self.operation} {self.seed}")
        return OPERATIONS[self.operation](data, words)

    @property
    def name(self) -> str:
        stem, dot, extension = self.model.rpartition("/")[2].rpartition(".")
        return f"{stem}-{self.operation}-{self.seed}{dot}{extension}"


def _cut(data: bytes, words: random.Random) -> bytes:
    return data[: words.randrange(1, len(data))]


def _flip(data: bytes, words: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(words.randint(1, 30)):
        out[words.randrange(len(out))] ^= 1 << words.randrange(8)
    return bytes(out)


def _noise(data: bytes, words: random.Random) -> bytes:
    at, length = words.randrange(len(data)), words.randint(1, 200)
    return data[:at] + words.randbytes(length) + data[at + words.randrange(length) :]


def _digits(data: bytes, words: random.Random) -> bytes:
    out = bytearray(data)
    places = [i for i in range(_body(data), len(out)) if out[i] in b"0123456789"]
    for _ in range(words.randint(1, 40)):
        out[words.choice(places)] = words.choice(b"0123456789")
    return bytes(out)


def _references(data: bytes, words: random.Random) -> bytes:
    """Entities that refer to any other, themselves and those that hold them included."""
    there = _REFERENCE.findall(data)
    return _replace(data, _REFERENCE, lambda _: words.choice(there), words.randint(1, 12), words)


def _types(data: bytes, words: random.Random) -> bytes:
    there = _KEYWORD.findall(data)
    return _replace(data, _KEYWORD, lambda _: b"=" + words.choice(there) + b"(", words.randint(1, 6), words)


def _reals(data: bytes, words: random.Random) -> bytes:
    odd = (b"1.E+300", b"-1.E+308", b"1.E-320", b"0.", b"-0.", b"1.E+9", b"-1.", b"", b"$", b"1.E+999", b"1")
    return _replace(data, _REAL, lambda _: words.choice(odd), words.randint(1, 12), words)


def _nan(data: bytes, words: random.Random) -> bytes:
    return _replace(
        data, _REAL, lambda _: words.choice((b"NaN", b"nan", b"-inf")), words.randint(1, 6), words
    )


def _whole(data: bytes, words: random.Random) -> bytes:
    """Counts, degrees and multiplicities that are too large, negative, or nothing."""
    odd = (b"2147483647", b"-1", b"0", b"99999999999", b"1000000", b"25", b"2", b"")
    return _replace(data, re.compile(rb"(?<![\w#.+-])\d+(?![\w.])"), lambda _: words.choice(odd), 4, words)


def _parentheses(data: bytes, words: random.Random) -> bytes:
    depth = words.choice((50, 5_000, 200_000))
    places = [m.end() for m in re.finditer(rb"\(", data)] or [0]
    at = words.choice(places)
    return data[:at] + b"(" * depth + (b")" * depth if words.random() < 0.5 else b"") + data[at:]


def _drop(data: bytes, words: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    for _ in range(words.randint(1, 5)):
        del lines[words.randrange(len(lines))]
    return b"".join(lines)


def _repeat(data: bytes, words: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    for _ in range(words.randint(1, 5)):
        lines.insert(words.randrange(len(lines)), words.choice(lines))
    return b"".join(lines)


def _swap(data: bytes, words: random.Random) -> bytes:
    """Values of two records change places."""
    lines = data.splitlines(keepends=True)
    for _ in range(words.randint(1, 10)):
        a, b = words.randrange(len(lines)), words.randrange(len(lines))
        lines[a], lines[b] = lines[b], lines[a]
    return b"".join(lines)


def _replace(
    data: bytes, what: re.Pattern[bytes], by: Callable[[bytes], bytes], count: int, words: random.Random
) -> bytes:
    """Some matches in the body of the file are replaced."""
    found = list(what.finditer(data, _body(data)))
    if not found:
        return _flip(data, words)
    out, last = [], 0
    for match in sorted(words.sample(found, min(count, len(found))), key=lambda m: m.start()):
        out += [data[last : match.start()], by(match.group())]
        last = match.end()
    return b"".join([*out, data[last:]])


def _body(data: bytes) -> int:
    """Where the records of a STEP file begin; headers are hardly read."""
    return max(0, data.find(b"DATA;"))


Operation = Callable[[bytes, random.Random], bytes]
OPERATIONS: dict[str, Operation] = {
    "cut": _cut,
    "flip": _flip,
    "noise": _noise,
    "digits": _digits,
    "references": _references,
    "types": _types,
    "reals": _reals,
    "nan": _nan,
    "whole": _whole,
    "parentheses": _parentheses,
    "drop": _drop,
    "repeat": _repeat,
    "swap": _swap,
}
