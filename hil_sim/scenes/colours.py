"""Colours as scene files write them, "#rrggbb"."""

import colorsys


def rgb_of(colour: str) -> tuple[float, float, float]:
    """ "#rrggbb" -> three numbers in [0, 1]; anything else is mid grey."""
    if len(colour) != 7 or colour[0] != "#":
        return 0.6, 0.6, 0.6
    r, g, b = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return r, g, b


def hex_colour(hue: float, saturation: float, value: float) -> str:
    """Hue, saturation and value in [0, 1] -> "#rrggbb"."""
    rgb = colorsys.hsv_to_rgb(hue, saturation, value)
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in rgb)
