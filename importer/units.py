"""Names and sizes of length units."""

# By the names that OCCT, STEP and IGES use, in lower case.
_UNITS: dict[str, tuple[str, float]] = {
    "millimetre": ("mm", 1.0), "mm": ("mm", 1.0),
    "centimetre": ("cm", 10.0), "cm": ("cm", 10.0),
    "decimetre": ("dm", 100.0),
    "metre": ("m", 1000.0), "m": ("m", 1000.0),
    "kilometre": ("km", 1e6), "km": ("km", 1e6),
    "micrometre": ("um", 1e-3), "um": ("um", 1e-3), "micron": ("um", 1e-3),
    "nanometre": ("nm", 1e-6),
    "inch": ("inch", 25.4), "in": ("inch", 25.4), "inches": ("inch", 25.4),
    "foot": ("ft", 304.8), "ft": ("ft", 304.8), "feet": ("ft", 304.8),
    "mile": ("mi", 1609344.0), "mi": ("mi", 1609344.0),
    "mil": ("mil", 0.0254), "uin": ("uin", 2.54e-5),
}  # fmt: skip


def unit_of(name: str) -> tuple[str, float] | None:
    """(our name, mm) of a unit named in a file, None when it is not known."""
    key = name.strip().strip("'").lower().replace("meter", "metre")
    return _UNITS.get(key)


def name_of(unit_mm: float) -> str:
    """Our name of a unit of that size; "X mm" when it has none."""
    for name, size in _UNITS.values():
        if abs(size - unit_mm) <= 1e-9 * size:
            return name
    return f"{unit_mm:g} mm"
