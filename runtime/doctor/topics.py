"""What came on which topic: how often, how evenly, how old; and where nothing came, what there is
instead."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from runtime.config import Config
from runtime.core.motion.pace import BRISK_S, LONGEST_S, PATIENCE
from runtime.doctor.advertised import BRIDGE, instead, prefix_of
from runtime.doctor.diagnosis import Diagnosis, bad, ok, unknown, warning
from runtime.doctor.hearing import HeardTopic, Hearing
from runtime.robot import wire
from runtime.robot.publications import cmd_vel_topic
from runtime.robot.stamps import AHEAD_S, LATE_S

NEEDED: Final = ("color", "depth", "camera_info", "odom")
IMAGES: Final = ("color", "depth")
COMMANDS: Final = {wire.TWIST: "Twist", wire.TWIST_STAMPED: "TwistStamped"}
OFFERED: Final = 3  # of the topics that there are instead
CLOCKS_APART_S: Final = 0.2  # between streams of one robot: their stamps are of two clocks
CLOCK_OFF_S: Final = 1.0  # from this computer's


@dataclass(frozen=True)
class TopicBounds:
    """Of a stream, s: a gap that holds the base, and one with which nothing fits together."""

    stale_s: float
    useless_s: float


def judge_topics(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """Of every topic that a search needs, then of those that a robot may have."""
    streams = hearing.streams
    silent = [name for name in NEEDED if name in streams and not streams[name].received]
    if len(silent) == len([name for name in NEEDED if name in streams]):
        yield _nothing(hearing, config)
    else:
        for name in NEEDED:
            if name in silent:
                yield _silent(name, hearing, config)
            elif name in streams:
                yield from _spoken(name, streams[name], config)
        yield from _clocks(hearing)
    if not hearing.network.alone:
        yield from _optional(hearing)


def _nothing(hearing: Hearing, config: Config) -> Diagnosis:
    """What a newcomer sees first."""
    names = ", ".join(
        config.bus.key(hearing.streams[name].topic) for name in NEEDED if name in hearing.streams
    )
    if hearing.network.alone:
        return unknown("topics", "nobody is on the bus", f"they would be {names}")
    told = f"nothing came on any of {names} in {hearing.seconds:g} s"
    settings = _settings(hearing, config)
    if settings:
        return bad("topics", told, "the robot calls them otherwise: see below", *settings)
    there = ", ".join(sorted({one.topic for one in hearing.advertised if one.publishes})[:8])
    if there:
        return bad("topics", told, f"start the camera's and the base's drivers; there are: {there}")
    return bad(
        "topics",
        told,
        "start the drivers of camera and base; `ros2 topic list` says what they publish, and "
        "bus.topics and bus.prefix are where rfnav looks",
    )


def _silent(name: str, hearing: Hearing, config: Config) -> Diagnosis:
    heard = hearing.streams[name]
    key = config.bus.key(heard.topic)
    told = f"nothing came on {key} in {hearing.seconds:g} s"
    kinds = {one.kind for one in hearing.advertised if one.publishes and one.topic == key}
    if heard.kind in kinds:
        remedy = "somebody says to publish it: is its driver at work, and its QoS compatible?"
        return bad(name, told, remedy)
    there = _instead(name, hearing, config)
    if there:
        fits = _setting(name, there[0], config)
        names = ", ".join(there[:OFFERED])
        return bad(name, f"{told}; of its type there are {names}", f"{fits[0]} = {fits[1]}", fits)
    if kinds:
        told = f"{told}; it is published as {', '.join(sorted(kinds))}"
        return bad(name, told, f"have it published as {heard.kind}, or name another topic")
    if any(one.publishes for one in hearing.advertised):
        return bad(name, f"{told}, and nobody publishes {heard.kind}", f"start what brings {name}")
    return bad(
        name,
        f"{told}; what there is instead is not known: nobody tells by liveliness tokens",
        f"`ros2 topic list` says what there is: set bus.topics.{name} to it",
    )


def _instead(name: str, hearing: Hearing, config: Config) -> list[str]:
    heard = hearing.streams[name]
    kinds = {wire.IMAGE, wire.COMPRESSED_IMAGE} if name in IMAGES else {heard.kind}
    taken = [config.bus.key(one.topic) for one in hearing.streams.values() if one.received]
    return instead(name, config.bus.key(heard.topic), kinds, hearing.advertised, taken)


def _setting(name: str, topic: str, config: Config) -> tuple[str, str]:
    prefix = config.bus.prefix.strip("/")
    topic = topic.removeprefix(f"{prefix}/") if prefix else topic
    key = "pose" if name == "odom" and config.bus.topics.pose else name
    return f"bus.topics.{key}", f'"{topic}"'


def _settings(hearing: Hearing, config: Config) -> list[tuple[str, str]]:
    """What would fit all that is needed: a namespace, or other names."""
    needed = [hearing.streams[name] for name in NEEDED if name in hearing.streams]
    prefix = prefix_of((one.topic for one in needed), hearing.advertised)
    if prefix:
        return [("bus.prefix", f'"{prefix}"')]
    found = ((name, _instead(name, hearing, config)) for name in NEEDED if name in hearing.streams)
    return [_setting(name, there[0], config) for name, there in found if there]


def _spoken(name: str, heard: HeardTopic, config: Config) -> Iterator[Diagnosis]:
    """Of a topic on which something came."""
    told = _figures(heard)
    if heard.bad:
        few = f"{told}; of {heard.bad + heard.read} that were read {heard.bad} cannot be used"
        yield warning(name, few, heard.error) if heard.read else bad(name, few, heard.error)
        return
    if name == "camera_info":
        yield ok(name, told)
        return
    longest_s = float(heard.gaps_s.max(initial=0.0))
    median_s = 1 / heard.rate_hz if heard.rate_hz else math.inf
    bounds = _bounds(name, median_s, config)
    if median_s > bounds.useless_s:
        least = f"publish it at {math.ceil(1 / bounds.useless_s)} Hz or more"
        yield bad(name, f"{told}: too seldom", least)
    elif longest_s > bounds.stale_s:
        what = f"{told}; once nothing for {longest_s:.2f} s, which holds the base"
        yield warning(name, what, "look for what delays it: Wi-Fi, a full processor, a slow driver")
    elif name == "odom" and median_s > BRISK_S:
        slow = f"{told}: so seldom that the robot is driven slower for it"
        yield warning(name, slow, f"publish it at {math.ceil(1 / BRISK_S)} Hz or more")
    else:
        yield ok(name, told)


def _bounds(name: str, period_s: float, config: Config) -> TopicBounds:
    safety = config.safety
    if name == "odom":
        return TopicBounds(max(safety.odom_stale_s, min(LONGEST_S, PATIENCE * period_s)), LONGEST_S)
    stale_s = safety.depth_stale_s if name == "depth" else safety.frame_stale_s
    return TopicBounds(stale_s, stale_s)


def _figures(heard: HeardTopic) -> str:
    """In words, what the table of topics has in columns."""
    what = f"{heard.what}, " if heard.what else ""
    return f"{what}{heard.rate_hz:.1f} Hz" if heard.rate_hz else f"{what}one message"


def _clocks(hearing: Hearing) -> Iterator[Diagnosis]:
    """Stamps against this computer's clock, and against each other."""
    ages = {
        name: age
        for name in ("color", "depth", "odom")
        if name in hearing.streams and (age := hearing.streams[name].age_s) is not None
    }
    still = [name for name in ages if _stands_still(hearing.streams[name])]
    for name in still:
        yield warning(
            f"{name} stamps",
            "do not move: zero, or always the same; rfnav goes by when they come",
            "have its driver stamp each message with the time that it was taken at",
        )
    ages = {name: age for name, age in ages.items() if name not in still}
    if not ages:
        return
    first, last = min(ages, key=ages.__getitem__), max(ages, key=ages.__getitem__)
    apart_s = ages[last] - ages[first]
    told = f"{last} is stamped {apart_s:.2f} s before {first}, for the same moment"
    if apart_s > min(LATE_S, AHEAD_S):
        way = "rfnav relates them by when they come, which is less exact: synchronise them (chrony)"
        yield warning("clocks", told, way)
    elif apart_s > CLOCKS_APART_S:
        yield bad(
            "clocks",
            told,
            "synchronise the clocks of the base and of the camera's computer (chrony), or find "
            f"what holds {last} back",
        )
    elif abs(ages[first]) > CLOCK_OFF_S:
        way = "behind" if ages[first] > 0 else "ahead of"
        yield warning(
            "clocks",
            f"all stamps are {abs(ages[first]):.2f} s {way} this computer's clock",
            "rfnav lives with that; recordings and other nodes may not: synchronise them (chrony)",
        )
    else:
        youngest, oldest = 1e3 * ages[first], 1e3 * ages[last]
        yield ok("clocks", f"stamps are {youngest:.0f} to {oldest:.0f} ms old when they come")


