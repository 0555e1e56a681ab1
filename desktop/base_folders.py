"""Where a user's files are (XDG Base Directory Specification)."""

from __future__ import annotations

import os
from collections.abc import Mapping


def base_folder(environment: Mapping[str, str], variable: str, usual: str) -> str | None:
    """What the variable says; by default, or where that is relative, which is to be ignored, the usual folder
    below the home. None where there is no home."""
    folder, home = environment.get(variable, ""), environment.get("HOME", "")
    if os.path.isabs(folder):
        return folder
    return os.path.join(home, usual) if os.path.isabs(home) else None
