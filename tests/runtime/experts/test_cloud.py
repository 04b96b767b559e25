"""A cloud that works, hangs, trickles, refuses or talks nonsense; the key, the money and the
pictures stay where they belong."""

import json
import logging
import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from cloud_double import Server, answer, completion, ids_of, vote
from hypothesis import given
from hypothesis import strategies as st
from manual_clock import ManualClock

from runtime.clock import Deadline, SystemClock
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, NearbyObject, Vote
from runtime.errors import ConfigError
from runtime.experts.cloud import Cloud
from runtime.experts.cloud_config import CloudConfig, check, read_key
from runtime.experts.endpoint import WINDOW, scrubbed

KEY = "sk-test-0123456789abcdefghijklmnop"
JPEG = b"\xff\xd8 a picture \xff\xd9"
SINK = NearbyObject("sink", 0.9, 0.5)
BRIEF = Brief(
    "toilet",
    0,
    (
        FrontierBrief(4, 1.0, (SINK,), (("bathroom", 1.0),), image=JPEG),
        FrontierBrief(9, 2.0, (), (("hall", 1.0),), image=JPEG),
    ),
)
REPLIES: list[tuple[Any, str]] = [
    (lambda body: (500, "oops"), "server error (500)"),
    (lambda body: (429, {"error": {"message": "slow down"}}), "rate limited (429)"),
    (lambda body: (401, {"error": {"message": "wrong key"}}), "the key is refused (401)"),
    (lambda body: (404, "no"), "not found (404): check cloud.base_url and cloud.model"),
    (lambda body: (302, ""), "redirects (302): give the address it leads to"),
    (lambda body: (418, {"error": {"message": "a\nteapot"}}), "refused (418): a teapot"),
    (lambda body: (200, "<html>"), "nonsense: not a chat completion"),
    (lambda body: (200, "[" * 50_000), "nonsense: not a chat completion"),
    (lambda body: (200, {"choices": []}), "nonsense: not a chat completion"),
    (lambda body: (200, completion(None)), "nonsense: no answer in the reply"),
    (lambda body: (200, completion("left, I think")), "nonsense: no answer in the reply"),
    (lambda body: (200, completion(answer([77]))), "nonsense: voted for unknown frontier 77"),
    (lambda body: (200, completion(answer([]))), "nonsense: voted for no frontier"),
    (lambda body: (200, completion(answer("abstain", "alike"))), "abstains: alike"),
    ("flood", "the reply is longer than 1048576 bytes"),
    ("break", "the connection broke (RemoteProtocolError)"),
]


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    path = tmp_path / "key"
    path.write_text(KEY + "\n")
    path.chmod(0o600)
    return path


@pytest.fixture
def config(tmp_path: Path, key_file: Path) -> CloudConfig:
    return CloudConfig(
        enabled=True,
        base_url="",
        model="big",
        key_file=str(key_file),
        price_in_usd=1.0,
        price_out_usd=10.0,
        cap_goal_usd=1.0,
        cap_day_usd=1.0,
        spending_file=str(tmp_path / "spending.sqlite"),
    )


@pytest.fixture
def server() -> Iterator[Server]:
    with Server() as server:
        yield server


def asking(server: Server, config: CloudConfig) -> Cloud:
    cloud = Cloud(replace(config, base_url=server.url), SystemClock())
    cloud.begin("toilet")
    return cloud


def soon(seconds: float = 20.0) -> Deadline:
    return Deadline.after(seconds, SystemClock())


def test_a_vote_with_its_price(server: Server, config: CloudConfig) -> None:
    with asking(server, config) as cloud:
        got = cloud.expert("o2f")(BRIEF, soon())
        assert got == Vote("o2f", (4,), ((4, 1.0), (9, 0.0)), "it looks right", "cloud")
        (bill,) = cloud.bills()
        assert (bill.expert, bill.outcome, bill.model) == ("o2f", "vote", "big")
        assert (bill.tokens_in, bill.tokens_out, bill.usd) == (100, 10, 0.0002)
        assert cloud.bills() == ()
        assert cloud.status() == {
            "model": "big", "calls": 1, "goal_usd": 0.0002, "day_usd": 0.0002, "run_usd": 0.0002,
            "error": "",
        }  # fmt: skip
    (request,) = server.requests
    assert request["model"] == "big"
    assert (request["max_tokens"], request["temperature"]) == (300, 0)
    assert request["response_format"]["json_schema"]["strict"] is True
    assert ids_of(request) == [4, 9]
    assert server.auth == [f"Bearer {KEY}"]


