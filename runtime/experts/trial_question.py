"""A question to try experts with, whose right answer is plain."""

from typing import Final

from runtime.core.types import Brief, FrontierBrief, NearbyObject

TRIAL: Final = Brief(
    "toilet",
    0,
    (
        FrontierBrief(1, 2.0, (NearbyObject("bathtub", 0.9, 0.6),), (("bathroom", 0.9),)),
        FrontierBrief(2, 1.0, (NearbyObject("stove", 0.9, 0.8),), (("kitchen", 0.9),)),
    ),
)
"""Whoever answers sensibly goes for 1. Its names are the vocabulary's, and were counted."""