def _stands_still(heard: HeardTopic) -> bool:
    stamps = {one.stamp_ns for one in heard.arrivals}
    return len(heard.arrivals) > 2 and (stamps == {0} or len(stamps) == 1)


def _optional(hearing: Hearing) -> Iterator[Diagnosis]:
    """What a robot may have beside its camera."""
    others = {name: one for name, one in hearing.streams.items() if name not in NEEDED}
    for name, heard in others.items():
        if heard.bad:
            yield warning(name, f"{heard.bad} of {heard.received} cannot be used", heard.error)
        elif heard.received:
            yield ok(name, _figures(heard))
    silent = [f"{one.topic} ({name})" for name, one in others.items() if not one.received]
    if silent:
        yield ok("other senses", f"not there, and not needed: {', '.join(silent)}")


def judge_commands(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """Who listens for velocities, and who else commands some."""
    if config.base.kind != "ros2" or hearing.network.alone:
        return
    topic, kind = config.bus.key(config.bus.topics.cmd_vel), cmd_vel_topic(config.bus).kind
    wanted = {one.kind for one in hearing.advertised if not one.publishes and one.topic == topic}
    other = COMMANDS.get(min(wanted - {kind}, default=""))
    if other is not None and kind not in wanted:
        told = f"{topic} is listened to as {other}, and would be told {config.bus.cmd_vel_type}"
        fits = "bus.cmd_vel_type", f'"{other}"'
        yield bad("base", told, f"{fits[0]} = {fits[1]}", fits)
    elif hearing.network.base is None:
        yield unknown("base", f"whether anybody listens on {topic}")
    elif not hearing.network.base:
        yield bad(
            "base",
            f"nobody listens on {topic} for {kind}",
            "start the base's driver, or set bus.topics.cmd_vel, or bus.cmd_vel_type; a bridge "
            "listens where ROS 2 has a subscriber",
        )
    else:
        yield ok("base", f"somebody listens on {topic}; it is told {config.bus.cmd_vel_type}")
    if hearing.network.commands and not hearing.network.runtime:
        yield warning(
            "commands",
            f"somebody commands {topic} already",
            "two would drive: stop it, or let a multiplexer such as twist_mux choose",
        )


def judge_dialect(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """Whether the robot's names are those that the runtime uses, as far as tokens tell."""
    bus, others = config.bus, [one for one in hearing.advertised if one.publishes]
    if not others:
        return
    there = sorted({one.dialect for one in others})
    told = f"{' and '.join(there)} is spoken; {len({one.topic for one in others})} topics"
    ours = [one for one in others if one.dialect == bus.dialect]
    domains = sorted({one.domain for one in ours})
    humble = bool(ours) and not any(one.hashed for one in ours)
    if not ours:
        fits = "bus.dialect", f'"{there[0]}"'
        yield bad(
            "dialect", f"{told}, bus.dialect is {bus.dialect}", f"{fits[0]} = {fits[1]}", fits
        )
    elif bus.dialect == BRIDGE:
        yield ok("dialect", told)
    elif bus.domain not in domains:
        fits = "bus.domain", str(domains[0])
        found = f"{told}, in ROS domain {', '.join(map(str, domains))}; bus.domain is {bus.domain}"
        yield bad("dialect", found, f"{fits[0]} = {fits[1]}", fits)
    elif humble is not (bus.distro == "humble"):
        fits = "bus.distro", '"humble"' if humble else '"jazzy"'
        found = (
            f"{told}, types {'without' if humble else 'with'} hashes; bus.distro is {bus.distro}"
        )
        yield bad("dialect", found, f"{fits[0]} = {fits[1]}, or what the robot has", fits)
    else:
        yield ok("dialect", f"{told}, in ROS domain {bus.domain}")


def table(hearing: Hearing, config: Config) -> list[str]:
    """Every topic that something came on, in columns."""
    rows: list[tuple[str, ...]] = [("topic", "Hz", "jitter", "age", "bytes", "what", "frame")]
    for heard in hearing.streams.values():
        if heard.received:
            rows.append(_row(heard, config))
    if len(rows) == 1:
        return []
    widths = [max(len(row[n]) for row in rows) for n in range(len(rows[0]))]
    right = (1, 2, 3, 4)
    return [
        "  ".join(
            cell.rjust(width) if n in right else cell.ljust(width)
            for n, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def _row(heard: HeardTopic, config: Config) -> tuple[str, ...]:
    jitter, age = heard.jitter_s, None if _stands_still(heard) else heard.age_s
    sizes = sorted(one.size for one in heard.arrivals)
    return (
        config.bus.key(heard.topic),
        f"{heard.rate_hz:.1f}" if heard.rate_hz else "-",
        f"{1e3 * jitter:.0f} ms" if jitter is not None else "-",
        _age(age),
        _bytes(sizes[len(sizes) // 2]) if sizes else "-",
        heard.what or "-",
        heard.frame or "-",
    )


def _age(age_s: float | None) -> str:
    if age_s is None:
        return "-"
    return f"{1e3 * age_s:.0f} ms" if abs(age_s) < 10 else f"{age_s:.3g} s"


def _bytes(size: int) -> str:
    if size < 10_000:
        return str(size)
    return f"{size / 1e3:.0f} k" if size < 1e6 else f"{size / 1e6:.1f} M"
