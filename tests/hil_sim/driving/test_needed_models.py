"""Methods that look with an imported model: what is said when it is not here, or another."""

from pathlib import Path

import pytest

from hil_sim.driving.methods import COW, needed_models
from runtime.errors import ConfigError


@pytest.fixture
def listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The list that an import writes."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    (tmp_path / "rf-nav").mkdir()
    return tmp_path / "rf-nav" / "models.toml"


def entry(name: str, contract: str) -> str:
    files = "".join(f"[[{name}.files]]\nsha256 = '{digest}'\n" for digest in ("abc", "def"))
    return f"[{name}]\ncontract = '{contract}'\n{files}"


@pytest.mark.parametrize("method", COW)
def test_a_missing_model_is_named_with_the_command_that_takes_it_in(
    method: str, listed: Path
) -> None:
    name = "mdetr" if method == "cow-mdetr" else "clip"
    files = "mdetr.onnx --texts tokenizer.json" if name == "mdetr" else "image.onnx --texts text/"
    with pytest.raises(ConfigError, match=f"method {method}: model {name} is not here;") as told:
        needed_models(("rfnav", method))
    assert f"`rfnav models import {files}" in str(told.value)
    assert "\n" not in str(told.value)


def test_what_is_here_is_known_by_its_files(listed: Path) -> None:
    listed.write_text(entry("clip", "clip with relevance") + entry("mdetr", "grounding"))
    assert needed_models(("rfnav", "oracle-goal")) == {}
    assert needed_models(COW) == {"clip": "abc def", "mdetr": "abc def"}


def test_a_model_of_another_contract(listed: Path) -> None:
    listed.write_text(entry("clip", "clip") + entry("mdetr", "yolo v8"))
    assert list(needed_models(("cow-clip-patch", "cow-clip-ref"))) == ["clip"]
    with pytest.raises(ConfigError, match="contract 'clip', not 'clip with relevance'"):
        needed_models(("cow-clip-grad",))
    with pytest.raises(ConfigError, match="contract 'yolo v8', not 'grounding'"):
        needed_models(("cow-mdetr",))
    listed.write_text("[clip")
    with pytest.raises(ConfigError, match=r"models\.toml: not a readable list of models"):
        needed_models(("cow-mdetr",))
