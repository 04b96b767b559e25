"""JSON from outside: size, depth and numbers are bounded before anything is made of it."""

import json
import math
import re
from typing import Any, Final

from runtime.errors import SensorError

MESSAGE_BYTES: Final = 1 << 18
DEPTH: Final = 32
DIGITS: Final = 40  # of a whole number: a stamp in nanoseconds has 19
_STEPS: Final = re.compile(rb'"(?:[^"\\]|\\.)*+"?|[\[{]|[\]}]', re.DOTALL)


def parse_json(text: str | bytes, topic: str, most_bytes: int = MESSAGE_BYTES) -> dict[str, Any]:
    """A JSON object in UTF-8 -> dict. SensorError, one line, for anything else."""
    raw = text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass")
    if len(raw) > most_bytes:
        raise SensorError(f"{topic}: {len(raw)} bytes of JSON: at most {most_bytes}")
    if _deeper(raw, DEPTH):
        raise SensorError(f"{topic}: JSON nested deeper than {DEPTH}: send plain values")
    try:
        value = json.loads(
            raw.decode("utf-8"), parse_int=_whole, parse_float=_finite, parse_constant=_finite
        )
    except ValueError as error:
        raise SensorError(f"{topic}: not JSON ({error}); send a JSON object") from error
    if not isinstance(value, dict):
        raise SensorError(f"{topic}: JSON {type(value).__name__}: send a JSON object")
    return value


def _deeper(raw: bytes, depth: int) -> bool:
    """Whether brackets outside of strings are nested deeper."""
    if raw.count(b"[") + raw.count(b"{") <= depth:
        return False
    within = 0
    for step in _STEPS.finditer(raw):
        first = raw[step.start()]
        if first in b"[{":
            within += 1
            if within > depth:
                return True
        elif first in b"]}":
            within -= 1
    return False


def _whole(digits: str) -> int:
    if len(digits) > DIGITS:
        raise ValueError(f"a whole number of {len(digits)} digits")
    return int(digits)


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:20]} is no finite number")
    return value
