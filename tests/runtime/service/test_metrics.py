"""Metrics as Prometheus reads them, and who is answered."""

import http.client
import socket
from collections.abc import Iterator
from typing import Any

import pytest
from manual_clock import ManualClock
from prometheus_client.parser import text_string_to_metric_families

from hil_sim.driving.link import free_port
from runtime.core.types import Absence, Ballot, Brief, FrontierBrief, Missing, Vote
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.errors import ConfigError
from runtime.loops.standing import RunState
from runtime.service import metrics as module
from runtime.service.metrics import STATES, metrics_served
from runtime.service.telemetry import Telemetry, untold
from runtime.tracing.budgets import read_budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

STATUS = {
    "runtime": {"state": "held", "cause": "frame: none"}, "halts": {"frame": 2, "plan": 1},
    "queue": [{"goal": "a chair"}], "base": {"battery_percent": 42.0}, "now_s": 10.0,
    "models": {"cloud": {"calls": 3, "run_usd": 0.25}},
    "streams": {
        "odom": {"received": 9, "bad": 1, "arrival_s": 9.5},
        "scan": {"received": 0, "bad": 0, "arrival_s": None},
    },
}  # fmt: skip


class Watch:
    """A service that has told something, and who reads its metrics."""

    def __init__(self) -> None:
        self.clock = ManualClock(10.0)
        self.telemetry = Telemetry(self.clock, watched=True, tell=untold)
        self.tracer = Tracer(read_budgets(), self.clock.now_s)
        self.port = free_port()

    def ask(self, path: str = "/metrics", **headers: str) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10.0)
        connection.request("GET", path, headers=headers)
        return connection.getresponse()

    def samples(self) -> dict[tuple[str, ...], float]:
        """By name and labels' values, in the order of the labels' names."""
        text = self.ask().read().decode()
        return {
            (sample.name, *(value for _, value in sorted(sample.labels.items()))): sample.value
            for family in text_string_to_metric_families(text)
            for sample in family.samples
        }


@pytest.fixture
def watch() -> Iterator[Watch]:
    watch = Watch()
    with metrics_served(watch.port, watch.telemetry, watch.tracer, watch.clock.now_s):
        yield watch


def decided(telemetry: Telemetry) -> None:
    votes = (Vote("o2f", (7,), ((7, 1.0),), "so", "cloud"),)
    seen = FrontierBrief(7, 1.5, (), ())
    ballot = Ballot(votes, (Missing("sle", Absence.LATE),))
    decision = elect(ballot, (seen,), ConsensusConfig(mode="strict"))
    telemetry.decided(1, "mug", decision, Brief("mug", 0, (seen,)), (), 7, 0.0)


def test_all_that_is_told_is_read(watch: Watch):
    decided(watch.telemetry)
    watch.telemetry.ended("found", "here")
    watch.telemetry.note(STATUS)
    watch.clock.advance(1.5)
    found = watch.samples()
    wanted = {
        ("rfnav_told_age_seconds",): 1.5,
        ("rfnav_state", "held"): 1.0,
        ("rfnav_state", "ready"): 0.0,
        ("rfnav_halts_total", "frame"): 2.0,
        ("rfnav_halts_total", "plan"): 1.0,
        ("rfnav_queue_length",): 1.0,
        ("rfnav_battery_ratio",): 0.42,
        ("rfnav_goals_total", "found"): 1.0,
        ("rfnav_decisions_total",): 1.0,
        ("rfnav_votes_total", "o2f", "cloud"): 1.0,
        ("rfnav_abstentions_total", "late", "sle"): 1.0,
        ("rfnav_cloud_calls_total",): 3.0,
        ("rfnav_cloud_usd_total",): 0.25,
        ("rfnav_stream_messages_total", "odom"): 9.0,
        ("rfnav_stream_messages_total", "scan"): 0.0,
        ("rfnav_stream_bad_total", "odom"): 1.0,
        ("rfnav_stream_age_seconds", "odom"): 0.5,
    }
    assert {key: found.get(key) for key in wanted} == wanted
    assert ("rfnav_stream_age_seconds", "scan") not in found
    assert found[("rfnav_memory_bytes",)] > 10e6


def test_stages_are_a_histogram_with_what_was_over(watch: Watch):
    for seconds in (0.0001, 0.001, 0.1, 50.0):
        watch.tracer.book(Stage.SURVEY, seconds)
    found = watch.samples()
    buckets = {key[1]: n for key, n in found.items() if key[0] == "rfnav_stage_seconds_bucket"}
    assert buckets["0.00032"] == 1
    assert buckets["0.00128"] == 2
    assert buckets["10.4858"] == 3
    assert buckets["+Inf"] == found[("rfnav_stage_seconds_count", "survey")] == 4
    assert found[("rfnav_stage_seconds_sum", "survey")] == pytest.approx(50.1011)
    assert found[("rfnav_stage_overruns_total", "survey")] == 2
    assert not [key for key in found if "tick" in key]


def test_before_anything_was_told_little_is(watch: Watch):
    found = watch.samples()
    assert found[("rfnav_state", "starting")] == 1.0
    assert found[("rfnav_decisions_total",)] == 0.0
    assert not [key for key in found if "cloud" in key[0] or "battery" in key[0]]


def test_the_states_are_those_that_there_are():
    assert set(STATES) == {state.value for state in RunState}


def test_other_paths_and_a_browser_led_here_are_refused(watch: Watch):
    assert watch.ask("/").status == 404
    assert watch.ask("/metrics?x=1").status == 200
    assert watch.ask("/metrics", Host="evil.example:9464").status == 403
    assert watch.ask("/metrics", Host=f"localhost:{watch.port}").status == 200
    answer = watch.ask()
    assert answer.headers["Server"] == "rfnav"
    assert answer.headers["Content-Type"].startswith("text/plain")


def test_who_asks_nothing_holds_up_the_others_for_a_while_only(
    watch: Watch, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(module._Handler, "timeout", 0.05)
    with socket.create_connection(("127.0.0.1", watch.port)) as silent:
        assert watch.ask().status == 200
        silent.sendall(b"GET")
    with socket.create_connection(("127.0.0.1", watch.port)) as rude:
        rude.sendall(b"\x00" * 100_000)
    assert watch.ask().status == 200
    assert capsys.readouterr().err == ""


def test_a_service_that_cannot_be_told_of_is_no_line_in_the_log(
    watch: Watch, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def broken(*_: Any) -> bytes:
        raise BrokenPipeError

    with monkeypatch.context() as patch:
        patch.setattr(module, "generate_latest", broken)
        with pytest.raises(http.client.RemoteDisconnected):
            watch.ask()
    assert watch.ask().status == 200
    assert capsys.readouterr().err == ""


def test_a_port_that_is_taken_is_told(watch: Watch):
    around = watch.telemetry, watch.tracer, watch.clock.now_s
    with (
        pytest.raises(ConfigError, match=rf"metrics.port: {watch.port} cannot be opened \(Address"),
        metrics_served(watch.port, *around),
    ):
        pass


def test_when_it_ends_the_port_is_free(watch: Watch):
    around = watch.telemetry, watch.tracer, watch.clock.now_s
    port = free_port()
    for _ in range(2):
        with metrics_served(port, *around):
            pass
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port))
