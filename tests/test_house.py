"""The rules of the house hold, and each can fail; a module that no layer lists is an error."""

import importlib.util
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from places import ROOT

CONTAINERS = ("runtime", "runtime.core", "hil_sim", "hil_sim.scenes", "models")


def _load() -> Any:
    spec = importlib.util.spec_from_file_location("house", ROOT / "scripts" / "house.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


house = _load()


def test_the_rules_hold(capfd: pytest.CaptureFixture[str]) -> None:
    status = house.main()
    numbers, problems = capfd.readouterr()
    assert status == 0, problems
    print(numbers)


def test_a_long_file_and_a_long_function_are_told() -> None:
    long_file = "x = 1\n" * 351
    long_function = "def f():\n" + "    x = 1\n" * 45
    fits = "def f():\n" + "    x = 1\n" * 44
    code = {"runtime/a.py": long_file, "runtime/b.py": long_function, "runtime/c.py": fits}
    assert house.too_long(code) == [
        "runtime/a.py: 351 lines, 350 at most: divide it by its parts",
        "runtime/b.py:f: 46 lines, 45 at most",
    ]


def test_methods_are_measured_too() -> None:
    method = "class A:\n    def f(self):\n" + "        x = 1\n" * 45
    assert len(house.too_long({"models/a.py": method})) == 1


def test_two_public_classes_of_one_name_are_told() -> None:
    code = {
        "runtime/a.py": "class Plan: ...\nclass _Own: ...\n",
        "hil_sim/b.py": "class Plan: ...\nclass _Own: ...\nclass Other: ...\n",
    }
    assert house.same_class_names(code) == [
        "class Plan: in runtime/a.py and hil_sim/b.py: a name means one thing"
    ]


@pytest.mark.parametrize("room", ["work", "root", "farm", "home/ann"])
def test_a_path_of_one_machine_is_told(room: str) -> None:
    line = f'HERE = "/{room}/main/file.json"'
    assert len(house.machine_paths({"a.md": f"first\n{line}\n"})) == 1


@pytest.mark.parametrize(
    "line",
    [
        "--scene out/home/scene.json",
        "detector = '/opt/models/detector.onnx'",
        "/etc/rf-nav/robot.toml",
        "https://example.org/work/of/others",
        "~/work/rf-nav and $HOME/work/rf-nav",
    ],
)
def test_a_path_of_the_reader_s_own_machine_is_none(line: str) -> None:
    assert house.machine_paths({"a.md": line}) == []


def test_a_test_without_a_room_is_told() -> None:
    room = "hil_sim/scenes/open.py"
    assert house.tests_without_a_room([room, "tests/hil_sim/scenes/test_open.py"]) == []
    assert house.tests_without_a_room([room, "tests/whole/test_a.py", "tests/conftest.py"]) == []
    assert house.tests_without_a_room([room, "tests/hil_sim/homes/test_open.py"]) == [
        "tests/hil_sim/homes/test_open.py: there is no hil_sim/homes/ that it tests"
    ]


@pytest.mark.parametrize(
    "line",
    [
        "open('a')",
        "x = map(open, names)",
        "path.open('rb')",
        "path.read_text()",
        "path.read_bytes()",
        "path.write_text('a')",
        "path.write_bytes(b'a')",
        "np.load('a.npy')",
        "numpy.save('a.npy', x)",
        "x.tofile('a')",
        "cv2.imread('a.png')",
        "cv2.imwrite('a.png', x)",
        "from cv2 import imread",
        "from numpy import load",
    ],
)
def test_a_file_that_the_core_opens_is_told(line: str) -> None:
    [said] = house.files_opened({"runtime/core/a.py": f"import math\n{line}\n"})
    assert said.startswith("runtime/core/a.py:2: ")


def test_what_opens_no_file_may_stand_in_the_core() -> None:
    lines = "cv2.morphologyEx(a, cv2.MORPH_OPEN, k)\ndoor.open\njson.loads(a)\nnp.zeros(3)\n"
    assert house.files_opened({"runtime/core/a.py": lines}) == []


def test_a_module_that_no_layer_lists_is_an_error(tmp_path: Path) -> None:
    """The layers of pyproject.toml on a tree of empty modules: kept, and broken by a new one."""
    for package in house.PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            copy = tmp_path / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.touch()
    before = _lint_layers(tmp_path)
    assert before.returncode == 0, before.stdout
    for container in CONTAINERS:
        (tmp_path / container.replace(".", "/") / "nowhere.py").touch()
    after = _lint_layers(tmp_path)
    assert after.returncode == 1
    # Wrapped as the terminal's width asks: white space is none of the message.
    said = re.sub(r"\s", "", after.stdout)
    for container in CONTAINERS:
        assert f"{container}.nowhere" in said


def _lint_layers(root: Path) -> subprocess.CompletedProcess[str]:
    """lint-imports in `root`, with this checkout's contracts of layers."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    lines = ["[tool.importlinter]", f"root_packages = {json.dumps(contracts['root_packages'])}"]
    for contract in contracts["contracts"]:
        if contract["type"] == "layers":
            kept = {key: value for key, value in contract.items() if key != "ignore_imports"}
            lines += ["[[tool.importlinter.contracts]]"]
            lines += [f"{key} = {json.dumps(value)}" for key, value in kept.items()]
    (root / "pyproject.toml").write_text("\n".join(lines))
    program = Path(sys.executable).with_name("lint-imports")
    return subprocess.run(
        [program, "--no-cache"],
        cwd=root,
        env=os.environ | {"PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
    )
