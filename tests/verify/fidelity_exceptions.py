"""What is known to differ after a round trip of the store, and why: a table, model by model.

An entry names the findings that it explains, and how large they may be; whatever is beyond is a failure.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from trimray.fidelity import Finding


@dataclass(frozen=True)
class Known:
    """model, section, name: regular expressions, each for the whole of the text. most: of a finding's
    difference, in the unit of its tolerance; None: any. via: "" for every way."""

    model: str
    section: str
    name: str
    reason: str
    most: float | None = None
    via: str = ""

    def explains(self, model: str, via: str, finding: Finding) -> bool:
        texts = (self.model, model), (self.section, finding.section), (self.name, finding.name)
        if not all(re.fullmatch(pattern, text) for pattern, text in texts) or self.via not in ("", via):
            return False
        return self.most is None or (finding.difference is not None and abs(finding.difference) <= self.most)


KNOWN: tuple[Known, ...] = ()


def known_for(model: str, via: str, finding: Finding) -> Known | None:
    return next((known for known in KNOWN if known.explains(model, via, finding)), None)
