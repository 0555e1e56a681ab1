"""Reports of results made by hand: each says all there is to say, whatever the files call themselves."""

from __future__ import annotations

import json
import math
import re
import xml.etree.ElementTree as xml
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trimray.fidelity.record import Comparison, Finding
from trimray.fidelity.report_html import to_html
from trimray.fidelity.report_json import document, plain, schema, to_json
from trimray.fidelity.report_junit import to_junit
from trimray.fidelity.report_text import line_of, to_text
from trimray.fidelity.result import Result, exit_code_of
from trimray.fidelity.tolerances import PROFILES

from .reports import HOSTILE, KINDS, LOST, MOVED, VOLUME, comparison, results
from .validate import violations


def test_the_worst_comparison_is_the_verdict_of_a_result() -> None:
    good, lost = comparison(VOLUME), comparison(LOST)
    assert Result("a", "roundtrip", (good, lost)).verdict == "partial"
    assert Result("a", "roundtrip", (good, good)).verdict == "complete"
    assert Result("a", "check", (), "no such file", 3).verdict == "failed"
    assert exit_code_of([good]) == 0 and exit_code_of([good, lost]) == 7
    assert Result("a", "compare", (comparison(VOLUME, LOST, MOVED),)).differences() == (LOST, MOVED)


def test_the_json_is_what_the_schema_says() -> None:
    assert violations(document(results()), schema()) == []


@pytest.mark.parametrize(
    "change",
    [
        {"format": 2},
        {"results": [{"input": "a"}]},
        {"more": 1},
        {"results": [{**document(results())["results"][0], "verdict": "fine"}]},
        {"results": [{**document(results())["results"][0], "exit_code": "0"}]},
    ],
)
def test_what_the_schema_does_not_say_is_found(change: dict[str, Any]) -> None:
    assert violations(document(results()) | change, schema())


def test_a_strict_validator_agrees() -> None:
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
    jsonschema.Draft202012Validator.check_schema(schema())
    jsonschema.Draft202012Validator(schema()).validate(document(results()))


def test_the_json_holds_every_value_and_its_tolerance() -> None:
    read = json.loads(to_json(results()))
    part = read["results"][1]
    assert (part["input"], part["verdict"], part["exit_code"]) == ("part.step", "partial", 7)
    about = part["comparisons"][0]
    assert (about["values"], about["differences"], about["tolerances"]["volume"]) == (4, 2, 1e-6)
    assert [finding["name"] for finding in about["findings"]] == [
        x.name for x in (VOLUME, MOVED, LOST, KINDS)
    ]
    moved = about["findings"][1]
    assert (moved["b"], moved["difference"], moved["tolerance"], moved["unit"]) == (
        2.5e-3,
        2.5e-3,
        1e-6,
        "mm",
    )
    assert about["pictures"][1] == {
        "view": "front", "size": [64, 64], "differing": {"depth": 12, "normal": 340, "coverage": 64},
    }  # fmt: skip
    assert read["results"][3]["error"].endswith("No such file or directory")


def test_what_json_cannot_hold_is_text() -> None:
    odd = {"a": math.inf, "b": np.array([1.0, math.nan]), "c": np.float64(2.0), "d": "\udcff", 5: {3}}
    assert plain(odd) == {"a": "inf", "b": [1.0, "nan"], "c": 2.0, "d": "\\xff", "5": [3]}


def test_junit_has_a_case_a_value_and_a_failure_a_difference() -> None:
    root = xml.fromstring(to_junit(results()))
    counts = {name: int(root.get(name, "")) for name in ("tests", "failures", "errors")}
    assert counts == {"tests": 9, "failures": 3, "errors": 2}
    suite = root[1]
    cases = suite.findall("testcase")
    assert [case.get("name") for case in cases][1] == "distance of points of A from B (face 12)"
    assert [case.get("classname") for case in cases][1] == "part.step as STEP AP242.geometry"
    failures = suite.findall("testcase/failure")
    assert [failure.get("type") for failure in failures] == ["different", "missing"]
    message = str(failures[0].get("message"))
    assert "2.5e-3" not in message and "difference 0.0025 mm, tolerance 1e-06 mm" in message
    assert root[2].find("testcase/error").get("message") == "the writer ended with 3"  # type: ignore[union-attr]


def test_junit_knows_every_case_by_class_and_name() -> None:
    both = comparison(VOLUME, b="part.step as STEP"), comparison(VOLUME, b="part.step as STEP, twice")
    data = to_junit(
        [Result("part.step", "roundtrip", both), Result("b.step", "check", (comparison(VOLUME, b="b.step"),))]
    )
    cases = [(case.get("classname"), case.get("name")) for case in xml.fromstring(data).iter("testcase")]
    assert len(set(cases)) == len(cases) == 3


