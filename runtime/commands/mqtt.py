"""`rfnav mqtt`: a bridge to a broker of MQTT, for home automation. It asks the running service for
goals as anybody does; velocities it knows none."""

import queue
import ssl
import stat
import threading
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from runtime.commands.home_assistant import OFFLINE, Topics, Wished, searches, wish
from runtime.commands.options import service_options
from runtime.commands.running import Running, running
from runtime.config import load
from runtime.errors import BusError, ConfigError, SensorError
from runtime.log import say
from runtime.robot.endpoints import is_loopback
from runtime.robot.session import BusConfig

if TYPE_CHECKING:  # of the extra `mqtt`
    from paho.mqtt.client import Client

PORT, TLS_PORT = 1883, 8883
EVERY_S: Final = 1.0  # between two looks at how the service stands
WAITING: Final = 16  # wishes
TAKEN_S: Final = 60.0  # a goal's words may have to be understood by a model that is slow
AGAIN_S: Final = (1, 60)  # between two attempts to reach the broker, at least and at most
KEEPALIVE_S: Final = 20
SECRET_BYTES: Final = 4096
REACHED: Final = "reached"
OTHERS: Final = stat.S_IRWXG | stat.S_IRWXO


@dataclass(frozen=True)
class Broker:
    """Where the broker is. `tls`: None without, else the file of authorities, "" for the system's.
    Neither is the password shown when this is."""

    host: str
    port: int
    user: str = ""
    password: str = field(default="", repr=False)
    tls: str | None = None

    @property
    def where(self) -> str:
        return f"{self.host}:{self.port}"


@click.command(
    "mqtt",
    epilog="Examples:  rfnav mqtt   |   "
    "rfnav mqtt --broker ha.example.org --tls --user robot --password-file mqtt.secret",
)
@click.option("--broker", default="127.0.0.1", show_default=True, metavar="HOST[:PORT]")
@click.option("--user", default="", help="Whom the broker knows.")
@click.option("--password-file", type=click.Path(path_type=Path, dir_okay=False),
              help="Its first line is the password; nobody else may read it.")  # fmt: skip
@click.option("--tls", is_flag=True, help="Encrypted, by the system's authorities or --ca.")
@click.option("--ca", type=click.Path(path_type=Path, dir_okay=False, exists=True),
              help="File of the authorities, PEM.")  # fmt: skip
@click.option("--plain", is_flag=True,
              help="Not encrypted although the broker is on another computer.")  # fmt: skip
@click.option("--id", "name", default="rfnav", show_default=True, help="The robot's name there.")
@click.option("--home", default="dock", show_default=True, help="The place that it returns to.")
@click.option("--discovery", default="homeassistant", show_default=True, help="Prefix of topics.")
@service_options
def mqtt_command(
    broker: str, user: str, password_file: Path | None, tls: bool, ca: Path | None, plain: bool,
    name: str, home: str, discovery: str, path: Path | None, settings: tuple[str, ...],
) -> None:  # fmt: skip
    """Bridge the running service to a broker of MQTT, where Home Assistant finds it as a vacuum
    cleaner: start, pause, stop, return, a goal, how it stands, what it found last. Until Ctrl-C.

    The service and the broker may come and go. Exit status 2 for what cannot be used.
    """
    at = read_broker(broker, user, password_file, tls or ca is not None, ca, plain)
    bridge = Bridge(Topics(name, discovery), at, home)
    try:
        bridge.run(load(path, settings).bus)
    except KeyboardInterrupt:
        click.echo("ending", err=True)
    finally:
        bridge.close()


def read_broker(
    told: str, user: str, password_file: Path | None, tls: bool, ca: Path | None, plain: bool
) -> Broker:
    """ConfigError for what is no address, or would send a secret or take goals in clear from
    beyond this computer."""
    host, _, port = told.rpartition(":") if told.count(":") == 1 else (told, "", "")
    if "@" in told or not host:
        raise ConfigError("--broker: HOST or HOST:PORT; the user is --user, the password a file")
    number = int(port) if port.isdecimal() else TLS_PORT if tls else PORT
    if (port and not port.isdecimal()) or not 0 < number < 1 << 16:
        raise ConfigError(f"--broker {told}: {port} is no port")
    if not tls and not plain and not is_loopback(host):
        raise ConfigError(
            f"--broker {told}: is not this computer, and who is on the way could read and give "
            "goals: add --tls (or --ca FILE), or --plain to have it so"
        )
    password = read_secret(password_file) if password_file is not None else ""
    if password and not user:
        raise ConfigError("--password-file: whose? add --user")
    return Broker(host, number, user, password, str(ca or "") if tls else None)


