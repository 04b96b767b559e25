"""What the service knows of the home, as it is asked from a shell."""

import json
from collections.abc import Iterator
from pathlib import Path

import cv2
import pytest
from lived_in import lived_in
from service_double import ServiceDouble

from runtime.errors import BusError, ConfigError
from runtime.service.atlas import atlas_of, nothing_told

KNOWN = atlas_of(lived_in(), (("mug", "cup"),), "odom", (0.0, 0.0))
EXPECTED = {"kind": "frontier", "id": 7, "xy": [3.04, -0.4], "p": 0.6, "why": "o2f: sink"}


@pytest.fixture
def service() -> Iterator[ServiceDouble]:
    answers = {kind: KNOWN.told(kind, "cup") for kind in ("things", "where", "map")}
    answers["zones"] = {"accepted": True, "zones": [], "bound": True}
    answers["places"] = {"accepted": True, "places": {"dock": [0.5, 0.5, 0.0]}, "memory": "none"}
    with ServiceDouble(**answers).up() as double:
        yield double


def test_things_are_listed(service: ServiceDouble):
    done = service.run("things")
    assert done.exit_code == 0
    head, row = done.stdout.splitlines()
    assert head.split() == ["sure", "thing", "at", "x,", "y", "m", "size", "m", "room"]
    assert row.split()[:3] == ["95", "%", "mug"]
    assert row.endswith("kitchen")
    assert json.loads(service.run("things", "--json").stdout) == KNOWN.told("things")


def test_what_comes_from_the_robot_cannot_steer_a_terminal(service: ServiceDouble):
    told = KNOWN.told("things")
    service.answers["things"] = {**told, "things": [{**told["things"][0], "name": "\x1b[2Jmug"}]}
    assert "\x1b" not in service.run("things").stdout


@pytest.mark.parametrize(("kind", "words"), [("things", ()), ("map", ("--out", "no.png"))])
def test_while_nothing_is_known_that_is_said(service: ServiceDouble, kind: str, words: tuple):
    service.answers[kind] = nothing_told(kind, "", "odom")
    done = service.run(kind, *words)
    assert (done.exit_code, done.stdout) == (1, "")
    assert done.stderr.startswith("rfnav: nothing is known yet")
    assert not Path("no.png").exists()


def test_where_something_was_seen_is_said(service: ServiceDouble):
    done = service.run("where", "cup")
    assert service.heard == [("where", {"name": "cup"})]
    assert (done.exit_code, done.stdout) == (0, "mug: at (1.0, 0.8) m in the kitchen, 94 % sure\n")


def test_where_something_is_expected_is_said(service: ServiceDouble):
    service.answers["where"] = {**KNOWN.told("where", "sofa"), "expected": [EXPECTED]}
    done = service.run("where", "sofa")
    assert done.exit_code == 1
    assert done.stdout == (
        "sofa: not seen yet\n  expected 60 %: frontier 7, at (3.0, -0.4) m: o2f: sink\n"
    )
    assert json.loads(service.run("where", "sofa", "--json").stdout)["expected"] == [EXPECTED]


def test_a_refusal_is_one_line(service: ServiceDouble):
    service.answers["where"] = {"accepted": False, "error": "a name has at most 80 characters"}
    with pytest.raises(BusError, match=r"^a name has at most 80 characters$"):
        raise service.run("where", "m" * 90).exception


def test_the_map_is_drawn(service: ServiceDouble, tmp_path: Path):
    out = tmp_path / "map.png"
    done = service.run("map", "--out", str(out))
    assert (done.exit_code, done.stdout) == (0, f"{out}: 1 things, 0 frontiers\n")
    assert cv2.imread(str(out)).shape[1] >= 800
    assert json.loads(service.run("map", "--json").stdout) == KNOWN.told("map")
    with pytest.raises(ConfigError, match="cannot be written"):
        raise service.run("map", "--out", str(tmp_path / "no" / "map.png")).exception


def test_a_map_has_to_go_somewhere(service: ServiceDouble):
    done = service.run("map")
    assert done.exit_code == 2
    assert "say --out map.png, or --json" in done.output
