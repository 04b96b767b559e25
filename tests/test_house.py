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
    sys.path.append(str(ROOT / "scripts"))  # where its other half lies
    spec = importlib.util.spec_from_file_location("house", ROOT / "scripts" / "house.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


house = _load()
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]


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


@pytest.mark.parametrize(
    "second",
    [
        "if True:\n    class Plan: ...\n",
        "try:\n    import a\nexcept ImportError:\n    class Plan: ...\n",
        "Plan = NamedTuple('Plan', [('a', int)])\n",
        "Plan = collections.namedtuple('Plan', 'a b')\n",
    ],
)
def test_a_class_of_that_name_is_seen_however_it_is_made(second: str) -> None:
    code = {"runtime/a.py": "class Plan: ...\n", "models/b.py": second}
    assert len(house.same_class_names(code)) == 1


def test_what_is_no_class_of_the_module_may_have_a_name_again() -> None:
    others = "Plan = make(3)\ndef f():\n    class Plan: ...\nclass A:\n    class Plan: ...\n"
    assert (
        house.same_class_names({"runtime/a.py": "class Plan: ...\n", "models/b.py": others}) == []
    )


@pytest.mark.parametrize(
    "room", ["work", "root", "farm", "mnt", "data", "workspace", "scratch", "home/ann", "Users/ann"]
)
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
        "https://example.org/data/of/others",
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


@pytest.mark.parametrize("name", ["test_open.py", "test_open_twice.py", "test_shapes_small.py"])
def test_a_test_is_named_after_what_it_tests(name: str) -> None:
    rooms = ["hil_sim/scenes/open.py", "hil_sim/scenes/shapes/__init__.py"]
    assert house.tests_without_a_room([*rooms, f"tests/hil_sim/scenes/{name}"]) == []


@pytest.mark.parametrize("name", ["test_opening.py", "test_the_open.py", "test_twice_open.py"])
def test_a_test_that_is_named_after_nothing_is_told(name: str) -> None:
    path = f"tests/hil_sim/scenes/{name}"
    assert house.tests_without_a_room(["hil_sim/scenes/open.py", path]) == [
        f"{path}: hil_sim/scenes/ has no module that it is named after"
    ]


@pytest.mark.parametrize(
    "line",
    [
        "import datetime",
        "import sqlite3",
        "import logging",
        "import importlib",
        "import os.path",
        "import time as t",
        "from pathlib import Path",
        "from runtime import clock",
        "from runtime.experts.panel import Panel",
        "from models import errors",
        "from . import grid",
        "import corexample",
        "def f():\n    import heapq",
        "if True:\n    from concurrent.futures import Future",
    ],
)
def test_an_import_that_the_core_may_not_have_is_told(line: str) -> None:
    [said] = house.foreign_imports({"runtime/core/a.py": line})
    assert said.endswith(": the core imports only what computes")


def test_what_only_computes_may_be_imported() -> None:
    lines = (
        "import json\nimport cv2\nimport numpy as np\nimport numpy.typing as npt\n"
        "from collections.abc import Iterable\nfrom runtime import core\n"
        "from runtime.core.types import Pose\n"
    )
    assert house.foreign_imports({"runtime/core/a.py": lines}) == []


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
        "read = n.load",
        "np.lib.format.open_memmap('a.npy')",
        "from numpy.lib.format import open_memmap",
        "layout.open_memmap('a.npy')",
        "vision.imread('a.png')",
        "cv2.VideoCapture(0)",
        "cv2.dnn.readNet('a')",
        "cv2.getTickCount()",
        "from cv2 import getTickCount as ticks",
        "__import__('time')",
        "x.tofile('a')",
        "cv2.imread('a.png')",
        "cv2.imwrite('a.png', x)",
        "from cv2 import imread",
        "from numpy import load",
    ],
)
def test_a_file_or_a_clock_that_the_core_reaches_is_told(line: str) -> None:
    imports = (
        "import cv2, numpy, numpy as np, numpy as n, cv2 as vision; from numpy.lib "
        "import format as layout"
    )
    [said] = house.reaches_out({"runtime/core/a.py": f"{imports}\n{line}\n"})
    assert said.startswith("runtime/core/a.py:2: ")


def test_what_opens_no_file_may_stand_in_the_core() -> None:
    lines = "import cv2, json, numpy as np\ncv2.morphologyEx(a, cv2.MORPH_OPEN, k)\n"
    lines += "door.open\njson.loads(a)\nnp.zeros(3)\nbasket.load()\n"
    assert house.reaches_out({"runtime/core/a.py": lines}) == []


