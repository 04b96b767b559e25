"""What a request may ask of a search: an explicit, bounded list. All else is the robot's own, and
is set where the process is started."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from runtime.errors import ConfigError
from runtime.log import say
from runtime.loops.whereabouts import NoZones, ZoneKeeper
from runtime.private_files import state_directory
from runtime.service.bounds import BINDS, named, place_words
from runtime.service.goal_queue import WAITING
from runtime.service.limits import NO_LIMITS, GoalLimits
from runtime.toml_values import unknown

MAY_SET: Final = ("goal.keep_map", "panel.decide_budget_s", "panel.experts")
"""Keys that say what a search is; their values keep to the keys' own bounds."""
SEVERAL: Final = ("refuse", "in_turn")
IF_BUSY: Final = ("preempt", "queue", "refuse")
STAY: Final = "stay"
AFTERWARDS: Final = (STAY, "return")  # or {"place": NAME}
ASKED: Final = (
    "goal", *BINDS, "several", "if_busy", "queue_most", "limits", "afterwards", "episode",
    "settings", "log_dir",
)  # fmt: skip
TEXTS: Final = 16  # of a list of goals
SETTINGS: Final = 32
SETTING_CHARS: Final = 200
PATH_CHARS: Final = 1000
TOLD_CHARS: Final = 200  # of an episode's name, and of a reason to cancel
DIRECTORIES: Final = 1000  # of searches that began in one second


@dataclass(frozen=True)
class GoalRequest:
    """`texts`: looked for one after the other. `several`: what becomes of a text that names more
    than one thing; `if_busy`: of this goal, or of the one under way, where there is one;
    `afterwards`: of the robot. `log_dir`: where journal and map are left; None: in a directory of
    the search's own. `binds`: where the robot is bound to, as `service/bounds.py` reads it.
    `queue_most`: how many goals may wait once it is taken on."""

    texts: tuple[str, ...]
    settings: tuple[str, ...] = ()
    log_dir: Path | None = None
    episode: str | int | None = None
    several: str = SEVERAL[0]
    if_busy: str = IF_BUSY[0]
    limits: GoalLimits = NO_LIMITS
    afterwards: str | Mapping[str, str] = STAY
    binds: Mapping[str, Any] = field(default_factory=dict)
    queue_most: int = WAITING

    @property
    def goes(self) -> bool:
        """Whether there is a place to go to, and nothing to look for."""
        return "go_to" in self.binds


def searches_directory() -> Path:
    """Where searches leave what is theirs, whether it is there yet or not."""
    return state_directory() / "searches"


def new_directory() -> Path | None:
    """A directory of its own under the state directory for what a search leaves; None, and a line
    in the log, where none can be made."""
    name, searches = time.strftime("%Y%m%d-%H%M%S"), searches_directory()
    try:
        searches.mkdir(parents=True, exist_ok=True)
        for number in range(1, DIRECTORIES):
            path = searches / (name if number == 1 else f"{name}-{number}")
            try:
                path.mkdir()
                return path
            except FileExistsError:
                continue
        why = f"{DIRECTORIES} searches began in this second"
    except OSError as error:
        why = error.strerror or str(error)
    say(f"{searches}: cannot be written ({why}): journal and map of this search are lost")
    return None