@pytest.mark.parametrize(("behave", "cause"), REPLIES)
def test_what_goes_wrong_is_an_abstention_with_a_cause(
    behave: Any, cause: str, server: Server, config: CloudConfig
) -> None:
    server.behave = behave
    with asking(server, config) as cloud:
        outcome = cloud.expert("o2f")(BRIEF, soon())
        assert isinstance(outcome, Missing)
        assert (outcome.expert, outcome.cause) == ("o2f", cause)
        (bill,) = cloud.bills()
        assert bill.outcome == cause


@pytest.mark.parametrize("behave", ["hang", "drip"])
def test_a_call_ends_at_its_deadline(behave: str, server: Server, config: CloudConfig) -> None:
    """Although a slow stream says something all the time, and no single read takes long."""
    server.behave = behave
    with asking(server, config) as cloud:
        assert cloud.expert("o2f")(BRIEF, soon(0.8)) == Missing("o2f", Absence.CALL_FAILED, "late")
        again = cloud.expert("o2f")(BRIEF, soon())
        assert again == Missing("o2f", Absence.AT_REST, "late")
    assert len(server.requests) == 1


def test_a_cloud_that_is_not_there_is_left_alone_for_longer_and_longer(config: CloudConfig) -> None:
    clock = ManualClock()
    with Cloud(replace(config, base_url="http://127.0.0.1:9/v1"), clock) as cloud:
        ask = lambda: cloud.expert("o2f")(BRIEF, Deadline.never(clock))  # noqa: E731
        down = "cannot be reached"
        for rest_s in (1.0, 2.0, 4.0):
            assert ask() == Missing("o2f", Absence.CALL_FAILED, down)
            clock.advance(rest_s - 0.1)
            assert ask() == Missing("o2f", Absence.AT_REST, down)
            clock.advance(0.1)
        assert cloud.status()["goal_usd"] == 0.0  # what never arrived costs nothing


def test_retry_after_is_respected(server: Server, config: CloudConfig) -> None:
    server.behave, server.headers = lambda body: (429, ""), {"Retry-After": "30"}
    clock = ManualClock()
    with Cloud(replace(config, base_url=server.url), clock) as cloud:
        assert cloud.expert("o2f")(BRIEF, Deadline.never(clock)).cause == "rate limited (429)"  # type: ignore[union-attr]
        clock.advance(29.0)
        assert not cloud.ready(Deadline.never(clock))
        clock.advance(1.0)
        server.behave = vote
        assert isinstance(cloud.expert("o2f")(BRIEF, Deadline.never(clock)), Vote)


def test_without_time_nothing_is_asked(server: Server, config: CloudConfig) -> None:
    with asking(server, config) as cloud:
        assert cloud.expert("o2f")(BRIEF, soon(0.1)) == Missing("o2f", Absence.NO_TIME)
    assert server.requests == []


def picky(*rules: Callable[[dict[str, Any]], str]) -> Callable[[dict[str, Any]], tuple[int, Any]]:
    """A server that refuses what a rule has a complaint about, else votes."""

    def behave(body: dict[str, Any]) -> tuple[int, Any]:
        for rule in rules:
            if complaint := rule(body):
                return 422, {"detail": [{"msg": complaint}]}
        return 200, completion(answer([4]))

    return behave


def test_the_form_of_a_request_is_found_out_and_kept(server: Server, config: CloudConfig) -> None:
    form = lambda body: body.get("response_format", {}).get("type", "")  # noqa: E731
    server.behave = picky(
        lambda body: "use max_completion_tokens" if "max_tokens" in body else "",
        lambda body: "temperature: only the default" if "temperature" in body else "",
        lambda body: "unknown type" if form(body) == "json_schema" else "",
    )
    with asking(server, config) as cloud:
        assert isinstance(cloud.expert("o2f")(BRIEF, soon()), Vote)
        assert len(server.requests) == 4
        assert isinstance(cloud.expert("r2f")(BRIEF, soon()), Vote)
    assert len(server.requests) == 5
    last = server.requests[-1]
    assert last["max_completion_tokens"] == 300
    assert last["response_format"]["type"] == "json_object"
    assert "temperature" not in last