def read_secret(path: Path) -> str:
    """The first line of a file that nobody else may read; ConfigError otherwise."""
    try:
        if path.stat().st_mode & OTHERS:
            raise ConfigError(f"{path}: others may read it: chmod 600 {path}")
        with path.open(encoding="utf-8") as file:
            secret = file.read(SECRET_BYTES).partition("\n")[0]
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read: {type(error).__name__}") from None
    if not secret:
        raise ConfigError(f"{path}: its first line, the password, is empty")
    return secret


class Bridge:
    """Between a broker and the service. The broker's callbacks only put into a queue what is
    wished, but for a stop; `run` does it."""

    def __init__(self, topics: Topics, broker: Broker, home: str) -> None:
        self._topics, self._broker, self._home = topics, broker, home
        self._wishes: queue.Queue[Wished] = queue.Queue(WAITING)
        self._told: dict[str, str] = {}  # what was published last, by topic
        self._fresh = threading.Event()  # somebody has to be told all of it anew
        self._ending = threading.Event()
        self._away = "nobody has answered yet"  # why the service does nothing, "" where it answers
        self._goal = self._said = self._returning = self._noted = ""
        self._ids: set[object] = set()  # ids of what was asked for as that goal
        self._runtime: Running | None = None
        self._stop_asked = threading.Event()
        self._client = self._begun()
        threading.Thread(target=self._stop, name="stop", daemon=True).start()

    def run(self, bus: BusConfig) -> None:
        """Until it is closed, or KeyboardInterrupt comes."""
        while not self._ending.is_set():
            try:
                with running(bus) as self._runtime:
                    self._serve(self._runtime)
            except (BusError, SensorError) as error:
                if str(error) != self._away:
                    self._away = str(error)
                    say(f"mqtt: {self._away}")
                self._drain()
                self._tell({self._topics.of("availability"): OFFLINE})
                self._ending.wait(EVERY_S)

    def close(self) -> None:
        """Tell that it is gone, and hang up. Idempotent."""
        self._ending.set()
        self._stop_asked.set()
        if self._client.is_connected():
            with suppress(ValueError, RuntimeError):
                self._publish(self._topics.of("availability"), OFFLINE).wait_for_publish(2.0)
        client = self._client
        client.disconnect()
        client.loop_stop()
        # A ring of references would leave its sockets to the collector, which warns of them.
        client.on_connect = client.on_message = None
        client.on_disconnect = client.on_connect_fail = None

    # -- the service's side --------------------------------------------------------------------

    def _serve(self, runtime: Running) -> None:
        """While the service answers; BusError when it does no more."""
        while not self._ending.is_set():
            status = runtime.ask("status", {})
            if self._away:
                self._away = ""
                say(f"mqtt: {runtime.where}: answers")
            states = (status, self._returning, self._goal, self._said)
            self._tell(self._topics.states(*states))
            try:
                self._do(self._wishes.get(timeout=EVERY_S), runtime)
            except queue.Empty:
                continue
            except SensorError as error:
                self._said = str(error)

    def _do(self, asked: Wished, runtime: Running) -> None:
        match asked.what:
            case "kept":
                if asked.goal != self._goal:
                    self._ids = set()
                self._goal, self._said = asked.goal, ""
            case "found":
                self._goal = asked.goal
                self._find(runtime)
            case "start":
                self._start(runtime)
            case "pause":
                self._ask(runtime, "pause", {})
            case "return":
                answer = self._ask(runtime, "goal", {"go_to": self._home})
                self._returning = str(answer.get("id") or "")

    def _stop(self) -> None:
        """A thread's work: a goal that is being understood holds up no stop. What was wished before
        goes with it; one that is asked for while another is under way follows it."""
        while self._stop_asked.wait() and not self._ending.is_set():
            self._stop_asked.clear()
            runtime = self._runtime
            if runtime is None:
                continue
            self._drain()
            try:
                self._ask(runtime, "cancel", {"reason": "mqtt"})
            except (BusError, SensorError) as error:
                self._said = str(error)

    def _start(self, runtime: Running) -> None:
        """Go on with what is under way after a pause, or where it is what is looked for next; else
        begin with that."""
        status = runtime.ask("status", {})
        goal, same = status.get("goal"), status.get("id") in self._ids
        if status.get("paused"):
            self._ask(runtime, "resume", {})
        elif searches(status, self._returning) and (same or self._goal in ("", goal)):
            self._said = f"goes on: {goal} is looked for already"
        else:
            self._find(runtime)

    def _find(self, runtime: Running) -> None:
        if not self._goal:
            self._said = "no goal is set"
            return
        answer = self._ask(runtime, "goal", {"goal": self._goal})
        if answer.get("accepted"):
            self._ids = {one.get("id") for one in (answer, *(answer.get("then") or ()))}

    def _ask(self, runtime: Running, kind: str, body: dict[str, object]) -> dict[str, Any]:
        answer = runtime.ask(kind, body, TAKEN_S)
        self._said = str(answer.get("error") or answer.get("how") or kind)
        return answer

    def _drain(self) -> None:
        """What was asked for while nobody was there is not done later."""
        with suppress(queue.Empty):
            while True:
                self._wishes.get_nowait()
                self._said = self._away

    # -- the broker's side ---------------------------------------------------------------------

    def _begun(self) -> "Client":
        try:
            from paho.mqtt.client import Client
            from paho.mqtt.enums import CallbackAPIVersion
        except ImportError as error:
            raise ConfigError("rfnav mqtt: needs `pip install 'rf-nav[mqtt]'`") from error
        broker = self._broker
        client = Client(CallbackAPIVersion.VERSION2, f"rfnav-{self._topics.id}")
        client.will_set(self._topics.of("availability"), OFFLINE, qos=1, retain=True)
        client.reconnect_delay_set(*AGAIN_S)
        if broker.user:
            client.username_pw_set(broker.user, broker.password)
        if broker.tls is not None:
            try:
                client.tls_set(broker.tls or None, tls_version=ssl.PROTOCOL_TLS_CLIENT)
            except (OSError, ssl.SSLError) as error:
                raise ConfigError(f"--ca {broker.tls}: cannot be used") from error
        client.on_connect, client.on_message = self._connected, self._heard
        client.on_disconnect = self._hung_up
        client.on_connect_fail = lambda *_: self._note("nobody listens; it is tried again")
        client.connect_async(broker.host, broker.port, KEEPALIVE_S)
        client.loop_start()
        return client

    def _connected(self, client: "Client", data: object, flags: object, code: Any, *_: Any) -> None:
        if code.is_failure:
            self._note(f"refuses: {code}")
            return
        self._note(REACHED)
        for topic in self._topics.heard:
            client.subscribe(topic, qos=1)
        self._fresh.set()

    def _hung_up(self, client: "Client", data: object, flags: object, code: Any, *_: Any) -> None:
        if code.is_failure and self._noted == REACHED:
            self._note(f"is gone: {code}")

    def _note(self, what: str) -> None:
        """Said when it is another than before."""
        if what != self._noted:
            self._noted = what
            say(f"mqtt: {self._broker.where}: {what}")

    def _heard(self, client: "Client", data: object, message: Any) -> None:
        """A message that the broker has kept is of a time before: it is no wish of now."""
        if message.retain and not message.topic.endswith("/status"):
            return
        try:
            asked = wish(self._topics, message.topic, message.payload)
        except SensorError as error:
            self._said = str(error)
            return
        if asked.what == "again":
            self._fresh.set()
            return
        if self._away:
            self._said = self._away
            return
        if asked.what == "stop":
            self._stop_asked.set()
            return
        try:
            self._wishes.put_nowait(asked)
        except queue.Full:
            self._said = f"busy: {WAITING} wishes wait already"

    def _tell(self, states: dict[str, str]) -> None:
        """What has changed; all of it to a broker, or a Home Assistant, that begins anew."""
        if not self._client.is_connected():
            return
        if self._fresh.is_set():
            self._fresh.clear()
            self._told = {}
            for topic, payload in self._topics.discoveries().items():
                self._publish(topic, payload)
        for topic, payload in states.items():
            if self._told.get(topic) != payload:
                self._publish(topic, payload)
                self._told[topic] = payload

    def _publish(self, topic: str, payload: str) -> Any:
        return self._client.publish(topic, payload, qos=1, retain=True)
