"""`hil-sim counts` from the outside: the file that it writes is the one that is read."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from hil_sim.commands.counts import counts_command
from hil_sim.importers import standing_counts
from hil_sim.importers.standing_counts import HomeCounts
from models.words.counts import load_counts


def test_what_is_written_can_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    public = HomeCounts()
    public.add_room("kitchen", [("mug", (0.0, 0.0, 1.0, 1.0)), ("stove", (1.0, 0.0, 2.0, 1.0))])
    monkeypatch.setattr(standing_counts, "public_rooms", lambda: public)
    out = tmp_path / "counts.json"
    done = CliRunner().invoke(counts_command, ["--homes", "1", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert str(out) in done.output
    counted, generated = load_counts(out)
    assert counted.rooms == {"kitchen": 1}
    assert counted.beside == {"mug": {"stove": 1}, "stove": {"mug": 1}}
    assert generated.rooms["kitchen"] == 1
    assert json.loads(out.read_text())["source"]["made_by"] == "hil-sim counts --homes 1"
