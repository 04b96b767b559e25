"""The camera: colour and depth of one moment, one of the other's pixels, and what depth tells."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from runtime.config import Config
from runtime.core.types import F64
from runtime.doctor.diagnosis import Diagnosis, bad, ok, unknown, warning
from runtime.doctor.hearing import HeardTopic, Hearing
from runtime.robot.streams import PAIR_TOLERANCE_S

LACKS: Final = "mend pairs, clocks and odometry's rate"
PAIRED: Final = 0.8  # of the images that come more seldom, at least
BENT_PX: Final = 2.0  # that the lens moves the image's corners by, at least, to be told of
SEEN: Final = 0.2  # of a depth image's pixels with a reading, at least


def judge_camera(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """Pairing, what the runtime made of the images, registration, lens, depth's readings."""
    color, depth = hearing.streams.get("color"), hearing.streams.get("depth")
    if color is None or depth is None or not color.received or not depth.received:
        return
    yield _paired(color, depth)
    yield _framed(hearing, depth)
    yield from _registered(hearing, color, depth)
    yield from _lens(hearing)
    yield from _readings(hearing, config)


def _stamps(heard: HeardTopic) -> F64:
    """(N,) s since the first of them."""
    stamps = [one.stamp_ns for one in heard.arrivals if one.stamp_ns is not None]
    return np.array(stamps, np.float64) / 1e9


def _paired(color: HeardTopic, depth: HeardTopic) -> Diagnosis:
    """Of the stream that has fewer images, how many find one of the other in time."""
    few, many = sorted((_stamps(color), _stamps(depth)), key=len)
    if len(np.unique(few)) < 2 or len(np.unique(many)) < 2:
        return unknown("pairs", "stamps do not tell; colour and depth go together as they come")
    apart = np.abs(few[:, None] - many[None]).min(axis=1)
    share, most_ms = float((apart <= PAIR_TOLERANCE_S).mean()), 1e3 * PAIR_TOLERANCE_S
    told = f"{share:.0%} of the images have colour and depth within {most_ms:.0f} ms"
    if share >= PAIRED:
        return ok("pairs", f"{told}; {1e3 * float(np.median(apart)):.1f} ms apart at the median")
    middle_ms = 1e3 * float(np.median(apart))
    told = f"{told}; {middle_ms:.0f} ms apart at the median"
    remedy = (
        "have the driver take both at once and stamp them alike (RealSense: enable_sync; OAK-D: "
        "syncNN off, one FPS for both)"
    )
    return bad("pairs", told, remedy) if share < 0.1 else warning("pairs", told, remedy)


def _framed(hearing: Hearing, depth: HeardTopic) -> Diagnosis:
    """How many depth images became a frame: with colour, intrinsics and odometry of their time."""
    told = f"{hearing.frames} of {depth.received} depth images became a frame of the map"
    if not hearing.frames:
        topics = (hearing.streams[name].topic for name in ("depth", "color", "camera_info"))
        errors = [error for topic in topics if (error := hearing.errors.get(topic))]
        return bad("frames", told, errors[0] if errors else hearing.held or LACKS)
    if hearing.frames < PAIRED * depth.received - 2:  # the first and the last lack some of theirs
        return warning(
            "frames", told, "look at pairs, clocks and rates; or this computer was too busy for all"
        )
    return ok("frames", told)


def _registered(hearing: Hearing, color: HeardTopic, depth: HeardTopic) -> Iterator[Diagnosis]:
    """Whether depth is of colour's pixels, or is taken to them; where that cannot be, no frame
    comes, and that says why."""
    if not hearing.frames or hearing.intrinsics is None:
        return
    k, own = hearing.intrinsics, {"depth": depth.frame, "colour": color.frame}
    told = f'depth and colour are both in "{color.frame}"'
    if depth.frame != color.frame:
        told = " and ".join(f'{name} is in "{frame}"' for name, frame in own.items())
        told += ": rfnav takes depth to colour's pixels"
    yield ok("registration", f"{told}; frames are {k.width}x{k.height}")


def _lens(hearing: Hearing) -> Iterator[Diagnosis]:
    info = hearing.info
    if info is None:
        return
    k = info.intrinsics
    told = f"{k.width}x{k.height}, fx {k.fx:.1f}, fy {k.fy:.1f}, cx {k.cx:.1f}, cy {k.cy:.1f}"
    if any(info.distortion):
        bent = ", ".join(f"{value:.3g}" for value in info.distortion[:5])
        yield ok("lens", f"{told}; {info.model} distortion {bent} is undone")
    else:
        yield ok("lens", f"{told}; no distortion")


def _readings(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """How much of the depth images is there, and whether it is in metres."""
    if not hearing.depths:
        return
    seen = [float((depth > 0).mean()) for depth in hearing.depths]
    share = float(np.median(seen))
    near = np.concatenate([depth[depth > 0] for depth in hearing.depths])
    if not near.size:
        yield bad("depth readings", "not one in any image", "uncover the camera, or look elsewhere")
        return
    middle_m, far_m = float(np.median(near)), config.navigate.map.max_depth_m
    told = f"{share:.0%} of the pixels have one, {middle_m:.2f} m at the median"
    if share < SEEN:
        yield warning(
            "depth readings",
            told,
            "little will be mapped: turn the robot to what has texture and is nearer than "
            f"{far_m:g} m, and look at exposure and the emitter",
        )
    else:
        yield ok("depth readings", told)
