"""What a real robot adds to the truth, by name: `--noise depth=0.003`. All off by default."""

import zlib
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

import numpy as np

from hil_sim.simulation.depth_cameras import CAMERAS
from runtime.errors import ConfigError


@dataclass(frozen=True)
class Noise:
    """0 is off.

    depth: sigma of a depth reading at 1 m, m; grows with the square of the distance.
    edges: share of the pixels beside a depth edge that have no reading.
    flying: share of them that read something between the near side and the far one.
    glass: share of the pixels of mirrors, showers and windows that have none.
    missing: share of all pixels that have none.
    exposure: sigma of the logarithm of a frame's gain.
    blur: exposure time, s: what turns meanwhile is smeared along the rows.
    motion: of discrete actions, 1 for RoboTHOR's (see `robot.act`).
    slip: sigma of the base's true motion, m after 1 m and rad after 1 rad (see `drive.stray`).
    drift: the same of the reported odometry.
    camera: a depth camera of `depth_cameras.CAMERAS`, besides what the others add; "" for none.
    """

    depth: float = 0.0
    edges: float = 0.0
    flying: float = 0.0
    glass: float = 0.0
    missing: float = 0.0
    exposure: float = 0.0
    blur: float = 0.0
    motion: float = 0.0
    slip: float = 0.0
    drift: float = 0.0
    camera: str = ""


NONE = Noise()
USUAL = Noise(
    depth=0.002,
    edges=0.7,
    glass=0.9,
    missing=0.002,
    exposure=0.08,
    blur=0.01,
    motion=1.0,
    slip=0.01,
    drift=0.005,
)
"""What a name without a value stands for: a mid-range depth camera on a two-wheeled base."""
SHARES = ("edges", "flying", "glass", "missing")


def parse_noise(texts: Iterable[str], base: Noise = NONE) -> Noise:
    """`depth=0.003`, `depth` (the usual value), `camera=kinect-v1`, `all` (every usual value) or
    `none`, comma-separated, onto `base`. ConfigError names the known ones."""
    known = [f.name for f in fields(Noise)]
    for text in (part.strip() for joined in texts for part in joined.split(",")):
        name, equals, value = text.partition("=")
        if text in ("all", "none"):
            base = USUAL if text == "all" else NONE
        elif name not in known:
            raise ConfigError(
                f"noise {name}: unknown; known: {', '.join(known)}, all, none; e.g. depth=0.003"
            )
        elif name == "camera":
            base = replace(base, camera=_camera(value))
        else:
            usual = 0.0 if equals else getattr(USUAL, name)
            amount = usual or _amount(name, value)
            base = Noise(**{**vars(base), name: amount})
    return base


def _camera(name: str) -> str:
    if name not in CAMERAS:
        raise ConfigError(f"noise camera: {name or 'no name'}: known: {', '.join(CAMERAS)}")
    return name


def _amount(name: str, text: str) -> float:
    most = 1.0 if name in SHARES else 10.0
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= most:
        raise ConfigError(f"noise {name}: {text!r}: must be a number from 0 to {most:g}")
    return value


def generator(seed: int, episode: str, step: int, stream: str) -> np.random.Generator:
    """Random numbers of one step and one purpose: the same whatever else was drawn."""
    names = (zlib.crc32(name.encode()) for name in (episode, stream))
    return np.random.default_rng([seed, step, *names])
