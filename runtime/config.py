"""TOML -> one frozen Config. Each module declares its own part; an unknown key is an error that
names the nearest known one, a former key one that names what became of it.

Keys are `table.name`. What methods and questions are compared by is in one table, `[research]`,
wherever the field is that it sets.
"""

import difflib
import functools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from runtime.core.keys import RESEARCH, Key, key, keys_of
from runtime.core.motion.safety import SafetyConfig
from runtime.core.voting.likelihood_experts import ExpertConfig
from runtime.errors import ConfigError
from runtime.experts import cloud_config
from runtime.experts.cloud_config import CloudConfig
from runtime.experts.panel import PanelConfig
from runtime.former_keys import FORMER, LISTED, gone, renamed
from runtime.log import say
from runtime.navigate import NavigateConfig
from runtime.robot import base_config, reflex, session, transforms
from runtime.robot.battery import BatteryConfig
from runtime.robot.topic_names import check_topics
from runtime.robot.transforms import CameraConfig
from runtime.toml_values import NotOfTypeError, parse_toml, read_toml, structured, unknown

NAVIGATE = "navigate"
"""Where the core's tables are gathered, which are at the top level of the file."""
Style = Literal["", "score", "reason"]


@dataclass(frozen=True)
class ModelsConfig:
    """[models]: names from the manifest, or paths to files of the same contract."""

    language: str = key("smollm2-135m", "The language model that experts ask.")
    language_style: Style = key(
        "", '"score" weighs words, "reason" answers in words; "": as the manifest has it.'
    )
    vision: str = key("", 'The model that is shown each frontier\'s picture; "": there is none.')
    vision_projector: str = key("", "Its mmproj GGUF, where `vision` is a file.")
    vision_handler: str = key(
        "", 'How llama-cpp-python talks to it: "mtmd", "llava-1.5", "qwen2.5-vl", ...'
    )
    detectors: tuple[str, ...] = key(
        ("rfnav-det", "nanodet-g", "rfnav-det-photos"),
        "The object detectors; what they see is made one.",
    )
    domain: Literal["auto", "photographs", "renderings"] = key(
        "auto",
        'What the camera shows: "photographs", "renderings", or "auto", told from the images.',
    )
    vocabulary: str = key("", 'TOML word list; "" is the built-in one.')
    threads: int = key(2, "Processor threads of each model.", within=(1, 64))
    gpu_layers: int = key(
        0,
        "Layers on the GPU, where llama-cpp-python was built for one; -1: all.",
        within=(-1, 1000),
    )
    vision_style: Style = key(
        "",
        'How a model that sees votes: "score" says yes or no of each picture alone, "reason" has '
        "all at once, and answers in words.",
        research="vision_style",
    )
    context_tokens: int = key(
        2048,
        "Context of a model that reasons or sees.",
        "tokens",
        research="context_tokens",
        within=(256, 131_072),
    )
    second_look: str = key(
        "second-look",
        'Classifier for goals that the detector has no word for; "": none.',
        research="second_look",
    )
    scene_layout: str = key(
        "",
        'The network behind `research.scene_layout`, a name or an ONNX file; "": the one that was '
        "taught on what a configured detector sees.",
        research="scene_layout_file",
    )
    others_every: int = key(
        2,
        "Frames between two looks of a detector that was trained for the other domain, and of ours "
        "beside another.",
        research="other_detectors_every",
        within=(1, 1000),
    )
    score_file: str = key(
        "", 'SQLite file of the language model\'s scores; "" is one in the cache.',
        research="score_file",
    )  # fmt: skip
    keep_scores: bool = key(
        True, "Whether scores outlive the goal that they were made for.", research="keep_scores"
    )