@dataclass(frozen=True)
class Terms:
    """What goals may bring. Under a `harness`: settings of everything, and where files are written;
    else what `MAY_SET` names. `directory`: where files go if nobody says; `zones`: what the robot
    is kept out of, whatever it looks for."""

    harness: bool = False
    directory: Callable[[], Path | None] = new_directory
    zones: ZoneKeeper = field(default_factory=NoZones)

    def read(self, body: Mapping[str, Any]) -> GoalRequest:
        """A request of what is in `ASKED`; ConfigError, one line, says what is wrong with it."""
        for name in body:
            if name not in ASKED:
                raise ConfigError(f"goal request: {name[:TOLD_CHARS]!r}: {unknown(name, ASKED)}")
        log_dir = self._log_dir(body) if "log_dir" in body else None
        binds = {name: body[name] for name in BINDS if name in body}
        afterwards = _afterwards(body)
        if isinstance(afterwards, Mapping):
            binds["afterwards"] = afterwards
        return GoalRequest(
            _texts(body),
            self._settings(body),
            log_dir,
            _episode(body),
            _choice(body, "several", SEVERAL),
            _choice(body, "if_busy", IF_BUSY),
            GoalLimits.read(body.get("limits", {})),
            afterwards,
            binds,
            _queue_most(body),
        )

    def _settings(self, body: Mapping[str, Any]) -> tuple[str, ...]:
        value = body.get("settings", [])
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise ConfigError('goal request: settings: must be a list of "KEY=VALUE"')
        if self.harness:
            return tuple(value)
        if len(value) > SETTINGS or any(len(item) > SETTING_CHARS for item in value):
            limits = f"{SETTINGS} of {SETTING_CHARS} letters"
            raise ConfigError(f"goal request: settings: must be at most {limits}")
        for item in value:
            name = item.partition("=")[0].strip()
            if name not in MAY_SET:
                raise ConfigError(
                    f"goal request: settings: {name!r} is the robot's, not a goal's to set; a goal "
                    f"sets {', '.join(MAY_SET)}; all else is in rfnav's configuration"
                )
        return tuple(value)

    def _log_dir(self, body: Mapping[str, Any]) -> Path:
        value = body["log_dir"]
        if not self.harness:
            raise ConfigError(
                "goal request: log_dir: only under rfnav run --harness; files are written in the "
                "state directory"
            )
        if not isinstance(value, str):
            raise ConfigError("goal request: log_dir: must be text")
        if not value.isprintable() or not 0 < len(value) <= PATH_CHARS:
            raise ConfigError("goal request: log_dir: must be the path of a directory")
        return Path(value)


STRICT: Final = Terms()
"""Of a robot that no harness started."""


def cancel_reason(body: Mapping[str, Any]) -> str:
    """Why a search is cancelled, as far as it is told in words."""
    reason = body.get("reason")
    fine = isinstance(reason, str) and reason.isprintable() and 0 < len(reason) <= TOLD_CHARS
    return str(reason) if fine else "cancelled"


def _texts(body: Mapping[str, Any]) -> tuple[str, ...]:
    value = body.get("goal")
    if "go_to" in body:
        words = place_words(body["go_to"])
        if value not in (None, words):  # a goal that waits has them for its own
            raise ConfigError("goal request: go_to: a goal is either a thing or a place to go to")
        return (words,)
    texts = value if isinstance(value, list) else [value]
    if not all(isinstance(text, str) for text in texts) or not 0 < len(texts) <= TEXTS:
        raise ConfigError(f"goal request: goal: must be text, or a list of {TEXTS} at most")
    return tuple(texts)


def _afterwards(body: Mapping[str, Any]) -> str | Mapping[str, str]:
    value = body.get("afterwards", STAY)
    if isinstance(value, dict):
        if set(value) != {"place"}:
            raise ConfigError('goal request: afterwards: must be stay, return or {"place": NAME}')
        return {"place": named(value["place"], "goal request: afterwards: place")}
    return _choice(body, "afterwards", AFTERWARDS)


def _queue_most(body: Mapping[str, Any]) -> int:
    value = body.get("queue_most", WAITING)
    if type(value) is not int or not 0 <= value <= WAITING:
        raise ConfigError(f"goal request: queue_most: must be a whole number, 0 to {WAITING}")
    return value


def _choice(body: Mapping[str, Any], name: str, choices: tuple[str, ...]) -> str:
    value = body.get(name, choices[0])
    if not isinstance(value, str) or value not in choices:
        raise ConfigError(f"goal request: {name}: must be {' or '.join(choices)}")
    return value


def _episode(body: Mapping[str, Any]) -> str | int | None:
    value = body.get("episode")
    if value is None or (isinstance(value, int) and not isinstance(value, bool)):
        return value
    if isinstance(value, str) and value.isprintable() and len(value) <= TOLD_CHARS:
        return value
    raise ConfigError(
        f"goal request: episode: must be a name of at most {TOLD_CHARS} letters, or a whole number"
    )
