"""TOML -> one frozen Config. Each module declares its own part; an unknown key is an error that
names the nearest known one."""

import dataclasses
import difflib
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import cattrs
from cattrs.errors import ClassValidationError, ForbiddenExtraKeysError

from runtime.core.motion.safety import SafetyConfig
from runtime.core.types import Mount
from runtime.core.voting import consensus
from runtime.core.voting.likelihood_experts import ExpertConfig
from runtime.core.voting.rehearsal import SpeculationConfig
from runtime.errors import ConfigError
from runtime.experts import cloud_config
from runtime.experts.cloud_config import CloudConfig
from runtime.navigate import NavigateConfig
from runtime.robot.bus import BusConfig

_RATES = ("max_speed_mps", "max_turn_radps", "max_accel_mps2", "brake_mps2", "look_radps")
EXPERTS = ("o2f", "r2f", "sle", "both")
"""`both`: one expert asked about objects and rooms together, to compare with."""
SEATED = ("o2f", "r2f", "sle")


@dataclass(frozen=True)
class PanelConfig:
    """[panel]: who votes and how long the vote may take."""

    experts: tuple[str, ...] = SEATED
    decide_budget_s: float = 2.0  # votes that come later are dropped
    reserve_s: float = 0.1  # of it, for the election and a thread that wakes late; half at most
    budget_in_lockstep: bool = False  # else experts run to completion, as simulated time waits

    @property
    def votes_s(self) -> float:
        """How long votes are waited for, so that the decision is made within its budget."""
        return max(self.decide_budget_s - self.reserve_s, self.decide_budget_s / 2)


@dataclass(frozen=True)
class ModelsConfig:
    """[models]: names from the manifest, or paths to files of the same contract."""

    language: str = "smollm2-135m"
    language_style: Literal["", "score", "reason"] = ""  # "": the manifest's; a file's is "score"
    vision: str = ""  # that SLE asks about each frontier's picture; "": it has none
    vision_projector: str = ""  # its mmproj GGUF, where `vision` is a file
    vision_handler: str = ""  # of llama-cpp-python: "mtmd", "llava-1.5", "qwen2.5-vl", ...
    vision_style: Literal["", "score", "reason"] = ""  # "score": yes or no of each picture alone
    context_tokens: int = 2048  # of a model that reasons or sees
    reply_tokens: int = 200
    gpu_layers: int = 0  # of such a model, where llama-cpp-python was built for a GPU; -1: all
    text: str = "minilm"
    detector: str = "rfnav-det"
    detector_kind: Literal["auto", "rfnav", "prompted", "yolo"] = "auto"  # the file's contract
    second_look: str = "second-look"  # classifier for goals the detector has no word for; "": none
    detector_classes: str = ""  # file with one class name a line, for a fixed list
    vocabulary: str = ""  # TOML word list; "" is the built-in one
    threads: int = 2
    score_file: str = ""  # SQLite file of the language model's scores; "" is one in the cache


@dataclass(frozen=True)
class DetectorConfig:
    """[detector]"""

    min_score: float = 0.2  # weaker detections are not looked at
    source: Literal["model", "topic"] = "model"  # "topic": from the bus, e.g. a harness's labels
    labels: tuple[str, ...] = ()  # names on the bus besides the vocabulary's
    second_looks: int = 5  # places of an image shown to it then, 15 at most
    memo_frames: int = 0  # images whose detections are kept: a harness shows the same ones again


@dataclass(frozen=True)
class GoalConfig:
    """[goal]"""

    same_as_similarity: float = 0.65  # MiniLM cosine from which a goal is taken for a known class
    keep_map: bool = False  # a goal begins with the map and the objects of the one before


@dataclass(frozen=True)
class RealtimeConfig:
    """[realtime]: rates of the loops that do not follow the camera's."""

    control_hz: float = 20.0
    state_hz: float = 5.0  # of rfnav/state, besides its changes
    feedback_s: float = 1.0  # between messages on rfnav/feedback


@dataclass(frozen=True)
class Config:
    """The whole configuration. The core's tables ([map], [planner], ...) are at the top level of
    the file and gathered in `navigate`."""

    camera: Mount = field(default_factory=Mount)
    panel: PanelConfig = field(default_factory=PanelConfig)
    experts: ExpertConfig = field(default_factory=ExpertConfig)
    models: ModelsConfig = field(default_factory=ModelsConfig)
    cloud: CloudConfig = field(default_factory=CloudConfig)
    detector: DetectorConfig = field(default_factory=DetectorConfig)
    goal: GoalConfig = field(default_factory=GoalConfig)
    bus: BusConfig = field(default_factory=BusConfig)
    safety: SafetyConfig = field(default_factory=SafetyConfig)
    speculation: SpeculationConfig = field(default_factory=SpeculationConfig)
    realtime: RealtimeConfig = field(default_factory=RealtimeConfig)
    navigate: NavigateConfig = field(default_factory=NavigateConfig)


def load(path: Path | None, settings: Iterable[str] = ()) -> Config:
    """Read a TOML file (None: defaults) and apply `KEY=VALUE` settings, KEY dotted, VALUE TOML."""
    table: dict[str, Any] = {}
    if path is not None:
        try:
            table = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise ConfigError(f"{path}: cannot be read ({error.strerror})") from error
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ConfigError(f"{path}: not valid TOML: {error}") from error
    for setting in settings:
        _set(table, setting)
    config = from_table(table, str(path) if path else "configuration")
    _check(config)
    return config


