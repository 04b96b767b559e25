"""`hil-sim placed`: the table of how far off things are placed."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from click.testing import CliRunner

from hil_sim.commands import placed
from hil_sim.evaluation.placed_things import PlacedThing

THINGS = [
    PlacedThing("mug", 0.8, 0.02),
    PlacedThing("chair", 2.0, 0.5),
    PlacedThing("chair", 3.5, 0.04),
    PlacedThing("bed", 6.0, None),
]


def test_a_line_for_each_distance() -> None:
    head, rule, every, *rest = placed.lines(THINGS)
    assert len({line.count("|") for line in (head, rule, every, *rest)}) == 1
    assert every == "| all | 4 | 4 cm | 25.0 % | 25.0 % |"
    assert rest == [
        "| 0 to 1 m away | 1 | 2 cm | 0.0 % | 0.0 % |",
        "| 1 to 3.5 m away | 1 | 50 cm | 100.0 % | 0.0 % |",
        "| 3.5 to 5 m away | 1 | 4 cm | 0.0 % | 0.0 % |",
        "| beyond 5 m | 1 | – | 0.0 % | 100.0 % |",
    ]
    assert placed.lines([])[2] == "| all | 0 | – | – | – |"


def test_views_are_added_up_and_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[list[str], int, int]] = []

    def things(homes: Sequence[str], views: int, seed: int) -> Iterator[list[PlacedThing]]:
        asked.append((list(homes), views, seed))
        yield THINGS[:2]
        yield THINGS[2:]

    monkeypatch.setattr(placed, "placed_things", things)
    out = tmp_path / "placed.json"
    command = ["--homes", "maple, oak", "--views", "2", "--seed", "3", "--json", str(out)]
    done = CliRunner().invoke(placed.placed_command, command, catch_exceptions=False)
    assert asked == [(["maple", "oak"], 2, 3)]
    assert "| all | 4 | 4 cm | 25.0 % | 25.0 % |" in done.output
    assert json.loads(out.read_text()) == [vars(thing) for thing in THINGS]
