"""The bridge to a real broker of MQTT."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from authority import certified
from mosquitto import Assistant, Mosquitto, needs_mosquitto, waited
from places import ROOT
from service_double import ServiceDouble

from runtime.commands import mqtt
from runtime.commands.home_assistant import Topics
from runtime.commands.mqtt import Bridge, Broker, read_broker, read_secret
from runtime.errors import ConfigError
from runtime.robot.session import BusConfig

SECRET = "correct horse"
READY = {"runtime": {"state": "ready", "cause": ""}, "goal": None, "paused": "", "last": None}
TAKEN = {"accepted": True, "id": "a1", "how": "mug: known as mug"}


def service() -> ServiceDouble:
    done = {"ended": True}
    return ServiceDouble(
        status=READY, goal=TAKEN, cancel=done, pause={"paused": True, "id": "a1"},
        resume={"paused": False, "id": "a1"},
    )  # fmt: skip


@contextmanager
def bridged(double: ServiceDouble, broker: Broker) -> Iterator[Bridge]:
    bridge = Bridge(Topics("rosie"), broker, "dock")
    running = threading.Thread(target=bridge.run, args=(BusConfig(connect=(double.end,)),))
    running.start()
    try:
        yield bridge
    finally:
        bridge.close()
        running.join(20.0)
        assert not running.is_alive()
        bridge.close()


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mqtt, "EVERY_S", 0.05)
    monkeypatch.setattr(mqtt, "AGAIN_S", (1, 1))


@needs_mosquitto
def test_home_assistant_finds_it_and_sees_how_it_stands(tmp_path: Path):
    with Mosquitto(tmp_path).up() as broker, service().up() as double:
        with bridged(double, Broker("127.0.0.1", broker.port)):
            early = Assistant(broker.port)
            early.hears("rfnav/rosie/availability", "online")
            early.close()
            assistant = Assistant(broker.port)  # it comes later, and is told all the same
            assistant.hears("homeassistant/vacuum/rfnav_rosie/robot/config", "send_command")
            assistant.hears("rfnav/rosie/state", "idle")
            kept = {"homeassistant/text/rfnav_rosie/goal/config", "rfnav/rosie/availability"}
            waited(lambda: kept <= assistant.retained)
            double.answers["status"] = {**READY, "goal": "mug", "id": "a1"}
            assistant.hears("rfnav/rosie/state", "cleaning")
        assistant.hears("rfnav/rosie/availability", "offline")
        assistant.close()


@needs_mosquitto
def test_what_is_wished_is_asked_of_the_service(tmp_path: Path):
    def asked() -> list:
        return [one for one in double.heard if one[0] != "status"]

    with Mosquitto(tmp_path).up() as broker, service().up() as double:
        assistant = Assistant(broker.port)
        with bridged(double, Broker("127.0.0.1", broker.port)):
            assistant.hears("rfnav/rosie/availability", "online")
            assistant.say("rfnav/rosie/command", "start")
            assistant.hears("rfnav/rosie/attributes", "no goal is set")
            assistant.say("rfnav/rosie/goal/set", "a mug")
            assistant.hears("rfnav/rosie/goal", "a mug")
            assert asked() == []  # a goal that is written begins nothing
            for n, (topic, payload, body) in enumerate(
                (
                    ("command", "start", ("goal", {"goal": "a mug"})),
                    ("send", '{"command": "find", "goal": "bed"}', ("goal", {"goal": "bed"})),
                    ("command", "pause", ("pause", {})),
                    ("command", "return_to_base", ("goal", {"go_to": "dock"})),
                    ("command", "stop", ("cancel", {"reason": "mqtt"})),
                ),
                1,
            ):
                assistant.say(f"rfnav/rosie/{topic}", payload)
                waited(lambda n=n: len(asked()) == n, asked())
                assert asked()[-1] == body
            double.answers["status"] = {**READY, "goal": "go to dock", "id": "a1"}
            assistant.hears("rfnav/rosie/state", "returning")
            double.answers["status"] = {**READY, "goal": "mug", "paused": "rfnav/pause"}
            assistant.hears("rfnav/rosie/state", "paused")
            assistant.say("rfnav/rosie/command", "start")
            waited(lambda: asked()[-1] == ("resume", {}))
            assistant.say("rfnav/rosie/command", b"\xff")
            assistant.hears("rfnav/rosie/attributes", "is no text")
        assistant.close()


@needs_mosquitto
def test_a_start_in_the_midst_of_a_search_has_it_go_on(tmp_path: Path):
    def asked() -> list:
        return [one for one in double.heard if one[0] != "status"]

    def found(assistant: Assistant, goal: str) -> None:
        double.heard.clear()
        assistant.say("rfnav/rosie/command", "start")
        waited(lambda: asked() == [("goal", {"goal": goal})], asked())

    with Mosquitto(tmp_path).up() as broker, service().up() as double:
        assistant = Assistant(broker.port)
        double.answers["goal"] = {**TAKEN, "then": [{"id": "b2"}]}
        with bridged(double, Broker("127.0.0.1", broker.port)):
            assistant.hears("rfnav/rosie/availability", "online")
            double.answers["status"] = {**READY, "goal": "cup", "id": "c3"}  # others asked for it
            assistant.say("rfnav/rosie/command", "start")
            assistant.hears("rfnav/rosie/attributes", "goes on: cup")
            assert asked() == []
            assistant.say("rfnav/rosie/goal/set", "mug, then bed")
            assistant.hears("rfnav/rosie/goal", "mug, then bed")
            found(assistant, "mug, then bed")  # another than is under way
            for id, goal in (("a1", "mug"), ("b2", "bed"), ("c3", "mug, then bed")):
                double.answers["status"] = {**READY, "goal": goal, "id": id}
                double.heard.clear()
                assistant.say("rfnav/rosie/command", "start")
                assistant.hears("rfnav/rosie/attributes", f"goes on: {goal}")
                assert asked() == []
            double.answers["status"] = {**READY, "goal": "mug", "id": "a1", "mode": "return"}
            found(assistant, "mug, then bed")  # that search is over
            assistant.say("rfnav/rosie/goal/set", "sofa")
            assistant.hears("rfnav/rosie/goal", "sofa")
            double.answers["status"] = {**READY, "goal": "mug", "id": "a1"}
            found(assistant, "sofa")
        assistant.close()


@needs_mosquitto
def test_a_wish_that_the_broker_has_kept_is_none(tmp_path: Path):
    with Mosquitto(tmp_path).up() as broker, service().up() as double:
        assistant = Assistant(broker.port)
        assistant.say("rfnav/rosie/send", "find mug", retain=True)
        with bridged(double, Broker("127.0.0.1", broker.port)):
            assistant.hears("rfnav/rosie/availability", "online")
            assistant.say("rfnav/rosie/command", "pause")
            waited(lambda: ("pause", {}) in double.heard)
            assert "goal" not in {kind for kind, _ in double.heard}
        assistant.close()


@needs_mosquitto
def test_a_stop_does_not_wait_for_a_goal_that_is_being_understood(tmp_path: Path):
    with Mosquitto(tmp_path).up() as broker, service().up() as double:
        assistant = Assistant(broker.port)
        double.answers["goal"] = None
        with bridged(double, Broker("127.0.0.1", broker.port)) as bridge:
            assistant.hears("rfnav/rosie/availability", "online")
            assistant.say("rfnav/rosie/send", "find mug")
            waited(lambda: ("goal", {"goal": "mug"}) in double.heard)
            assistant.say("rfnav/rosie/command", "pause")
            assistant.say("rfnav/rosie/command", "stop")
            waited(lambda: ("cancel", {"reason": "mqtt"}) in double.heard)
            assert ("pause", {}) not in double.heard  # it went with the stop
            waited(lambda: bridge._said == "cancel")
            double._unanswered.clear()
        assistant.close()


@needs_mosquitto
def test_a_stop_that_comes_while_another_waits_for_its_answer_is_not_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(mqtt, "TAKEN_S", 2.0)
    with Mosquitto(tmp_path).up() as broker, service().up() as double:
        assistant = Assistant(broker.port)
        double.answers["cancel"] = None
        with bridged(double, Broker("127.0.0.1", broker.port)):
            assistant.hears("rfnav/rosie/availability", "online")
            stop = "cancel", {"reason": "mqtt"}
            assistant.say("rfnav/rosie/command", "stop")
            waited(lambda: double.heard.count(stop) == 1)
            assistant.say("rfnav/rosie/command", "stop")
            waited(lambda: double.heard.count(stop) == 2)
        assistant.close()


@needs_mosquitto
def test_the_service_may_come_and_go(tmp_path: Path):
    double = service()
    with Mosquitto(tmp_path).up() as broker:
        assistant = Assistant(broker.port)
        with bridged(double, Broker("127.0.0.1", broker.port)) as bridge:
            assistant.hears("rfnav/rosie/availability", "offline")
            assistant.say("rfnav/rosie/send", "find mug")  # nobody is there: it is not done later
            waited(lambda: "nobody listens" in bridge._said)
            for _ in range(2):
                with double.up():
                    assistant.hears("rfnav/rosie/availability", "online")
                    assistant.hears("rfnav/rosie/attributes", "nobody listens")
                assistant.hears("rfnav/rosie/availability", "offline")
        assert {kind for kind, _ in double.heard} == {"status"}
        assistant.close()


@needs_mosquitto
def test_a_broker_that_begins_anew_is_told_all_of_it(tmp_path: Path):
    broker = Mosquitto(tmp_path)
    with service().up() as double, bridged(double, Broker("127.0.0.1", broker.port)):
        for _ in range(2):
            with broker.up():
                assistant = Assistant(broker.port)
                assistant.hears("homeassistant/vacuum/rfnav_rosie/robot/config", "rfnav")
                assistant.hears("rfnav/rosie/state", "idle")
                assistant.kept.clear()
                assistant.say("homeassistant/status", "online")  # Home Assistant itself
                assistant.hears("homeassistant/vacuum/rfnav_rosie/robot/config", "rfnav")
                assistant.close()


@needs_mosquitto
def test_only_who_is_known_is_let_in_and_the_secret_is_not_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    said: list[str] = []
    monkeypatch.setattr(mqtt, "say", said.append)
    made = certified(tmp_path / "ca", "broker", "127.0.0.1")
    secrets = tmp_path / "passwords"
    secrets.touch(0o600)
    subprocess.run(["mosquitto_passwd", "-b", secrets, "robot", SECRET], check=True)
    lines = f"password_file {secrets}", f"cafile {made.ca}", f"certfile {made.certificate}"
    key = f"keyfile {made.private_key}"
    broker = Mosquitto(tmp_path, "allow_anonymous false", *lines, key)
    right = Broker("127.0.0.1", broker.port, "robot", SECRET, str(made.ca))
    with broker.up(), service().up() as double:
        with bridged(double, right):
            assistant = Assistant(broker.port, "robot", SECRET, str(made.ca))
            assistant.hears("rfnav/rosie/state", "idle")
            assistant.close()
        with bridged(double, Broker("127.0.0.1", broker.port, "robot", "wrong", str(made.ca))):
            waited(lambda: any("refuses: Not authorized" in line for line in said))
        assert SECRET not in "".join(said) + repr(right)


@needs_mosquitto
def test_one_that_dies_is_told_to_be_gone(tmp_path: Path):
    with Mosquitto(tmp_path).up() as broker, service().up() as double:
        where = ("--broker", f"127.0.0.1:{broker.port}", "--id", "rosie")
        bus = f'bus.connect=["{double.end}"]'
        with subprocess.Popen(
            [sys.executable, "-m", "runtime", "mqtt", *where, "--set", bus], cwd=ROOT
        ) as child:
            try:
                assistant = Assistant(broker.port)
                assistant.hears("rfnav/rosie/availability", "online")
            finally:
                child.kill()
        assistant.hears("rfnav/rosie/availability", "offline")
        assistant.close()


@pytest.mark.parametrize(
    ("told", "options", "said"),
    [
        ("ha.example.org", {}, "add --tls"),
        ("10.0.0.2:1883", {"user": "robot"}, "add --tls"),
        ("robot:secret@127.0.0.1", {}, "the user is --user"),
        ("127.0.0.1:no", {}, "no is no port"),
        ("127.0.0.1:70000", {}, "70000 is no port"),
        (":1883", {}, "HOST or HOST:PORT"),
    ],
)
def test_what_is_no_broker_to_trust_is_refused(told: str, options: dict, said: str):
    usual = {"user": "", "password_file": None, "tls": False, "ca": None, "plain": False}
    with pytest.raises(ConfigError, match=said) as error:
        read_broker(told, **usual | options)
    assert "secret" not in str(error.value)


def test_where_the_broker_is_is_read():
    usual = {"user": "", "password_file": None, "tls": False, "ca": None, "plain": False}
    assert read_broker("127.0.0.1", **usual) == Broker("127.0.0.1", 1883)
    assert read_broker("ha.lan", **usual | {"tls": True}) == Broker("ha.lan", 8883, tls="")
    assert read_broker("ha.lan:1884", **usual | {"plain": True}) == Broker("ha.lan", 1884)


def test_a_secret_is_for_its_owner_alone(tmp_path: Path):
    path = tmp_path / "secret"
    path.write_text(f"{SECRET}\nmore")
    path.chmod(0o640)
    with pytest.raises(ConfigError, match="chmod 600"):
        read_secret(path)
    path.chmod(0o600)
    assert read_secret(path) == SECRET
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match="cannot be read: UnicodeDecodeError"):
        read_secret(path)
    path.write_text("\n")
    with pytest.raises(ConfigError, match="is empty"):
        read_secret(path)
    with pytest.raises(ConfigError, match="cannot be read: FileNotFoundError"):
        read_secret(tmp_path / "none")


def test_without_the_library_that_is_said(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "paho.mqtt.client", None)
    with pytest.raises(ConfigError, match=r"pip install 'rf-nav\[mqtt\]'"):
        Bridge(Topics("rosie"), Broker("127.0.0.1", 1), "dock")
