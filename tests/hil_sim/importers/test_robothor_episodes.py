"""Official episodes into ours."""

import gzip
import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from places import SHARED

from hil_sim.importers.robothor_episodes import official_episodes
from hil_sim.scenes.robothor.metadata import MetadataError

EPISODES = SHARED / "robothor/episodes"


def row(**changes: Any) -> dict[str, Any]:
    points = [(3.75, -2.25), (4.75, -2.25), (4.75, -4.25)]
    return {
        "id": "FloorPlan_Val1_1_AlarmClock_0",
        "scene": "FloorPlan_Val1_1",
        "object_type": "AlarmClock",
        "initial_position": {"x": 3.75, "y": 0.9, "z": -2.25},
        "initial_orientation": 150,
        "initial_horizon": 30,
        "shortest_path": [{"x": x, "y": 0.0, "z": z} for x, z in points],
        "shortest_path_length": 3.0,
    } | changes


def write(folder: Path, rows: Any, name: str = "FloorPlan_Val1_1") -> Path:
    path = folder / f"{name}.json.gz"
    with gzip.open(path, "wt") as file:
        json.dump(rows, file)
    return path


def test_an_episode_in_our_frame_and_words(tmp_path):
    write(tmp_path, [row()])
    [episode] = official_episodes(tmp_path)
    assert (episode.id, episode.scene) == ("FloorPlan_Val1_1_AlarmClock_0", "FloorPlan_Val1_1")
    assert episode.goal == "alarm clock"
    assert (episode.start.x_m, episode.start.y_m) == (3.75, -2.25)
    # 150 degrees clockwise from +z: right and back.
    assert math.cos(episode.start.yaw_rad) == pytest.approx(0.5, abs=1e-3)
    assert math.sin(episode.start.yaw_rad) == pytest.approx(-math.sqrt(0.75), abs=1e-3)
    assert episode.shortest_path_m == 3.0
    assert episode.horizon_rad == pytest.approx(math.radians(30), abs=1e-4)


def test_scenes_limit_and_seed_choose(tmp_path):
    write(tmp_path, [row(id=f"a{i}") for i in range(20)])
    other = row(scene="FloorPlan_Val2_3")
    write(tmp_path, [other | {"id": f"b{i}"} for i in range(20)], "FloorPlan_Val2_3")
    everything = official_episodes(tmp_path, ())
    assert [e.id for e in everything] == [f"a{i}" for i in range(20)] + [f"b{i}" for i in range(20)]
    assert {e.id[0] for e in official_episodes(tmp_path, {"FloorPlan_Val2_3"})} == {"b"}
    drawn = official_episodes(tmp_path, limit=7, seed=3)
    assert drawn == official_episodes(tmp_path, limit=7, seed=3)
    assert drawn != official_episodes(tmp_path, limit=7, seed=4)
    assert len(set(drawn)) == 7


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"id": None}, "id: missing"),
        ({"scene": "FloorPlan_Val9_1"}, "scene: 'FloorPlan_Val9_1'"),
        ({"object_type": "Zebra"}, "object_type: 'Zebra'"),
        ({"initial_position": [1, 2, 3]}, "initial_position: missing or not an object"),
        ({"initial_position": {"x": 1, "z": "2"}}, "initial_position: z: missing or not a finite"),
        ({"initial_orientation": float("nan")}, "initial_orientation: missing or not a finite"),
        ({"initial_horizon": True}, "initial_horizon: missing or not a finite"),
        ({"shortest_path": [1.0]}, "shortest_path: missing or not a list of points"),
        ({"shortest_path": [{"x": 1, "y": 0}]}, "shortest_path: z: missing"),
    ],
)
def test_a_bad_episode_is_named_in_a_line(tmp_path, changes, says):
    path = write(tmp_path, [row(), row(**changes)])
    with pytest.raises(MetadataError) as error:
        official_episodes(tmp_path)
    text = str(error.value)
    assert text.startswith(f"{path}: episodes[1]: ")
    assert says in text
    assert "\n" not in text


def test_bad_files_and_folders_are_named(tmp_path):
    with pytest.raises(MetadataError, match="no such folder"):
        official_episodes(tmp_path / "none")
    with pytest.raises(MetadataError, match=r"holds no \*.json.gz"):
        official_episodes(tmp_path)
    path = write(tmp_path, {"episodes": []})
    with pytest.raises(MetadataError, match=r"Val1_1.json.gz: must hold a list"):
        official_episodes(tmp_path)
    path.write_bytes(gzip.compress(b'[{"id": 1')[:-4])
    with pytest.raises(MetadataError, match=r"Val1_1.json.gz: not a gzipped JSON"):
        official_episodes(tmp_path)
    write(tmp_path, [row()])
    with pytest.raises(MetadataError, match="no official episodes of these scenes"):
        official_episodes(tmp_path, {"FloorPlan_Val3_5"})


@given(st.recursive(st.none() | st.integers() | st.text(max_size=4),
                    lambda inner: st.lists(inner, max_size=3)
                    | st.dictionaries(st.sampled_from(sorted(row())), inner, max_size=8),
                    max_leaves=12))  # fmt: skip
def test_whatever_json_is_refused_with_an_error_of_ours(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("any")
    write(folder, data)
    with pytest.raises(MetadataError):
        official_episodes(folder)


@pytest.mark.skipif(not EPISODES.is_dir(), reason="the official episodes are not here")
def test_the_official_val_episodes_are_all_read():
    episodes = official_episodes(EPISODES / "val")
    assert len(episodes) == len({e.id for e in episodes}) == 1200
    assert sum(e.shortest_path_m == 0 for e in episodes) == 77
    assert len({e.goal for e in episodes}) == 12
