"""Which packages a robot of another kind has to compile."""

import importlib.util
import subprocess
import sys
from typing import Any

import pytest
from places import ROOT


def _load(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    spec = importlib.util.spec_from_file_location("wheels", ROOT / "scripts" / "wheels.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def wheels(monkeypatch: pytest.MonkeyPatch) -> Any:
    return _load(monkeypatch)


def test_what_is_to_be_compiled_comes_first(wheels: Any) -> None:
    kinds = {"a==1": "wheel", "z==2": "compiled", "b==3": "wheel"}
    assert wheels.table(kinds, kinds.__getitem__) == [
        "compiled  z==2",
        "wheel     a==1",
        "wheel     b==3",
        "2 have wheels, 1 are compiled",
    ]


def test_pip_is_asked_and_its_answer_told_from_its_silence(
    wheels: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[str]] = []
    answer = 0, ""

    def pip(command: list[str], **_: Any) -> subprocess.CompletedProcess[str]:
        asked.append(command)
        return subprocess.CompletedProcess(command, answer[0], "", answer[1])

    monkeypatch.setattr(wheels.subprocess, "run", pip)
    assert wheels.ask("numpy==2.4.6", "aarch64", "3.11") == "wheel"
    assert {"--dry-run", "--no-deps", "--only-binary=:all:", "numpy==2.4.6"} <= set(asked[0])
    assert {"--platform=manylinux_2_28_aarch64", "--python-version=3.11"} <= set(asked[0])
    answer = 1, "ERROR: No matching distribution found for x==1"
    assert wheels.ask("x==1", "aarch64", "3.11") == "compiled"
    answer = 1, "WARNING: a\nERROR: no network\n"
    with pytest.raises(OSError, match=r"^x==1: ERROR: no network$"):
        wheels.ask("x==1", "aarch64", "3.11")


def test_more_than_it_takes_is_refused(
    wheels: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["wheels", "a", "b", "c"])
    assert wheels.main() == 2
    assert "scripts/wheels [aarch64] [3.11]" in capsys.readouterr().err
