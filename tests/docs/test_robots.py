"""docs/robots.md and deploy/robots/: every robot has its section and its files, the files can be
used, and a bridge carries what the runtime listens to and nothing else. No robot is there."""

import json
import re
import shlex
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import zenoh
from click.testing import CliRunner
from lockstep_double import free_port
from places import ROOT

from runtime.__main__ import cli
from runtime.config import Config, known_keys, load
from runtime.loops.drawings import TOPICS as DRAWN_TOPICS
from runtime.robot.heard_topics import heard_topics
from runtime.robot.transforms import TF, TF_STATIC

DEPLOYED = ROOT / "deploy" / "robots"
ROBOTS = sorted(DEPLOYED.glob("*.toml"))
BRIDGES = sorted(DEPLOYED.glob("*.bridge.json5"))
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGE = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
NAMES = [robot.stem for robot in ROBOTS]


def bridge_of(name: str) -> dict[str, object]:
    """A bridge's configuration; of JSON5 only comments on lines of their own are used."""
    lines = (DEPLOYED / f"{name}.bridge.json5").read_text(encoding="utf-8").splitlines()
    told: dict[str, object] = json.loads(
        "\n".join(line for line in lines if not line.lstrip().startswith("//"))
    )
    return told


def allowed(name: str) -> dict[str, list[str]]:
    """What a bridge may carry: by direction, patterns of whole names."""
    found: dict[str, list[str]] = bridge_of(name)["plugins"]["ros2dds"]["allow"]  # type: ignore[index]
    return found


def heard(config: Config) -> set[str]:
    """The names in ROS of all that the runtime listens to."""
    topics = {name: topic.name for name, topic in heard_topics(config.bus).items()}
    if config.base.odometry:
        topics.pop("odom", None)
    if config.camera.by_tf is not None:
        topics[TF] = TF
    return {f"/{config.bus.key(name)}" for name in topics.values()}


def about_the_camera(config: Config) -> set[str]:
    """What tells where frames are, and which lens took depth."""
    beside = config.bus.topics.depth.rpartition("/")[0]
    return {f"/{config.bus.key(name)}" for name in (TF_STATIC, f"{beside}/camera_info")}


