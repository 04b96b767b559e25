"""Who watches over `rfnav run` from beside it: rfnav status, rfnav why, Prometheus."""

import http.client
import json
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from apartment import TWO_ROOMS, Apartment
from places import ROOT
from prometheus_client.parser import text_string_to_metric_families
from run_process import process

from hil_sim.driving.link import free_port
from runtime.core.types import Pose

pytestmark = pytest.mark.slow  # whole processes

PATIENT = "safety.frame_stale_s=4.0", "safety.plan_stale_s=5.0", "safety.depth_stale_s=2.0"


def rfnav(end: str, *words: str) -> tuple[int, str]:
    command = [sys.executable, "-m", "runtime", *words, "--set", f"bus.connect=['{end}']"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=60.0)
    assert done.stderr == ""
    return done.returncode, done.stdout


def metrics(port: int) -> dict[tuple[str, ...], float]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10.0)
    connection.request("GET", "/metrics")
    families = text_string_to_metric_families(connection.getresponse().read().decode())
    return {
        (sample.name, *(value for _, value in sorted(sample.labels.items()))): sample.value
        for family in families
        for sample in family.samples
    }


def test_what_it_does_and_why_it_stood_is_told_while_it_runs(tmp_path: Path):
    home, port, said = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5)), free_port(), list[str]()
    with process(home, 100_000, f"metrics.port={port}", *PATIENT) as (child, robot):
        listening = threading.Thread(target=lambda: said.extend(child.stderr or ()))
        listening.start()
        [end] = [part.split("'")[1] for part in child.args if part.startswith("bus.connect")]
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path)})["accepted"]
        robot.until(lambda: robot.decisions and robot.twist.v_mps > 0)
        _, told = rfnav(end, "status", "--json")
        status = json.loads(told)
        assert (status["goal"], status["journal"]) == ("toilet", str(tmp_path / "decisions.jsonl"))
        _, why = rfnav(end, "why", "1")
        assert why.startswith('Decision 1 of the search for "toilet", ')
        drawn = tmp_path / "map.png"
        code, told = rfnav(end, "map", "--out", str(drawn))
        assert (code, told.partition(":")[0]) == (0, str(drawn))
        assert drawn.stat().st_size > 1000
        _, told = rfnav(end, "where", "toilets", "--json")
        assert json.loads(told)["called"] == "toilet"
        robot.sending.discard("odom")
        robot.until(lambda: "odom" in robot.state()["halt"])
        code, screen = rfnav(end, "status")
        assert code == 1
        # "odometry: …", and where the camera has gone on for 2 s "frame: odom is … behind …"
        assert screen.startswith("WRONG    held: ")
        assert "odom" in screen.splitlines()[0]
        # Of a computer that is busy the last stop may be another: its loop stood still meanwhile.
        last = int(rfnav(end, "why", "--stop")[1].split()[1])
        stops = [rfnav(end, "why", str(number), "--stop")[1] for number in range(1, last + 1)]
        assert any("What to do: Look whether the base's driver runs" in stop for stop in stops)
        robot.sending.add("odom")
        robot.until(lambda: robot.state()["runtime"]["state"] != "held")
        robot.until(lambda: metrics(port).get(("rfnav_halts_total", "odometry"), 0.0) >= 1.0)
        found = metrics(port)
        child.terminate()
        child.wait(30.0)
    listening.join(30.0)
    assert found["rfnav_stage_seconds_count", "tick"] > 0
    assert found["rfnav_told_age_seconds",] < 60.0
    assert found["rfnav_decisions_total",] >= 1.0
    assert any("-> held: odometry" in line for line in said)
    code, why = rfnav(end, "why", "--stop", "1", "--journal", str(tmp_path / "decisions.jsonl"))
    assert code == 0
    assert why.startswith("Stop 1 (held, ")