@dataclass(frozen=True)
class DetectorConfig:
    """What of the detector is turned to compare."""

    source: Literal["model", "topic", "both"] = key(
        "model",
        '"topic": detections come from the bus, e.g. a harness\'s labels; "both": objects do, and '
        "room, view and features are the model's.",
        research="detector_source",
    )
    labels: tuple[str, ...] = key(
        (), "Names on the bus besides the vocabulary's.", research="detector_labels"
    )
    memo_frames: int = key(
        0,
        "Images whose detections are kept: a harness shows the same ones again.",
        research="detector_memo_frames",
        within=(0, 100_000),
    )
    second_looks: int = key(
        5,
        "Places of an image shown to that classifier, 15 at most; 0: none.",
        research="second_looks",
        within=(0, 15),
    )
    clip_way: Literal["patch", "reference", "grad"] = key(
        "patch",
        "How a detector of contract clip finds things: each patch as what it looks like; the goal "
        "by sentences that say where it is; the goal by its relevance map.",
        research="clip_way",
    )


@dataclass(frozen=True)
class GoalConfig:
    """[goal]"""

    keep_map: bool = key(
        False,
        "A new goal begins with the map and the objects of those before; over restarts, too, where "
        "the robot's own configuration has it, once it is known where it is.",
    )
    after_restart: Literal["fail", "resume"] = key(
        "fail",
        'What becomes of goals that had not ended when the runtime did: "fail" reports them as '
        'failed, "resume" searches for them again.',
    )


@dataclass(frozen=True)
class MetricsConfig:
    """[metrics]"""

    port: int = key(
        0, "Where on 127.0.0.1 Prometheus reads metrics, e.g. 9464; 0: nowhere.", within=(0, 65_535)
    )


@dataclass(frozen=True)
class RealtimeConfig:
    """[realtime]: rates of the loops that do not follow the camera's."""

    control_hz: float = key(20.0, "Rate of the commands to the base.", "Hz", within=(5.0, 200.0))
    state_hz: float = key(
        5.0, "Rate of rfnav/state, besides its changes.", "Hz", within=(0.1, 50.0)
    )
    keep_stages: bool = key(
        False, "Stages are counted over all goals, not anew for each.", research="keep_stages"
    )


@dataclass(frozen=True)
class Config:
    """The whole configuration. The core's tables ([robot], [map], [control], ...) are at the top
    level of the file and gathered in `navigate`."""

    navigate: NavigateConfig = field(default_factory=NavigateConfig)
    camera: CameraConfig = field(default_factory=CameraConfig)
    bus: session.BusConfig = field(default_factory=session.BusConfig)
    base: base_config.BaseConfig = field(default_factory=base_config.BaseConfig)
    senses: session.SensesConfig = field(default_factory=session.SensesConfig)
    battery: BatteryConfig = field(default_factory=BatteryConfig)
    safety: SafetyConfig = field(default_factory=SafetyConfig)
    realtime: RealtimeConfig = field(default_factory=RealtimeConfig)
    metrics: MetricsConfig = field(default_factory=MetricsConfig)
    goal: GoalConfig = field(default_factory=GoalConfig)
    panel: PanelConfig = field(default_factory=PanelConfig)
    models: ModelsConfig = field(default_factory=ModelsConfig)
    cloud: CloudConfig = field(default_factory=CloudConfig)
    detector: DetectorConfig = field(default_factory=DetectorConfig)
    experts: ExpertConfig = field(default_factory=ExpertConfig)


@functools.cache
def known_keys() -> dict[str, Key]:
    """All keys by name, with their defaults; those of [research] last."""
    keys = sorted(keys_of(Config(), unseen=NAVIGATE), key=lambda k: k.table == RESEARCH)
    return {k.name: k for k in keys}


def load(
    path: Path | None, settings: Iterable[str] = (), before: Mapping[str, Any] | None = None
) -> Config:
    """Read a TOML file (None: defaults) and apply `KEY=VALUE` settings, KEY dotted, VALUE TOML.
    `before`: values by key that the file goes over."""
    table: dict[str, Any] = {}
    if path is not None:
        table = read_toml(path)
    source = str(path) if path else "configuration"
    values = dict(_flat(before or {}, source)) | dict(_flat(table, source))
    for setting in settings:
        values |= _flat(_parsed(setting), source)
    config = from_values(values, source)
    _check(config)
    return config