def section(title: str) -> str:
    """A section of the page, without its heading."""
    start = rf"^## {re.escape(title)}\n"
    [found] = re.findall(rf"{start}(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    return str(found)


def title_of(robot: Path) -> str:
    """The section that a configuration sends its reader to."""
    words = " ".join(robot.read_text(encoding="utf-8").replace("\n# ", " ").split())
    [title] = re.findall(r'docs/robots\.md, "([^"]+)"', words)
    return str(title)


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_a_configuration_can_be_used(robot: Path) -> None:
    told = CliRunner().invoke(cli, ["check", "--config", str(robot)])
    assert told.exit_code == 0, told.output
    assert told.output == f"{robot}: ok\n"  # no key that was renamed, nothing open to others


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_a_configuration_says_that_nobody_tried_it(robot: Path) -> None:
    assert "UNTRIED" in robot.read_text(encoding="utf-8").split("\n[", 1)[0]
    assert "**Not tried**" in section(title_of(robot))


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_what_a_robot_is_is_set_and_not_left_to_the_default(robot: Path) -> None:
    config, text = load(robot), robot.read_text(encoding="utf-8")
    for key in ("radius_m", "height_m", "max_speed_mps", "brake_mps2", "z_m", "pitch_rad"):
        assert re.search(rf"^{key} = ", text, re.MULTILINE), key
    assert known_keys()["control.max_speed_mps"].value(config) <= 0.4


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_a_configuration_has_its_section_which_names_it(robot: Path) -> None:
    assert f"deploy/robots/{robot.stem}.bridge.json5" in section(title_of(robot))
    assert f"`deploy/robots/{robot.name}`" in PAGE.partition("## ")[0]


def test_every_robot_of_the_page_has_its_configuration() -> None:
    table = re.findall(r"^\| \[(.+?)\]\(#(.+?)\) \| `(.+?)` \|", PAGE, re.MULTILINE)
    assert sorted(ROOT / path for _, _, path in table) == ROBOTS
    assert [title for title, _, _ in table] == re.findall(r"^## (.+)$", PAGE, re.MULTILINE)[1:]


def test_every_robot_has_a_bridge_and_every_bridge_a_robot() -> None:
    assert [bridge.name.removesuffix(".bridge.json5") for bridge in BRIDGES] == NAMES


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_a_bridge_carries_what_is_listened_to_and_nothing_else(robot: Path) -> None:
    config, allow = load(robot), allowed(robot.stem)
    assert set(allow) == {"publishers", "subscribers"}
    assert set(allow["publishers"]) == heard(config) | about_the_camera(config)


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_a_bridge_takes_commands_and_drawings_to_ros_and_nothing_else(robot: Path) -> None:
    config, patterns = load(robot), allowed(robot.stem)["subscribers"]
    said = [topic.name for name, topic in DRAWN_TOPICS.items() if name in config.bus.draws]
    if config.base.kind != "mavlink":
        said.append(config.bus.topics.cmd_vel)
    by = {n: [p for p in patterns if re.fullmatch(p, f"/{config.bus.key(n)}")] for n in said}
    assert all(len(matching) == 1 for matching in by.values()), by
    assert {pattern for matching in by.values() for pattern in matching} == set(patterns)


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_a_bridge_is_where_the_runtime_looks_for_it_and_open_to_nobody_else(robot: Path) -> None:
    config, bridge = load(robot), bridge_of(robot.stem)
    assert bridge["listen"] == {"endpoints": list(config.bus.connect)}
    assert all(end.startswith("tcp/127.0.0.1:") for end in config.bus.connect)
    assert bridge["scouting"] == {"multicast": {"enabled": False}}


def test_zenoh_reads_the_bridges() -> None:
    for bridge in BRIDGES:
        config = zenoh.Config.from_file(str(bridge))
        assert "127.0.0.1:7447" in config.get_json("listen/endpoints")


def test_dds_is_kept_to_the_cable_and_the_computer() -> None:
    tree = ElementTree.parse(DEPLOYED / "create3-cyclonedds.xml")
    used = [one.attrib for one in tree.iter() if one.tag.endswith("NetworkInterface")]
    assert used == [{"name": "usb0"}, {"address": "127.0.0.1", "multicast": "true"}]


def test_every_file_that_is_deployed_for_robots_is_named_on_the_page() -> None:
    for file in DEPLOYED.iterdir():
        assert f"deploy/robots/{file.name}" in PAGE or file in BRIDGES, file.name


@pytest.mark.parametrize("page", [PAGE, README], ids=["robots.md", "README.md"])
def test_a_goal_is_asked_for_as_the_page_says(page: str) -> None:
    """Over a bridge that is a router."""
    [line] = re.findall(r"^(rfnav find .*?) *#", page, re.MULTILINE)
    _, *words = shlex.split(line)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    asked: list[dict[str, str]] = []

    def answer(query: zenoh.Query) -> None:
        assert query.payload is not None
        asked.append(json.loads(query.payload.to_string()))
        query.reply(query.key_expr, '{"accepted": true, "id": "a1", "how": "as it is"}')

    def there(query: zenoh.Query) -> None:
        query.reply(query.key_expr, "{}")

    setting = f"bus.connect=['{endpoint}']"
    with (
        zenoh.open(config) as robot,
        robot.declare_queryable("rfnav/goal", answer),
        robot.declare_queryable("rfnav/status", there),
    ):
        done = CliRunner().invoke(cli, [*words, "--no-wait", "--set", setting])
    assert [one["goal"] for one in asked] == [words[1]]
    assert (done.output, done.exit_code) == ("a1: as it is\n", 0)