def test_junit_survives_hostile_names() -> None:
    nasty = replace(LOST, name="\ufffe\x00\x08" + HOSTILE, reason="\uffff")
    data = to_junit([Result(HOSTILE, "check", (comparison(nasty, a=HOSTILE, b="b"),))])
    (case,) = xml.fromstring(data).findall("testsuite/testcase")
    assert "\\x00\\x08" in str(case.get("name")) and "<img" in str(case.get("name"))
    assert b"\x1b" not in data and b"<img" not in data


def test_the_text_has_the_verdict_first_and_then_the_differences() -> None:
    text = to_text(results())
    lines = text.splitlines()
    assert lines[0].startswith("good.step: complete") and "2 values agree" in lines[0]
    (at,) = (i for i, line in enumerate(lines) if line.startswith("part.step: partial"))
    assert "2 of 4 values differ" in lines[at]
    assert lines[at + 1].split() == ["A", "B", "difference", "tolerance"]
    assert "Bolt:2" in lines[at + 2] and lines[at + 4] == ""
    assert lines[at + 3].split()[-5:] == ["0.0025", "0.0025", "mm", "1e-06", "mm"]
    assert "b.step: failed: by cp: the writer ended with 3" in text


def test_everything_means_all_values_with_what_differs_first() -> None:
    text = to_text(results()[1:2], everything=True)
    names = [line.split("  ")[0] for line in text.splitlines()[2:]]
    assert len(names) == 4
    assert text.index("instance") < text.index("distance of points") < text.index("volume")


def test_nothing_in_a_name_reaches_the_terminal() -> None:
    for text in (to_text(results(), everything=True), line_of(replace(MOVED, where=HOSTILE))):
        assert not set(text) & set("\x1b\u202e\udcff\x9b")
    assert text.encode("utf-8")


def test_a_short_reason_stands_beside_its_values_and_a_long_one_below() -> None:
    for reason, beside in (
        ("only in A", True),
        ("a reason that is too long for the line of its values", False),
    ):
        lines = to_text([Result("a", "compare", (comparison(replace(LOST, reason=reason)),))]).splitlines()
        assert len(lines) == (3 if beside else 4) and lines[-1].endswith(reason)


def test_many_differences_are_cut_and_counted() -> None:
    many = Comparison(
        "a", "b", "default", tuple(replace(MOVED, where=f"face {i}") for i in range(1000)), verdict="changed"
    )
    lines = to_text([Result("a", "compare", (many,))]).splitlines()
    assert len(lines) < 300 and lines[-1] == "  and 800 more; --json has all"


def test_the_page_is_the_same_for_the_same_results() -> None:
    assert to_html(results()) == to_html(results())


def test_the_package_holds_all_files_of_the_reports() -> None:
    root = Path(__file__).resolve().parents[2]
    patterns = set(re.findall(r'PATTERN "(\*\.\w+)"', (root / "CMakeLists.txt").read_text()))
    files = [path for folder in ("fidelity", "api") for path in (root / folder).iterdir() if path.is_file()]
    assert {"schema.json", "report.html", "web_page.css"} <= {path.name for path in files}
    assert [
        path.name for path in files if f"*{path.suffix}" not in patterns and path.name != "py.typed"
    ] == []


def test_a_value_that_is_not_known_has_no_tolerance() -> None:
    assert (
        line_of(Finding("mass", "volume", None, 1.5, False, reason="no solid")) == "volume: - - 1.5, no solid"
    )


def test_the_documented_tolerances_are_those_in_force() -> None:
    text = (Path(__file__).resolve().parents[2] / "docs" / "fidelity.md").read_text()
    rows = {
        "volume, area": ("volume", "area"),
        "inertia": ("inertia",),
        "centroid, bounds, distance, depth": ("centroid", "bounds", "distance", "depth"),
        "placement of an instance": ("placement",),
        "colour, steps of 8 bit": ("color",),
        "normal, radians": ("normal",),
        "pixels of one picture": ("pixels",),
    }
    for title, names in rows.items():
        (line,) = (line for line in text.splitlines() if line.startswith(f"| {title} |"))
        cells = [float(cell) for cell in line.split("|")[2:5]]
        for name in names:
            assert [getattr(PROFILES[p], name) for p in ("strict", "default", "lenient")] == cells, name