def from_values(values: Mapping[str, Any], source: str) -> Config:
    """Values by key, as TOML has them -> Config; ConfigError names the key and what would be
    right."""
    known = known_keys()
    nested: dict[str, Any] = {}
    for name, value in values.items():
        *path, last = known[name].path
        table = nested
        for part in path:
            table = table.setdefault(part, {})
        table[last] = value
    try:
        return structured(nested, Config)
    except NotOfTypeError as error:
        name = next(k.name for k in known.values() if k.path == error.path)
        raise ConfigError(f"{source}: {name}: {error.what}") from None


def _flat(table: Mapping[str, Any], source: str, within: str = "") -> Iterator[tuple[str, Any]]:
    """Each value of parsed TOML by the key that it is today."""
    known = known_keys()
    for part, value in table.items():
        name = f"{within}.{part}" if within else part
        if not name.isprintable():
            raise ConfigError(f"{source}: {name!r:.80}: unknown")
        successor = renamed(name)
        if name in known:
            yield name, value
        elif successor is not None:
            _tell(name, successor)
            yield successor, [value] if name in LISTED else value
        elif (told := gone(name)) is not None:
            raise ConfigError(f"{source}: {name}: {told}")
        elif not any(n.startswith(f"{name}.") for n in (*known, *FORMER)):
            raise ConfigError(f"{source}: {_stranger(name, known)}")
        elif not isinstance(value, dict):
            raise ConfigError(f"{source}: {name}: must be a table, [{name}]")
        else:
            yield from _flat(value, source, name)


@functools.cache
def _tell(name: str, successor: str) -> None:
    """Once a process: a goal's own settings are read with the file anew."""
    say(f"{name}: is called {successor} now")


def _stranger(name: str, known: Iterable[str]) -> str:
    """What is said of a key that there never was: the nearest of those beside it."""
    table, _, last = name.rpartition(".")
    inside = f"{table}." if table else ""
    beside = {n.removeprefix(inside).split(".")[0] for n in known if n.startswith(inside)}
    if beside:
        return f"{name}: {unknown(last, beside)}"
    # of a table that has gone with all of its keys
    former = [n.removeprefix(inside) for n in FORMER if n.startswith(inside)]
    near = difflib.get_close_matches(last, former, n=1, cutoff=0.5)
    if not near:
        return _stranger(table, known)
    meant = inside + near[0]
    return f"{name}: unknown; did you mean {renamed(meant) or meant}?"


def _parsed(setting: str) -> dict[str, Any]:
    key, equals, value = setting.partition("=")
    if not equals or not key.strip():
        raise ConfigError(f"--set {setting}: must be KEY=VALUE, e.g. panel.decide_budget_s=1.0")
    try:
        parsed = parse_toml(f"value = {value}")["value"]
    except ValueError:
        parsed = value  # a bare word is a string
    for part in reversed(key.strip().split(".")):
        parsed = {part: parsed}
    return dict(parsed)


def _check(config: Config) -> None:
    """What the types do not say."""
    keys = known_keys().items()
    found = {name: known.wrong(known.value(config)) for name, known in keys}
    if wrong := [f"{name}: {what}" for name, what in found.items() if what]:
        raise ConfigError("; ".join(wrong))
    cloud_config.check(config.cloud)
    session.check(config.bus)
    transforms.check(config.camera)
    base_config.check(config.base)
    reflex.check(config.navigate)
    check_topics(config.bus)
    if config.base.odometry and config.bus.topics.pose:
        raise ConfigError(
            "base.odometry: bus.topics.pose is set too; the pose comes from one of them"
        )
    by = config.navigate.consensus
    if by.mode == "prior" and by.fallback == "closest" and config.panel.experts:
        raise ConfigError(
            'research.consensus_mode: is "prior", for which research.consensus_fallback must be '
            '"geometry" or "ahead": "closest" weighs nothing that evidence could be of'
        )
    if not config.models.detectors:
        raise ConfigError('models.detectors: is empty; name one at least, e.g. ["rfnav-det"]')
    shown = config.cloud.sends_images or config.models.vision
    if shown and not config.navigate.keyframes.image_width_px:
        raise ConfigError(
            "keyframes.image_width_px: is 0, so that no image is kept; a model that sees needs "
            "some, e.g. 320"
        )
