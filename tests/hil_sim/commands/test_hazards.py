"""The table of `hil-sim hazards`."""

from hil_sim.commands.hazards import HEADER, table
from hil_sim.driving.hazards import HazardTrial


def test_what_could_be_avoided_and_what_not_are_counted_apart():
    seen = HazardTrial("box", 1.0, 0.9, 0.4, 5000, 0.2, False, 0.5, 0.3, 0.1)
    hit = HazardTrial("box", 0.6, 0.9, 0.4, 5000, 0.0, True, 0.9, 0.7, None)
    low = HazardTrial("box", 0.6, 0.3, 0.4, 0, 0.0, True, None, None, None)
    leg = HazardTrial("leg", 1.2, 0.7, 0.1, 900, 0.1, False, None, None, 0.2)
    lines = list(table({0.4: [seen, low, leg, hit]}, 30.0, 0.5))
    assert lines[: len(HEADER)] == list(HEADER)
    assert lines[len(HEADER) :] == [
        "| box | 30° down | 0.4 m/s | 3 | 2 | 1 | 1 | 1 | 0.70, 0.90 s | 0.50, 0.70 s "
        "| 0.10, 0.10 s |",
        "| leg | 30° down | 0.4 m/s | 1 | 1 | 0 | 0 | 0 | - | - | 0.20, 0.20 s |",
    ]
    assert next(iter(table({}, 0.0, 0.5))) == HEADER[0]
