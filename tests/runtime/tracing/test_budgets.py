"""What each stage may take, read from TOML; what is wrong is told in a line."""

from pathlib import Path

import pytest
from places import ROOT

from runtime.errors import ConfigError
from runtime.tracing.budgets import Shed, read_budgets
from runtime.tracing.stages import Stage

LOOP = """
[loop]
late_p99_ms = 5
late_p999_ms = 20
late_max_ms = 50
detector_hz = 5
experts_share = 0.5
ready_s = 5
first_command_s = 0.5
memory_mb = 700
growth_mb_h = 20
"""


def test_every_stage_has_a_budget_and_control_is_shed_by_nothing():
    shipped = read_budgets()
    assert set(shipped.stages) == set(Stage)
    assert all(b.median_ms < b.p99_ms for b in shipped.stages.values())
    assert set(Shed) == {"nothing", "detector", "experts"}
    assert read_budgets(ROOT / "deploy" / "budgets.toml") == shipped


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[stages.surveys]\nmedian_ms = 1\np99_ms = 2", "stages.surveys: unknown; known are late"),
        ("[stages.act]\nmedian_ms = 1", "stages.act.p99_ms: is None, must be a number"),
        ("[stages.act]\nmedian_ms = true\np99_ms = 2", "stages.act.median_ms: is True"),
        ("[stages.act]\nmedian_ms=1\np99_ms=2\nshed='control'", "stages.act.shed: is 'control'"),
        ("[stages.act]\nmedian_ms=1\np99_ms=2\nmax_ms=3", "stages.act.max_ms: unknown; known"),
        ("[stages]\nact = 3", "stages.act: must be a table"),
        ("[limits]", ".limits: unknown; known are stages, loop"),
        ("[stages", "not valid TOML"),
    ],
)
def test_what_is_wrong_with_a_file_is_one_line(tmp_path: Path, text: str, said: str):
    path = tmp_path / "mine.toml"
    path.write_text(text + LOOP)
    with pytest.raises(ConfigError) as caught:
        read_budgets(path)
    assert str(caught.value).startswith(str(path))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_budgets(tmp_path / "nowhere.toml")


def test_a_loop_without_its_figures_is_an_error(tmp_path: Path):
    path = tmp_path / "mine.toml"
    path.write_text(LOOP.replace("memory_mb = 700", ""))
    with pytest.raises(ConfigError, match=r"loop\.memory_mb: is None"):
        read_budgets(path)
