"""Places and zones, from a shell."""

import json
from collections.abc import Iterator

import pytest
from service_double import ServiceDouble

from runtime.errors import BusError

PLACES = {
    "accepted": True,
    "memory": "bound by 'dock'",
    "places": {"dock": [1, -2, 0.5], "x": None},
}
ZONES = {"accepted": True, "bound": True,
         "zones": [{"name": "rug", "polygon": [[0, 0], [1.5, 0], [1, -1]]}]}  # fmt: skip


@pytest.fixture
def service() -> Iterator[ServiceDouble]:
    with ServiceDouble(places=PLACES, zones=ZONES).up() as double:
        yield double


@pytest.mark.parametrize(
    ("words", "asked"),
    [
        (("places",), ("places", {"list": True})),
        (("place", "kitchen table", "here"), ("places", {"name": "kitchen table"})),
        (("place", "a", "-1,2.5"), ("places", {"name": "a", "at": [-1.0, 2.5, 0.0]})),
        (("place", "a", "1,2,-0.5"), ("places", {"name": "a", "at": [1.0, 2.0, -0.5]})),
        (("place", "dock", "i-am-here"), ("places", {"i_am_at": "dock"})),
        (("place", "dock", "remove"), ("places", {"remove": "dock"})),
        (("zone", "list"), ("zones", {"list": True})),
        (
            ("zone", "add", "rug", "-1,0", "1,0", "0,-1.5"),
            ("zones", {"add": "rug", "polygon": [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.5]]}),
        ),
        (("zone", "remove", "rug"), ("zones", {"remove": "rug"})),
        (("zone", "clear"), ("zones", {"clear": True})),
    ],
)
def test_each_command_asks_for_its_own(service: ServiceDouble, words, asked):
    done = service.run(*words)
    assert done.exit_code == 0
    assert service.heard == [asked]
    if asked[0] == "places":
        assert done.stdout == "dock: at 1.00, -2.00 m, yaw 0.50\nx: not known where\n"
        assert done.stderr == "home: bound by 'dock'\n"
    else:
        assert done.stdout == "rug: 0.00,0.00 1.50,0.00 1.00,-1.00\n"
    assert json.loads(service.run(*words, "--json").stdout) == service.answers[asked[0]]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("place", "a", "there"), "there: must be here, i-am-here, remove or X,Y[,YAW]"),
        (("place", "a", "1"), "1: must be"),
        (("zone", "add", "a", "1,2", "1;2", "3,4"), "1;2: must be X,Y"),
    ],
)
def test_what_is_no_place_is_not_asked_for(service: ServiceDouble, words, said):
    done = service.run(*words)
    assert done.exit_code == 2
    assert said in done.output
    assert service.heard == []


def test_a_warning_and_a_refusal_are_said(service: ServiceDouble):
    service.answers["zones"] = {**ZONES, "warning": "the robot is in it"}
    assert service.run("zone", "list").stderr == "rfnav: the robot is in it\n"
    service.answers["zones"] = {"accepted": False, "error": "zones request: crosses itself"}
    with pytest.raises(BusError, match=r"^zones request: crosses itself$"):
        raise service.run("zone", "add", "a", "0,0", "1,1", "0,1", "1,0").exception


def test_where_there_is_none_that_is_said(service: ServiceDouble):
    service.answers["zones"] = {**ZONES, "zones": []}
    service.answers["places"] = {**PLACES, "places": {}, "memory": "none: it begins here"}
    assert service.run("zone", "list").stderr == "there is no zone\n"
    done = service.run("places")
    assert (done.exit_code, done.stderr) == (1, "no place has a name\n")
