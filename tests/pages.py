"""Pages in a headless browser, as their readers see them."""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np
from PIL import Image

CHROMIUM = "/usr/bin/chromium"


class Reader:
    """A page with what was asked of the outside and what went wrong."""

    def __init__(self, page: Any, url: str) -> None:
        self.page = page
        self.url = url
        self.errors: list[str] = []
        self.requests: list[str] = []
        page.on(
            "console", lambda message: self.errors.append(message.text) if message.type != "log" else None
        )
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))
        page.set_default_timeout(60_000)
        page.goto(url)

    def hash(self, holding: str) -> str:
        """The address's state, once it holds the text: it is written with a delay."""
        self.page.wait_for_function("text => location.hash.includes(text)", arg=holding)
        return str(self.page.evaluate("location.hash"))


def luminance(reader: Reader, selector: str, property: str) -> float:
    color = reader.page.locator(selector).first.evaluate("(e, p) => getComputedStyle(e)[p]", property)
    return sum(float(x) for x in re.findall(r"[\d.]+", color)[:3]) / 765


def pixels_of(data: bytes) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Of a PNG, (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