def test_a_server_that_takes_no_form_is_asked_without(server: Server, config: CloudConfig) -> None:
    server.behave = picky(lambda body: "no" if "response_format" in body else "")
    with asking(server, config) as cloud:
        assert isinstance(cloud.expert("o2f")(BRIEF, soon()), Vote)
    server.behave = lambda body: (400, {"error": {"message": f"never, {KEY}"}})
    with asking(server, config) as cloud:
        assert cloud.expert("o2f")(BRIEF, soon()) == Missing(
            "o2f", Absence.CALL_FAILED, "refused (400): never, ***"
        )


# -- money -------------------------------------------------------------------------------------


def test_what_a_call_may_cost_must_fit_under_the_cap(server: Server, config: CloudConfig) -> None:
    with asking(server, replace(config, cap_goal_usd=0.004)) as cloud:
        missing = cloud.expert("o2f")(BRIEF, soon())
        assert missing == Missing("o2f", Absence.NOT_AFFORDED, str(cloud.status()["error"]))
        assert missing.cause.startswith("cap per goal: ")
        assert cloud.bills() == ()
    assert server.requests == []


def test_no_usage_in_the_reply_means_the_worst_case(server: Server, config: CloudConfig) -> None:
    server.behave = lambda body: (200, completion(answer([4])))
    with asking(server, config) as cloud:
        cloud.expert("o2f")(BRIEF, soon())
        spent = cloud.status()["goal_usd"]
    text = sum(len(m["content"]) for m in server.requests[0]["messages"])
    assert isinstance(spent, float)
    assert spent > (text + 300 * 10) / 1e6


@pytest.mark.parametrize(("status", "free"), [(429, True), (401, True), (500, False)])
def test_what_cannot_have_been_billed_is_not_booked(
    status: int, free: bool, server: Server, config: CloudConfig
) -> None:
    server.behave = lambda body: (status, "")
    with asking(server, config) as cloud:
        cloud.expert("o2f")(BRIEF, soon())
        assert (cloud.status()["goal_usd"] == 0.0) == free


def test_the_cap_holds_over_restarts(server: Server, config: CloudConfig) -> None:
    server.behave = lambda body: (200, completion(answer([4])))  # each books its worst case
    tight = replace(config, cap_goal_usd=0.02)
    for _ in range(10):
        with asking(server, tight) as cloud:
            cloud.expert("o2f")(BRIEF, soon())
    assert 1 < len(server.requests) < 6
    cloud = asking(server, tight)
    assert isinstance(cloud.expert("o2f")(BRIEF, soon()), Missing)
    cloud.finish()
    cloud.begin("toilet")
    assert isinstance(cloud.expert("o2f")(BRIEF, soon()), Vote)
    cloud.close()


def test_a_ledger_that_cannot_be_used_spends_nothing(
    server: Server, config: CloudConfig, tmp_path: Path
) -> None:
    (tmp_path / "bad.sqlite").write_bytes(b"no database " * 400)
    bad = replace(config, spending_file=str(tmp_path / "bad.sqlite"))
    with asking(server, bad) as cloud:
        missing = cloud.expert("o2f")(BRIEF, soon())
        assert isinstance(missing, Missing)
        assert "nothing is spent" in missing.cause
    assert server.requests == []


# -- pictures ----------------------------------------------------------------------------------


def test_with_privacy_text_no_image_leaves(server: Server, config: CloudConfig) -> None:
    with asking(server, config) as cloud:
        missing = cloud.expert("sle")(BRIEF, soon())
        assert missing == Missing("sle", Absence.PRIVACY, "no image may be sent")
        for name in ("o2f", "r2f", "both"):
            assert isinstance(cloud.expert(name)(BRIEF, soon()), Vote)
    assert len(server.requests) == 3
    assert "image" not in json.dumps(server.requests)


def test_with_privacy_full_sle_sends_its_pictures(server: Server, config: CloudConfig) -> None:
    with asking(server, replace(config, privacy="full")) as cloud:
        assert isinstance(cloud.expert("sle")(BRIEF, soon()), Vote)
        assert cloud.bills()[0].images == 2
    assert json.dumps(server.requests).count("data:image/jpeg;base64,") == 2
    with asking(server, replace(config, privacy="full", images=False)) as cloud:
        assert isinstance(cloud.expert("sle")(BRIEF, soon()), Missing)
    assert len(server.requests) == 1


# -- the key -----------------------------------------------------------------------------------


