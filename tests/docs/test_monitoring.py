"""docs/monitoring.md has every metric that there is, each field of the journal, and no other."""

import re

import pytest
from manual_clock import ManualClock
from places import ROOT
from prometheus_client.core import Metric

from runtime.config import load
from runtime.service.metrics import Exported
from runtime.service.recollection import DECISIONS_KEPT, STOPS_KEPT
from runtime.service.telemetry import Telemetry, untold
from runtime.tracing.budgets import read_budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

PAGE = (ROOT / "docs" / "monitoring.md").read_text(encoding="utf-8")
STATUS = {
    "models": {"cloud": {"calls": 3, "run_usd": 0.25}},
    "streams": {"odom": {"received": 9, "bad": 1, "arrival_s": 9.5}},
    "halts": {"frame": 2},
}


def row(metric: Metric) -> tuple[str, str, str, str]:
    name = metric.name + ("_total" if metric.type == "counter" else "")
    labels = metric._labelnames  # type: ignore[attr-defined]
    told = ", ".join(f"`{label}`" for label in labels)
    return f"`{name}`", metric.type, told, metric.documentation


def test_the_table_of_metrics_is_what_is_exported():
    clock = ManualClock()
    telemetry, tracer = Telemetry(clock, tell=untold), Tracer(read_budgets(), clock.now_s)
    tracer.book(Stage.SURVEY, 0.01)
    telemetry.note(STATUS)
    exported = [row(metric) for metric in Exported(telemetry, tracer, clock.now_s).collect()]
    _, _, table = PAGE.partition("| metric | type | labels | |\n|---|---|---|---|\n")
    lines = table.partition("\n\n")[0].splitlines()
    assert [
        tuple(cell.strip() for cell in line.strip("|").split("|")) for line in lines
    ] == exported


def test_the_fields_of_the_journal_are_those_that_are_sent():
    source = (ROOT / "runtime" / "service" / "telemetry.py").read_text(encoding="utf-8")
    sent = set(re.findall(r"\b([A-Z]+)=", source)) | set(
        re.findall(r'"([A-Z]+(?:_[A-Z]+)*)":', source)
    )
    fields = PAGE.partition("## The journal")[2].partition("## Prometheus")[0]
    told = set(re.findall(r"`RFNAV_(\w+)`", fields.partition("```sh")[0]))
    assert told == sent


@pytest.mark.parametrize("event", ["goal", "decision", "halt", "standing", "result"])
def test_its_events_are_told(event: str):
    assert f"`{event}`" in PAGE


def test_its_numbers_are_so():
    assert DECISIONS_KEPT == STOPS_KEPT == 64
    assert "The newest 64 of each" in PAGE
    port = int(re.findall(r"metrics\.port = (\d+)", PAGE)[0])
    assert load(None, [f"metrics.port={port}"]).metrics.port == port
    assert load(None).metrics.port == 0
    assert f"127.0.0.1:{port}/metrics" in PAGE
