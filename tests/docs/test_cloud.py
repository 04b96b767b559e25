"""The configurations in docs/cloud.md can be used as they stand there."""

import re
import textwrap
from pathlib import Path

import pytest
from places import ROOT

from hil_sim.simulation.faults import parse_faults
from models.language.vision import HANDLERS
from runtime.config import load

PAGE = (ROOT / "docs" / "cloud.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^( *)```toml\n(.*?)^ *```$", PAGE, re.MULTILINE | re.DOTALL)


def test_there_are_some() -> None:
    assert len(BLOCKS) >= 6


@pytest.mark.parametrize("block", [textwrap.dedent(text) for _, text in BLOCKS])
def test_a_block_is_a_configuration(block: str, tmp_path: Path) -> None:
    path = tmp_path / "rfnav.toml"
    path.write_text(block, encoding="utf-8")
    load(path)


def test_what_is_named_exists() -> None:
    for name in HANDLERS:
        assert f"`{name}`" in PAGE
    for fault in re.findall(r"--fault (\S+?)`", PAGE):
        parse_faults([fault])
