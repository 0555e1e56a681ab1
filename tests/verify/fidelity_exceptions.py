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


_CUT = "OpenCascade's STEP reader cuts edges where a hole touches the seam; the shape stays"
_POLES = (
    "OpenCascade's STEP reader closes loose edges of poles with degenerate ones, and p-curves of their own"
)
_ANEW = (
    "OpenCascade writes the average of all tolerances; its reader then makes p-curves anew, beyond the edges"
)
_STRAY = "OpenCascade's STEP reader makes p-curves anew where they stray from edges, here by 5.5e-6 mm"
_MISS = "OpenCascade's STEP reader makes p-curves anew for edges that miss theirs, and misses by more"
_COLOR = "OpenCascade writes no styles for tessellated faces"

KNOWN: tuple[Known, ...] = (
    Known("hole_touches_seam.step", "topology", "edges|vertices", _CUT, 3, "step"),
    Known("hole_touches_seam.step", "geometry", ".* p-curves .*|p-curve off .*", _CUT, 2e-7, "step"),
    Known("bracket_faces.igs", "mass", "area", _STRAY, 3.2e-5, "step"),
    Known("vsp.stp", "mass", "area", _POLES, 0.82, "step"),
    Known("vsp.stp", "topology", "degenerate edges", _POLES, 2, "step"),
    Known("vsp.stp", "geometry", ".* p-curves .*|p-curve off .*", _POLES, 7.7, "step"),
    Known("IEA_15MW_CFD.igs", "topology", "degenerate edges", _POLES, 2, "step"),
    Known("IEA_15MW_CFD.igs", "geometry", ".* of edges|edge off", _POLES, 0.03, "step"),
    Known("Fly_Gemini_V2.*", "topology", "degenerate edges|vertices", _POLES, 4, "step"),
    Known("Fly_Gemini_V2.*", "geometry", ".* of edges|edge off", _POLES, 3.3e-4, "step"),
    Known("printable_case_full.stp", "geometry", ".* p-curves .*|p-curve off .*", _MISS, 3.7e-4, "step"),
    Known("4040_base_mount.step", "geometry", "largest distance of faces|face off", _ANEW, 2.1e-3, "file"),
    Known("SOT404.igs", "geometry", ".* p-curves .*|p-curve off .*", _ANEW, 1.3e-4, "file"),
    Known("impeller.igs", "mass", "area", _POLES, 1.2, "step"),
    Known("impeller.igs", "topology", "degenerate edges", _POLES, 106, "step"),
    Known("impeller.igs", "geometry", ".* of faces|face off", _POLES, 0.05, "step"),
    Known("impeller.igs", "geometry", ".* p-curves .*|p-curve off .*", _POLES, 5e-3, "step"),
    Known("impeller.igs", "pictures", ".*", _POLES, 1, "step"),
    Known("nist_ftc_08.*-tg.stp", "structure", "colours?", _COLOR),
    Known("nist_ftc_08.*-tg.stp", "pictures", ".*", _COLOR),
)


def known_for(model: str, via: str, finding: Finding) -> Known | None:
    return next((known for known in KNOWN if known.explains(model, via, finding)), None)