@pytest.mark.parametrize(
    "line",
    [
        "import pickle",
        "from pickle import loads",
        "import joblib.numpy_pickle",
        "eval('1')",
        "run = exec",
        "compile('1', 'a', 'eval')",
        "__import__('time')",
        "os.system('ls')",
        "from os import popen as p; p('ls')",
        "subprocess.run('ls', shell=True)",
        "subprocess.Popen(['ls'], shell=given)",
        "asyncio.create_subprocess_shell('ls')",
        "yaml.load(text)",
        "np.load('a.npy')",
        "np.load('a.npy', allow_pickle=True)",
        "np.load('a.npy', allow_pickle=given)",
        "torch.load('a.pt')",
        "torch.load('a.pt', weights_only=False)",
        "importlib.import_module(given)",
        "spec.loader.exec_module(own)",
    ],
)
def test_what_may_run_a_message_or_a_file_as_code_is_told(line: str) -> None:
    imports = "import asyncio, importlib, os, subprocess, torch, yaml, numpy as np\n"
    [said] = house.unsafe({"runtime/a.py": f"{imports}{line}\n"}, {})
    assert said.startswith("runtime/a.py:2: ")
    assert house.unsafe({"hil_sim/a.py": f"{imports}{line}\n"}, {}) == []  # not on the robot


def test_what_runs_nothing_is_not_told() -> None:
    lines = "import re, subprocess, torch, yaml, numpy as np\nre.compile('a')\nnetwork.eval()\n"
    lines += "np.load('a', allow_pickle=False)\ntorch.load('a', weights_only=True)\n"
    lines += "subprocess.run(['ls'], shell=False)\nyaml.safe_load(a)\nllama.eval(tokens)\n"
    assert house.unsafe({"models/a.py": lines}, {}) == []


def test_an_exception_is_for_one_name_in_one_file_and_goes_when_it_is_not_needed() -> None:
    code = {"models/a.py": "import pickle\neval('1')\n", "models/b.py": "import pickle\n"}
    excepted = {("models/a.py", "pickle"): "why", ("models/c.py", "exec"): "why"}
    assert house.unsafe(code, excepted) == [
        "models/a.py:2: eval: runs text as code",
        "models/b.py:1: pickle: reading it runs what somebody wrote",
        "models/c.py: exec: is excepted and not there",
    ]


def test_what_only_tests_use_is_told() -> None:
    code = {
        "runtime/a.py": (
            "class Used: ...\nclass Idle: ...\ndef idle(): ...\ndef _own(): ...\n"
            "@group.command('go')\ndef go(): ...\n@cache\ndef idle_too(): ...\ndef main(): ...\n"
            "def quoted() -> 'Annotated': ...\nclass Annotated: ...\n"
        ),
        "models/b.py": "from runtime.a import Used\nx: 'quoted' = 1  # Idle, idle\n",
    }
    texts = {**code, "tests/test_a.py": "Idle(); idle()", "pyproject.toml": 'a = "a:main"'}
    assert house.only_tested(code, texts) == [
        "runtime/a.py:2: Idle: only tests use it: it belongs to them",
        "runtime/a.py:3: idle: only tests use it: it belongs to them",
        "runtime/a.py:8: idle_too: only tests use it: it belongs to them",
    ]


def test_a_key_too_many_is_told() -> None:
    most = house.ROBOT_KEYS
    keys = [f"map.key{n}" for n in range(most)] + [f"research.key{n}" for n in range(99)]
    assert house.too_many_keys(keys) == []
    assert house.too_many_keys([*keys, "map.one_more"]) == [
        f"{most + 1} keys outside [research], {most} at most: make some constants"
    ]


def test_only_perception_opens_models() -> None:
    """The contract lists everything else in `runtime`: a new room has to be added."""
    [contract] = (c for c in CONTRACTS["contracts"] if c["name"] == "only perception opens models")
    children = {p.stem for p in (ROOT / "runtime").glob("*.py")} | {
        p.parent.name for p in (ROOT / "runtime").glob("*/__init__.py")
    }
    others = children - {"__init__", "perception"}
    assert sorted(contract["source_modules"]) == sorted(f"runtime.{name}" for name in others)


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
    lines = ["[tool.importlinter]", f"root_packages = {json.dumps(CONTRACTS['root_packages'])}"]
    for contract in CONTRACTS["contracts"]:
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