def test_the_key_is_in_no_log_and_no_error(
    server: Server, config: CloudConfig, caplog: pytest.LogCaptureFixture
) -> None:
    server.behave = lambda body: (
        422,
        {"error": {"message": f"bad: {server.auth[-1]} ({KEY[5:]})"}},
    )
    with caplog.at_level(logging.DEBUG), asking(server, config) as cloud:
        missing = cloud.expert("o2f")(BRIEF, soon())
        told = [repr(missing), repr(cloud.status()), repr(cloud.bills()), repr(vars(cloud))]
    assert isinstance(missing, Missing)
    assert missing.cause == "refused (422): bad: Bearer *** (***)"
    for text in (*told, caplog.text):
        assert KEY[:10] not in text
        assert KEY[-10:] not in text


@given(
    st.text(alphabet="abcdef", min_size=1, max_size=40), st.text(alphabet="abcdef ", max_size=60)
)
def test_no_part_of_a_key_survives_scrubbing(key: str, text: str) -> None:
    shown = scrubbed(text + key, key, limit=10_000)
    width = min(WINDOW, len(key))
    assert not any(key[i : i + width] in shown for i in range(len(key) - width + 1))


def test_keys_come_from_files_only_their_owner_reads(config: CloudConfig, key_file: Path) -> None:
    assert read_key(config) == KEY
    key_file.chmod(0o644)
    with pytest.raises(ConfigError, match=r"^cloud\.key_file: others can read the file; run chmod"):
        read_key(config)
    key_file.chmod(0o600)
    for text in ("", "two words", "two\nlines", "é", "x" * 5000):
        key_file.write_text(text)
        with pytest.raises(
            ConfigError, match=r"^cloud\.key_file: the file must hold the key alone"
        ):
            read_key(config)
    with pytest.raises(ConfigError, match="must name a file") as error:
        read_key(replace(config, key_file=KEY))  # the key in place of a path
    assert KEY not in str(error.value)


def test_a_systemd_credential_holds_the_key(
    config: CloudConfig, key_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = replace(config, key_file="", credential="key")
    monkeypatch.delenv("CREDENTIALS_DIRECTORY", raising=False)
    with pytest.raises(ConfigError, match="CREDENTIALS_DIRECTORY is not set"):
        read_key(named)
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(key_file.parent))
    assert read_key(named) == KEY
    with pytest.raises(ConfigError, match="name of a credential, not a path"):
        read_key(replace(named, credential="../key"))
    assert read_key(replace(config, key_file="")) == ""


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"base_url": ""}, 'cloud.base_url: must be like "https://'),
        ({"base_url": "ftp://x/v1"}, "cloud.base_url: must be like"),
        ({"base_url": "http://[bad/v1"}, "cloud.base_url: must be like"),
        ({"base_url": f"https://me:{KEY}@x/v1"}, "cloud.base_url: must be an address only"),
        ({"base_url": f"https://x/v1?key={KEY}"}, "cloud.base_url: must be an address only"),
        ({"base_url": "http://example.com/v1"}, "cloud.base_url: a key is sent over https only"),
        ({"model": ""}, "cloud.model: must be given"),
        ({"credential": "key"}, "cloud.key_file and cloud.credential: give one of them"),
        ({"price_in_usd": -1.0}, "cloud.price_in_usd: must be given"),
    ],
)
def test_a_configuration_that_cannot_be_used(
    change: dict[str, Any], message: str, config: CloudConfig
) -> None:
    good = replace(config, base_url="https://example.com/v1")
    check(good)
    with pytest.raises(ConfigError) as error:
        check(replace(good, **change))
    assert str(error.value).startswith(message)
    assert KEY not in str(error.value)
    check(replace(good, enabled=False, **change))  # what is not allowed need not be right


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="needs Linux's /proc")
def test_nothing_grows_over_many_bad_calls(server: Server, config: CloudConfig) -> None:
    bad = [behave for behave, _ in REPLIES[:-2]] + [vote]
    clock = ManualClock()
    with Cloud(replace(config, base_url=server.url, cap_goal_usd=9, cap_day_usd=9), clock) as cloud:

        def ask(times: int) -> None:
            for n in range(times):
                server.behave = bad[n % len(bad)]
                cloud.expert("o2f")(BRIEF, Deadline.never(clock))
                clock.advance(1000.0)

        ask(20)
        threads, files = threading.active_count(), open_files()
        ask(100)
        assert threading.active_count() <= threads + 1
        assert open_files() <= files + 4
        assert os.path.exists(config.spending_file)
