"""Against a real OpenAI-compatible server: the one that llama-cpp-python ships, with a small model
and a projector of random weights. What it says means little; how it says it is what matters."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import httpx
import numpy as np
import pytest
from mmproj import write_mmproj

from models.store import manifest
from runtime.clock import Deadline, SystemClock
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, NearbyObject, Vote
from runtime.experts.cloud import Cloud
from runtime.experts.cloud_config import CloudConfig

pytestmark = pytest.mark.slow

KEY = "sk-loopback-0123456789"
READY_S = 120.0


def jpeg(bgr: tuple[int, int, int]) -> bytes:
    return cv2.imencode(".jpg", np.full((60, 80, 3), bgr, np.uint8))[1].tobytes()


BRIEF = Brief(
    "toilet",
    0,
    (
        FrontierBrief(
            4, 1.0, (NearbyObject("sink", 0.9, 0.5),), (("bathroom", 1.0),), image=jpeg((255, 0, 0))
        ),
        FrontierBrief(9, 2.0, (), (("hall", 1.0),), image=jpeg((0, 0, 255))),
    ),
)


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("server")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    arguments = {
        "model": manifest.fetch("smollm2-135m"),
        "clip_model_path": write_mmproj(folder / "mmproj.gguf"),
        "chat_format": "llava-1-5",
        "host": "127.0.0.1",
        "port": port,
        "n_ctx": 2048,
        "n_threads": 1,
        "n_threads_batch": 1,
        "logits_all": False,
    }
    command = [sys.executable, "-m", "llama_cpp.server"]
    command += [word for name, value in arguments.items() for word in (f"--{name}", str(value))]
    environment = {**os.environ, "API_KEY": KEY, "OMP_WAIT_POLICY": "passive"}
    with (folder / "log").open("wb") as log:
        child = subprocess.Popen(command, stdout=log, stderr=log, env=environment)
    try:
        wait_for(f"http://127.0.0.1:{port}/v1/models", child, folder / "log")
        yield f"http://127.0.0.1:{port}/v1"
    finally:
        child.terminate()
        child.wait(30)


def wait_for(url: str, child: subprocess.Popen[bytes], log: Path) -> None:
    until_s = time.monotonic() + READY_S
    while time.monotonic() < until_s:
        assert child.poll() is None, log.read_text()
        try:
            httpx.get(url, timeout=1.0)
            return
        except httpx.HTTPError:
            time.sleep(0.2)
    raise AssertionError(log.read_text())


@pytest.fixture
def config(url: str, tmp_path: Path) -> CloudConfig:
    (tmp_path / "key").write_text(KEY)
    (tmp_path / "key").chmod(0o600)
    return CloudConfig(
        enabled=True,
        base_url=url,
        model="smollm2",
        key_file=str(tmp_path / "key"),
        price_in_usd=1.0,
        price_out_usd=1.0,
        spending_file=str(tmp_path / "spending.sqlite"),
        privacy="full",
        reply_tokens=150,
        timeout_s=600.0,
    )


@pytest.mark.parametrize("name", ["o2f", "r2f", "sle"])
def test_the_reply_keeps_to_the_schema(name: str, config: CloudConfig) -> None:
    clock = SystemClock()
    with Cloud(config, clock) as cloud:
        cloud.begin("toilet")
        outcome = cloud.expert(name)(BRIEF, Deadline.never(clock))
        (bill,) = cloud.bills()
    if isinstance(outcome, Vote):
        assert set(outcome.frontiers) <= {4, 9}
    else:  # a weak model may abstain, or run on until it is cut off
        assert outcome.cause.startswith(("abstains", "nonsense: no answer"))
    assert bill.images == (2 if name == "sle" else 0)
    assert bill.tokens_in is not None
    assert bill.tokens_out is not None
    assert bill.tokens_in > 100
    assert 0 < bill.tokens_out <= 150
    assert bill.usd == pytest.approx((bill.tokens_in + bill.tokens_out) / 1e6)
    assert cloud._endpoint._shape.form == 1  # found out: a json_object with a schema


def test_another_key_is_refused(config: CloudConfig) -> None:
    clock = SystemClock()
    with Cloud(replace(config, key_file=""), clock) as cloud:
        assert cloud.expert("o2f")(BRIEF, Deadline.never(clock)) == Missing(
            "o2f", Absence.CALL_FAILED, "the key is refused (401)"
        )


def test_a_server_that_is_too_slow_is_not_waited_for(config: CloudConfig) -> None:
    clock = SystemClock()
    with Cloud(config, clock) as cloud:
        outcome = cloud.expert("o2f")(BRIEF, Deadline.after(0.4, clock))
        assert outcome == Missing("o2f", Absence.CALL_FAILED, "late")
