"""As much of JSON Schema as schema.json uses, so that its test needs no library."""

from __future__ import annotations

from typing import Any

_TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "boolean": (bool,),
    "integer": (int,),
    "number": (int, float),
    "null": (type(None),),
}
_KNOWN = {
    "$schema", "$defs", "$ref", "title", "description", "type", "const", "enum", "oneOf", "required",
    "properties", "additionalProperties", "items", "minItems", "maxItems", "minimum",
}  # fmt: skip


def violations(value: Any, schema: dict[str, Any]) -> list[str]:
    """Where the value is not what the schema says."""
    found: list[str] = []
    _check(value, schema, schema, "", found)
    return found


def _check(value: Any, rule: dict[str, Any], root: dict[str, Any], at: str, found: list[str]) -> None:
    assert set(rule) <= _KNOWN, f"{at}: the schema uses {set(rule) - _KNOWN}"
    if "$ref" in rule:
        _check(value, root["$defs"][rule["$ref"].removeprefix("#/$defs/")], root, at, found)
    if "type" in rule and not _is(value, rule["type"]):
        found.append(f"{at}: {value!r} is no {rule['type']}")
        return
    if "const" in rule and value != rule["const"]:
        found.append(f"{at}: {value!r} is not {rule['const']!r}")
    if "enum" in rule and value not in rule["enum"]:
        found.append(f"{at}: {value!r} is none of {rule['enum']}")
    if "oneOf" in rule and sum(not _tried(value, one, root) for one in rule["oneOf"]) != 1:
        found.append(f"{at}: {value!r} is not one of its forms")
    if "minimum" in rule and value < rule["minimum"]:
        found.append(f"{at}: {value!r} is below {rule['minimum']}")
    if isinstance(value, list):
        if not rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", len(value)):
            found.append(f"{at}: {len(value)} items")
        for i, item in enumerate(value):
            _check(item, rule.get("items", {}), root, f"{at}/{i}", found)
    if isinstance(value, dict) and rule.get("type") == "object":
        found.extend(f"{at}: no {name}" for name in rule.get("required", ()) if name not in value)
        for name, item in value.items():
            inner = rule.get("properties", {}).get(name, rule.get("additionalProperties", {}))
            if inner is False:
                found.append(f"{at}: {name} is not known")
            else:
                _check(item, inner, root, f"{at}/{name}", found)


def _tried(value: Any, rule: dict[str, Any], root: dict[str, Any]) -> list[str]:
    found: list[str] = []
    _check(value, rule, root, "", found)
    return found


def _is(value: Any, name: str) -> bool:
    if isinstance(value, bool):
        return name == "boolean"
    return isinstance(value, _TYPES[name])
