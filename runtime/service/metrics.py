"""Metrics for Prometheus, over HTTP on this computer alone. Whoever asks is answered by a thread of
its own, from what the loop has told last: the loop neither waits for it nor knows of it."""

import socketserver
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler
from typing import Any, Final

from prometheus_client.core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    Metric,
)
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.registry import Collector, CollectorRegistry

from runtime.errors import ConfigError
from runtime.service.telemetry import Telemetry, memory_bytes
from runtime.tracing.tracer import Tracer

LOOPBACK: Final = "127.0.0.1"
PATH: Final = "/metrics"
PATIENCE_S: Final = 2.0  # with whoever connects and asks nothing
STATES: Final = (
    "fault", "stopped", "paused", "held", "degraded", "searching", "starting", "ready",
)  # fmt: skip
"""As `loops.standing.RunState` has them."""


Values = Mapping[Any, float]
"""By what the labels are, a tuple of texts."""


class Exported(Collector):
    """What is told at the moment that somebody asks; a collector of Prometheus' client library."""

    def __init__(self, telemetry: Telemetry, tracer: Tracer, now_s: Callable[[], float]) -> None:
        self._telemetry, self._tracer, self._now_s = telemetry, tracer, now_s

    def collect(self) -> Iterator[Metric]:
        newest = self._telemetry.newest
        status = newest.status
        yield _gauge("rfnav_told_age_seconds", "How long ago the loop told how it stands.", {
            (): self._now_s() - newest.at_s,
        })  # fmt: skip
        yield _gauge("rfnav_memory_bytes", "Memory of the process.", {(): memory_bytes()})
        yield from self._stages()
        yield from _search(status)
        yield _counter(
            "rfnav_goals_total", "Goals that ended, by result.", _by(newest.results), ("result",)
        )
        yield _counter("rfnav_decisions_total", "Decisions.", {(): newest.decisions})
        yield _counter(
            "rfnav_votes_total", "Votes, by expert and the model that answered for it.",
            newest.votes, ("expert", "rung"),
        )  # fmt: skip
        yield _counter(
            "rfnav_abstentions_total", "Votes that were not given, and why.", newest.absences,
            ("expert", "cause"),
        )  # fmt: skip
        yield from _cloud(_table(_table(status, "models"), "cloud"))
        yield from _streams(_table(status, "streams"), status.get("now_s", 0.0))

    def _stages(self) -> Iterator[Metric]:
        """Counted anew with each goal, which Prometheus takes for a restart."""
        took = HistogramMetricFamily(
            "rfnav_stage_seconds", "How long the stages of the loop took.", labels=("stage",)
        )
        over = {}
        for stage, histogram in self._tracer.histograms().items():
            *buckets, (_, n) = histogram.by_octave()
            told = [(f"{edge_s:g}", float(count)) for edge_s, count in buckets]
            took.add_metric((stage.value,), [*told, ("+Inf", float(n))], histogram.total_s)
            over[(stage.value,)] = histogram.over
        yield took
        yield _counter(
            "rfnav_stage_overruns_total", "Stages over their p99 budget.", over, ("stage",)
        )


def _search(status: Mapping[str, Any]) -> Iterator[Metric]:
    state = _table(status, "runtime").get("state", "starting")
    yield _gauge(
        "rfnav_state", "1 for how the runtime stands, 0 for all else.",
        {(one,): float(one == state) for one in STATES}, ("state",),
    )  # fmt: skip
    yield _counter(
        "rfnav_halts_total", "How often the base was held, by kind.",
        _by(_table(status, "halts")), ("kind",),
    )  # fmt: skip
    yield _gauge("rfnav_queue_length", "Goals that wait.", {(): len(status.get("queue") or ())})
    percent = _table(status, "base").get("battery_percent")
    charge = {} if percent is None else {(): percent / 100}
    yield _gauge("rfnav_battery_ratio", "Charge of the robot's battery.", charge)


def _cloud(cloud: Mapping[str, Any]) -> Iterator[Metric]:
    """Nothing where none is configured."""
    known = {"calls": "rfnav_cloud_calls_total", "run_usd": "rfnav_cloud_usd_total"}
    what = {"calls": "Calls of the cloud model.", "run_usd": "US dollars booked for them."}
    for name, metric in known.items():
        yield _counter(metric, what[name], {(): cloud[name]} if name in cloud else {})


def _streams(streams: Mapping[str, Any], now_s: float) -> Iterator[Metric]:
    ages_s = {
        (topic,): max(0.0, now_s - health["arrival_s"])
        for topic, health in streams.items()
        if health.get("arrival_s") is not None
    }
    for name, about, key in (
        ("rfnav_stream_messages_total", "Messages that came, by topic.", "received"),
        ("rfnav_stream_bad_total", "Those of them that could not be used.", "bad"),
    ):
        counted = {(topic,): health.get(key, 0) for topic, health in streams.items()}
        yield _counter(name, about, counted, ("topic",))
    about = "Age of the newest message when the loop told of it."
    yield _gauge("rfnav_stream_age_seconds", about, ages_s, ("topic",))


@contextmanager
def metrics_served(
    port: int, telemetry: Telemetry, tracer: Tracer, now_s: Callable[[], float]
) -> Iterator[None]:
    """Until this ends, GET /metrics on 127.0.0.1 is answered. ConfigError, one line, for a port
    that is taken."""
    registry = CollectorRegistry()
    registry.register(Exported(telemetry, tracer, now_s))
    try:
        server = _Server((LOOPBACK, port), _Handler)
    except OSError as error:
        raise ConfigError(
            f"metrics.port: {port} cannot be opened ({error.strerror}); choose another, or 0"
        ) from error
    server.registry = registry
    thread = threading.Thread(target=server.serve_forever, name="metrics", daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()


class _Server(socketserver.TCPServer):
    """One connection after the other: however many there are, there is one thread."""

    allow_reuse_address = True
    registry: CollectorRegistry

    def handle_error(self, request: object, client_address: object) -> None:
        """Whoever asked has gone: that is no line in the log."""


class _Handler(BaseHTTPRequestHandler):
    timeout = PATIENCE_S
    server: _Server

    def do_GET(self) -> None:
        if not _is_ours(self.headers.get("Host", "")):  # a page in a browser, by a name of its own
            self.send_error(403)
        elif self.path.partition("?")[0] != PATH:
            self.send_error(404)
        else:
            text = generate_latest(self.server.registry)
            self.send_response(200)
            self.send_header("Content-Type", CONTENT_TYPE_LATEST)
            self.send_header("Content-Length", str(len(text)))
            self.end_headers()
            self.wfile.write(text)

    def version_string(self) -> str:
        return "rfnav"

    def log_message(self, *_: object) -> None:
        """Nothing is logged."""


def _is_ours(host: str) -> bool:
    return host.rpartition(":")[0] in (LOOPBACK, "localhost")


def _gauge(name: str, about: str, values: Values, labels: Iterable[str] = ()) -> Metric:
    metric = GaugeMetricFamily(name, about, labels=tuple(labels))
    for of, value in values.items():
        metric.add_metric(of, value)
    return metric


def _counter(name: str, about: str, values: Values, labels: Iterable[str] = ()) -> Metric:
    metric = CounterMetricFamily(name, about, labels=tuple(labels))
    for of, value in values.items():
        metric.add_metric(of, value)
    return metric


def _by(counts: Mapping[str, float]) -> dict[tuple[str, ...], float]:
    return {(name,): count for name, count in counts.items()}


def _table(table: Mapping[str, Any], name: str) -> dict[str, Any]:
    value = table.get(name)
    return value if isinstance(value, dict) else {}
