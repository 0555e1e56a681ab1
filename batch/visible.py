"""How much of a picture a viewer can see: a blank one is told from a thin part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trimray.frame import Frame
from trimray.views import Background, parse_background

# Less than this difference from the background, of any channel in [0, 1], is not seen.
_CONTRAST = 6 / 255
# Fewer pixels than this share of the picture, or this number, are a speck: 13 px of 256 x 256.
_SHARE, _PIXELS = 0.0002, 4


@dataclass(frozen=True)
class Visible:
    """covered: share of the pixels that show the model, 0 to 1. seen: of those that differ from the
    background. reason: "" unless blank."""

    covered: float
    seen: float
    blank: bool
    reason: str


def visible(frame: Frame, background: Background) -> Visible:
    """frame: with colour and face. background: as it was drawn on."""
    color = frame["color"]
    count = color.shape[0] * color.shape[1]
    contrast = _contrast(color, background)
    hit = (frame["face"] >= 0) | (contrast > 0.5 / 255)
    covered, seen = int(hit.sum()), int((contrast > _CONTRAST).sum())
    least = max(min(_PIXELS, count), _SHARE * count)
    reason = ""
    if seen < least:
        if covered == 0:
            reason = "blank: no pixel shows the model, which may be thinner than one"
        elif covered < least:
            reason = f"nearly blank: {covered} of {count} pixels show the model"
        else:
            reason = f"nearly blank: {covered} of {count} pixels show the model, in the background's colour"
    return Visible(covered / count, seen / count, bool(reason), reason)


def _contrast(color: npt.NDArray[np.float32], background: Background) -> npt.NDArray[np.float32]:
    """(h, w): largest difference of a channel from the background, in [0, 1]; opacity where it is clear."""
    top, bottom = (np.array(rgba, np.float32) for rgba in parse_background(background))
    if top[3] < 1 or bottom[3] < 1:
        return color[..., 3] - np.float32(min(top[3], bottom[3]))
    down = ((np.arange(color.shape[0], dtype=np.float32) + 0.5) / color.shape[0])[:, None]
    rows = top[:3] + (bottom[:3] - top[:3]) * down
    # Channel by channel: NumPy is slow along an axis of three.
    red, green, blue = (np.abs(color[..., i] - rows[:, i, None]) for i in range(3))
    difference: npt.NDArray[np.float32] = np.maximum(np.maximum(red, green), blue)
    return difference
