"""Results as JUnit XML: one test case a value, so that build servers show what differs as failed tests."""

from __future__ import annotations

import re
import xml.etree.ElementTree as xml
from collections.abc import Sequence

from trimray.web_page import shown

from .record import Comparison, Finding
from .report_text import line_of
from .result import Result

# What XML 1.0 cannot hold in any form, beyond what ``shown`` has already escaped.
_NOT_IN_XML = re.compile("[\ufffe\uffff]")


def to_junit(results: Sequence[Result]) -> bytes:
    """A suite a comparison; its cases are named after the values and grouped by section."""
    root = xml.Element("testsuites", name="trimray")
    for result in results:
        if not result.comparisons:
            suite = _suite(root, result.input, 0.0)
            _error(suite, result.input, result.error)
        for comparison in result.comparisons:
            _fill(_suite(root, f"{comparison.a} - {comparison.b}", _seconds(comparison)), result, comparison)
    for suite in root:
        for attribute, tag in (("failures", "failure"), ("errors", "error")):
            suite.set(attribute, str(len(suite.findall(f"testcase/{tag}"))))
        suite.set("tests", str(len(suite.findall("testcase"))))
    for attribute in ("tests", "failures", "errors"):
        root.set(attribute, str(sum(int(suite.get(attribute, "0")) for suite in root)))
    root.set("time", f"{sum(float(suite.get('time', '0')) for suite in root):.3f}")
    xml.indent(root)
    text: bytes = xml.tostring(root, "utf-8")
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + text + b"\n"


def _suite(root: xml.Element, name: str, seconds: float) -> xml.Element:
    return xml.SubElement(root, "testsuite", name=_text(name), time=f"{seconds:.3f}")


def _fill(suite: xml.Element, result: Result, comparison: Comparison) -> None:
    properties = xml.SubElement(suite, "properties")
    for name, value in (
        ("input", result.input),
        ("profile", comparison.profile),
        ("verdict", comparison.verdict),
    ):
        xml.SubElement(properties, "property", name=name, value=_text(value))
    if comparison.error:
        _error(suite, comparison.b, comparison.error)
    for finding in comparison.findings:
        case = _case(suite, comparison.b, finding.section, _name(finding))
        if finding.same:
            continue
        kind = "not compared" if finding.uncompared else "missing" if finding.missing else "different"
        failure = xml.SubElement(case, "failure", type=kind, message=_text(line_of(finding)))
        failure.text = _text(f"A: {finding.a}") + "\n" + _text(f"B: {finding.b}")


def _error(suite: xml.Element, model: str, text: str) -> None:
    case = _case(suite, model, "file", "read")
    xml.SubElement(case, "error", type="failed", message=_text(text))


def _case(suite: xml.Element, model: str, section: str, name: str) -> xml.Element:
    """Its class tells the model: build servers take cases of one class and name for the same test."""
    return xml.SubElement(suite, "testcase", classname=_text(f"{model}.{section}"), name=_text(name))


def _name(finding: Finding) -> str:
    return f"{finding.name} ({finding.where})" if finding.where else finding.name


def _seconds(comparison: Comparison) -> float:
    return sum(comparison.seconds.values())


def _text(text: str) -> str:
    return _NOT_IN_XML.sub("\ufffd", shown(text))