def from_table(table: dict[str, Any], source: str) -> Config:
    """A parsed table -> Config; ConfigError names the key and what would be right."""
    core = {f.name for f in dataclasses.fields(NavigateConfig)}
    own = {f.name for f in dataclasses.fields(Config)} - {"navigate"}
    for key in table:
        if key not in core | own:
            raise ConfigError(f"{source}: {key}: {_unknown(key, core | own)}")
        if not isinstance(table[key], dict):
            raise ConfigError(f"{source}: {key}: must be a table, [{key}]")
    nested = {k: v for k, v in table.items() if k in own}
    nested["navigate"] = {k: v for k, v in table.items() if k in core}
    try:
        return _converter().structure(nested, Config)
    except ClassValidationError as error:
        raise ConfigError(f"{source}: {_first(error, Config, ())}") from None


def _check(config: Config) -> None:
    for name in config.panel.experts:
        if name not in EXPERTS:
            raise ConfigError(f"panel.experts: {_unknown(name, EXPERTS)}")
    _one_of("consensus.rank", config.navigate.consensus.rank, ("nearest", "farthest"))
    _one_of("consensus.mode", config.navigate.consensus.mode, consensus.MODES)
    _one_of("consensus.fallback", config.navigate.consensus.fallback, ("closest", "geometry"))
    _one_of("bus.mode", config.bus.mode, ("peer", "client"))
    cloud_config.check(config.cloud)
    shown = config.cloud.sends_images or config.models.vision
    if shown and not config.navigate.keyframes.image_width_px:
        raise ConfigError(
            "keyframes.image_width_px: is 0, so that no image is kept; a model that sees needs "
            "some, e.g. 320"
        )
    positive = {
        "map.resolution_m": config.navigate.map.resolution_m,
        "robot.radius_m": config.navigate.robot.radius_m,
        "experts.temperature": config.experts.temperature,
        "panel.decide_budget_s": config.panel.decide_budget_s,
        "models.threads": config.models.threads,
        "models.context_tokens": config.models.context_tokens,
        "models.reply_tokens": config.models.reply_tokens,
        "realtime.control_hz": config.realtime.control_hz,
        "realtime.state_hz": config.realtime.state_hz,
        **{f"safety.{key}": value for key, value in vars(config.safety).items()},
        **{f"control.{key}": getattr(config.navigate.control, key) for key in _RATES},
    }
    for key, value in positive.items():
        if not value > 0:
            raise ConfigError(f"{key}: is {value}, must be more than 0")
    if not config.navigate.consensus.detour_m >= 0:
        raise ConfigError(
            f"consensus.detour_m: is {config.navigate.consensus.detour_m}, must be 0 or more"
        )


def _one_of(key: str, value: str, known: Iterable[str]) -> None:
    if value not in known:
        raise ConfigError(f"{key}: {_unknown(value, known)}")


def _set(table: dict[str, Any], setting: str) -> None:
    key, equals, value = setting.partition("=")
    if not equals or not key.strip():
        raise ConfigError(f"--set {setting}: must be KEY=VALUE, e.g. panel.decide_budget_s=1.0")
    *path, last = key.strip().split(".")
    try:
        parsed = tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        parsed = value  # a bare word is a string
    for part in path:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise ConfigError(f"--set {setting}: {part} is not a table")
    table[last] = parsed


def _converter() -> cattrs.Converter:
    converter = cattrs.Converter(forbid_extra_keys=True)
    for kind, accepted in ((bool, bool), (int, int), (float, (int, float)), (str, str)):
        converter.register_structure_hook(kind, _exactly(kind, accepted))
    return converter


def _exactly(kind: type, accepted: Any) -> Any:
    def convert(value: Any, _: Any) -> Any:
        if not isinstance(value, accepted) or (isinstance(value, bool) and kind is not bool):
            raise TypeError(f"is {value!r}, must be of type {kind.__name__}")
        return kind(value)

    return convert


def _first(error: BaseException, cls: Any, path: tuple[str, ...]) -> str:
    """The first leaf of a cattrs error as "table.key: what is wrong"."""
    if isinstance(error, ForbiddenExtraKeysError):
        key = sorted(error.extra_fields)[0]
        known = [f.name for f in dataclasses.fields(error.cl)]
        return f"{'.'.join((*path, key))}: {_unknown(key, known)}"
    if isinstance(error, BaseExceptionGroup):
        inner = error.exceptions[0]
        name = _field_of(inner)
        return _first(inner, cls, (*path, name) if name and name != "navigate" else path)
    return f"{'.'.join(path)}: {' '.join(str(error).split())}"


def _field_of(error: BaseException) -> str:
    notes = getattr(error, "__notes__", [])
    return next((str(n.name) for n in notes if hasattr(n, "name")), "")


def _unknown(key: str, known: Iterable[str]) -> str:
    names = sorted(known)
    near = difflib.get_close_matches(key, names, n=1, cutoff=0.5)
    return f"unknown; did you mean {near[0]}?" if near else f"unknown; known are {', '.join(names)}"
