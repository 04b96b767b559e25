"""Drawings -> scenes, whole."""

import json
import math
import subprocess
import sys
from pathlib import Path

import pytest
from drawn import CUBE, MTL, ROOMS, WALLS, door, piece, room, save, tag, text, wall, xml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from places import ROOT, TESTS

from hil_sim.scenes.format import Scene, SceneError
from hil_sim.scenes.scene_file import load_scene, parse_scene
from hil_sim.scenes.sweethome.importer import Report, import_home

pytestmark = pytest.mark.slow  # whole drawings are read

REAL = TESTS / "refs" / "sweethome7.sh3d"


def imported(tmp_path: Path, *parts: str, **files: bytes) -> tuple[Scene, Report]:
    path = save(tmp_path / "home.sh3d", xml(*parts), files)
    return import_home(path, tmp_path / "out")


def test_the_plan_is_turned_y_up_in_metres(tmp_path: Path) -> None:
    scene, _ = imported(tmp_path, WALLS, ROOMS, door(400, 100, angle=math.pi / 2))
    assert scene.name == "home"
    assert (scene.walls[0].start, scene.walls[0].end) == ((0, 0), (8, 0))
    assert (scene.walls[1].start, scene.walls[1].end) == ((8, 0), (8, -4))
    assert [w.kind for w in scene.walls] == ["outer"] * 4 + ["inner"]
    assert [(r.name, r.type) for r in scene.rooms] == [
        ("Kitchen", "kitchen"), ("Bedroom", "bedroom")
    ]  # fmt: skip
    (hole,) = scene.doors
    assert sorted((hole.start, hole.end)) == [
        pytest.approx((4, -1.45)), pytest.approx((4, -0.55))
    ]  # fmt: skip
    assert hole.height_m == 2.05
    assert len(scene.spawn) == 2


def test_a_piece_keeps_its_place_size_and_clockwise_angle(tmp_path: Path) -> None:
    scene, report = imported(
        tmp_path, WALLS, ROOMS,
        piece("Sofa", 200, 100, angle=math.pi / 2, elevation=10, model="0/cube.obj"),
        **{"0/cube.obj": CUBE.encode(), "0/cube.mtl": MTL.encode()},
    )  # fmt: skip
    (sofa,) = scene.objects
    assert sofa.category == "sofa"
    assert sofa.position_m == (2.0, -1.0, 0.1)
    assert sofa.yaw_rad == pytest.approx(-math.pi / 2, abs=1e-4)
    assert sofa.size_m == (1.0, 0.5, 0.8)
    assert (tmp_path / "out" / sofa.mesh).is_file()
    assert report.categories == {"sofa": 1}


def test_groups_are_opened_and_hidden_or_outdoor_pieces_left(tmp_path: Path) -> None:
    inside = piece("Chair", 100, 100) + piece("Lamp", 120, 100, "light", power=0.5)
    group = tag("furnitureGroup", tag("furnitureGroup", inside, name="in"), name="out")
    unseen = tag("furnitureGroup", piece("Bed", 100, 200), name="unseen", visible="false")
    scene, report = imported(
        tmp_path, WALLS, ROOMS, group, unseen, piece("Desk", 100, 100, visible="false"),
        piece("Tree", 2000, 100), piece("Light", 100, 100, catalogId="eTeks#whiteLightSource"),
    )  # fmt: skip
    assert sorted(obj.category for obj in scene.objects) == ["chair", "lamp"]
    assert report.counts["hidden pieces left out"] == 2
    assert report.counts["pieces outside the rooms left out"] == 1


def test_front_doors_and_windows_stay_shut(tmp_path: Path) -> None:
    parts = (
        door(400, 200, angle=math.pi / 2), door(200, 400), door(600, 0, elevation=90),
        door(100, 100),
    )  # fmt: skip
    scene, report = imported(tmp_path, WALLS, ROOMS, *parts)
    assert len(scene.doors) == 1
    assert report.counts["windows left out"] == 1
    told = "\n".join(report.notes)
    assert "doorOrWindow[1] (Door): kept shut" in told
    assert "doorOrWindow[3] (Door): left out: it stands in no wall" in told


def test_a_wall_of_zero_length_is_told_and_left_out(tmp_path: Path) -> None:
    scene, report = imported(tmp_path, WALLS, wall(100, 50, 100, 50), ROOMS)
    assert len(scene.walls) == 5
    assert "wall[5]: left out: zero length at (1.00, -0.50) m" in report.notes


def test_a_low_wall_is_furnishing(tmp_path: Path) -> None:
    scene, _ = imported(tmp_path, WALLS, ROOMS, wall(100, 200, 200, 200, height=100))
    assert len(scene.walls) == 5
    (low,) = scene.objects
    assert (low.category, low.size_m) == ("other", pytest.approx((1.1, 0.1, 1.0)))


def test_rooms_nobody_drew_are_made_from_the_walls(tmp_path: Path) -> None:
    scene, report = imported(tmp_path, WALLS, piece("Bed", 600, 200), piece("Oven", 100, 200))
    assert sorted(r.type for r in scene.rooms) == ["bedroom", "kitchen"]
    assert any("made from the walls" in note for note in report.notes)
    scene, report = imported(tmp_path, wall(0, 0, 500, 0), wall(0, 0, 0, 400))
    assert len(scene.rooms) == 1
    assert any("one room around all walls" in note for note in report.notes)


def test_a_terrace_is_no_room(tmp_path: Path) -> None:
    outside = room("Terrasse", 0, 405, 795, 700)
    scene, report = imported(tmp_path, WALLS, ROOMS, outside, door(200, 400))
    assert (len(scene.rooms), scene.doors) == (2, ())
    assert any("outdoors" in note for note in report.notes)


def test_one_storey_is_imported(tmp_path: Path) -> None:
    def level(id: str, name: str, elevation: float) -> str:
        return tag("level", id=id, name=name, elevation=elevation, floorThickness=12, height=260)

    parts = (
        level("up", "Upstairs", 272), level("cellar", "Cellar", -250), level("ground", "Ground", 0),
        wall(0, 0, 600, 0, level="ground"), wall(0, 0, 0, 500, level="ground"),
        wall(0, 0, 300, 0, level="up"), piece("Bed", 100, 100, level="up"),
        piece("Sofa", 150, 100, level="ground"),
    )  # fmt: skip
    scene, report = imported(tmp_path, *parts)
    assert (len(scene.walls), [o.category for o in scene.objects]) == (2, ["sofa"])
    assert scene.wall_height_m == 2.6
    assert any("Cellar, Upstairs" in note for note in report.notes)
    path = save(tmp_path / "home.sh3d", xml(*parts))
    with pytest.raises(SceneError, match="none on this level"):
        import_home(path, tmp_path / "out", "Cellar")
    with pytest.raises(SceneError, match="there are: 'Upstairs', 'Cellar', 'Ground'"):
        import_home(path, tmp_path / "out", "Attic")


def test_texts_name_the_rooms_that_have_no_name(tmp_path: Path) -> None:
    bare = room("", 5, 5, 395, 395) + room("", 405, 5, 795, 395)
    texts = text("12 m²", 200, 150) + text("Küche", 200, 200) + text("Bath", 600, 200)
    scene, report = imported(tmp_path, WALLS, bare, texts, piece("Bed", 600, 100))
    assert [(r.name, r.type) for r in scene.rooms] == [("Küche", "kitchen"), ("Bath", "bathroom")]
    assert "room 'Küche': a kitchen by the text 'Küche' in it" in report.notes


def test_nothing_indoors_is_told(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="room: none on this level is indoors; draw one"):
        imported(tmp_path, WALLS, text("Patio", 200, 200), text("Garden", 600, 200))


def test_colours_of_floors_and_walls_are_kept(tmp_path: Path) -> None:
    painted = (
        wall(0, 0, 800, 0, rightSideColor="FF102030") + wall(800, 0, 800, 400)
        + wall(800, 400, 0, 400, rightSideColor="FF102030") + wall(0, 400, 0, 0)
    )  # fmt: skip
    scene, _ = imported(tmp_path, painted, room("Salon", 5, 5, 795, 395, floorColor="80FF8000"))
    assert (scene.rooms[0].floor, scene.rooms[0].wall) == ("#ff8000", "#102030")


@pytest.mark.parametrize(
    ("parts", "place"),
    [
        ((wall(0, 0, "NaN", 0),), "wall[0]: xEnd: is 'NaN', not a finite number"),
        ((wall(0, 0, 5, 0, thickness=-3),), "wall[0]: thickness: is -3, must be from 0.1"),
        ((wall(0, 0, 1e300, 0),), "wall[0]: xEnd: is 1e+300"),
        ((wall(0, 0, 20_000, 0),), "wall[0]: xEnd, yEnd: 200 m from the first wall"),
        ((WALLS, tag("wall", xStart=1, yStart=2)), "wall[5]: xEnd: missing"),
        ((WALLS, piece("Sofa", "here", 2)), "pieceOfFurniture[0]: x: is 'here', not a number"),
        ((WALLS, piece("Sofa", 1, 2, width=-4)), "pieceOfFurniture[0]: width: is -4"),
        ((WALLS, piece("S", 1, 2, modelRotation="1 0")), "modelRotation: is '1 0', not 9"),
        ((WALLS, piece("S", 1, 2, color="blue")), "color: is 'blue', not a colour"),
        ((WALLS, tag("room", tag("point", x=1))), "room[0].point[0]: y: missing"),
        ((ROOMS,), "wall: none on this level"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(
    tmp_path: Path, parts: tuple[str, ...], place: str
) -> None:
    with pytest.raises(SceneError) as caught:
        imported(tmp_path, *parts)
    assert place in str(caught.value)
    assert "home.sh3d: Home.xml" in str(caught.value)


VALUES = st.one_of(
    st.sampled_from(["nan", "inf", "-inf", "1e308", "-1e9", "0", "-0.0", "", "abc", "1,5", "true"]),
    st.floats(allow_nan=True).map(str),
    st.floats(-2000, 2000).map(str),
    st.text(max_size=8),
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_any_number_gives_a_scene_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    places = {
        "wall": ["xStart", "yEnd", "thickness", "height", "arcExtent", "leftSideColor"],
        "pieceOfFurniture": ["x", "y", "elevation", "angle", "width", "depth", "height", "pitch",
                             "roll", "modelRotation", "color", "modelMirrored"],
        "doorOrWindow": ["x", "y", "angle", "width", "depth", "height", "elevation", "wallLeft",
                         "wallWidth", "wallTop", "wallHeight"],
    }  # fmt: skip
    element = data.draw(st.sampled_from(sorted(places)))
    changed = {key: data.draw(VALUES) for key in data.draw(st.sets(
        st.sampled_from(places[element]), min_size=1, max_size=3))}  # fmt: skip
    more = {kind: changed if kind == element else {} for kind in places}
    lone = {"xStart": 100, "yStart": 100, "xEnd": 300, "yEnd": 200, "thickness": 10}
    bed = {"name": "Bed", "x": 200, "y": 200, "width": 90, "depth": 200, "height": 50, "model": "0"}
    hole = {"name": "Door", "x": 400, "y": 200, "width": 90, "depth": 12, "height": 205}
    parts = (
        WALLS,
        ROOMS,
        tag("wall", **{**lone, **more["wall"]}),
        tag("pieceOfFurniture", **{**bed, **more["pieceOfFurniture"]}),
        tag("doorOrWindow", **{**hole, "angle": 1.57, **more["doorOrWindow"]}),
    )
    folder = tmp_path_factory.mktemp("any")
    lines: list[str] = []
    try:
        scene, _ = imported(folder, *(clean(part) for part in parts), **{"0": CUBE.encode()})
    except SceneError as error:
        lines.append(str(error))
    else:
        assert scene.rooms
    assert not any("\n" in line for line in lines)


def clean(text: str) -> str:
    """Without what XML cannot hold at all."""
    return "".join(c for c in text if c in "\t\n\r" or 0x20 <= ord(c) < 0xD800)


def test_a_home_saved_by_sweet_home_3d(tmp_path: Path) -> None:
    scene, report = import_home(REAL, tmp_path)
    assert report.counts == {
        "walls": 5, "rooms": 2, "doors": 1, "pieces": 5, "windows left out": 1
    }  # fmt: skip
    assert report.rooms == {"Salon": "living room", "Bureau": "study"}
    assert list(report.categories) == ["bookcase", "desk", "nightstand", "sofa", "trash can"]
    assert not any("box" in note for note in report.notes)
    sofa = next(obj for obj in scene.objects if obj.category == "sofa")
    assert sofa.position_m[:2] == (1.4, -0.95)


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "hil_sim", "import", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_command_says_what_it_did_and_what_is_next(tmp_path: Path) -> None:
    out, summary = tmp_path / "out", tmp_path / "summary.json"
    done = run(REAL, "--out", out, "--json", summary)
    assert (done.returncode, done.stderr) == (0, "")
    assert "the robot can reach every room" in done.stdout
    assert f"hil-sim show {out / 'scene.json'}" in done.stdout
    assert load_scene(out / "scene.json").walls
    table = json.loads(summary.read_text())
    assert table["reachable"] == {"Salon": True, "Bureau": True}
    assert table["counts"]["doors"] == 1


def test_rooms_the_robot_cannot_reach_are_named(tmp_path: Path) -> None:
    path = save(tmp_path / "home.sh3d", xml(WALLS, ROOMS, piece("Bed", 600, 50)))
    done = run(path, "--out", tmp_path / "out")
    assert done.returncode == 0
    assert "the robot cannot reach: Bedroom" in done.stdout
    assert len(load_scene(tmp_path / "out" / "scene.json").spawn) == 1


def test_a_home_without_goals_suggests_no_search(tmp_path: Path) -> None:
    path = save(tmp_path / "home.sh3d", xml(WALLS, ROOMS, piece("Box", 600, 200)))
    done = run(path, "--out", tmp_path / "out", "--no-check")
    assert done.returncode == 0
    assert "pieces: other 1" in done.stdout
    assert "hil-sim demo" not in done.stdout
    assert "no piece here can be a goal: place or rename one" in done.stdout
    path = save(tmp_path / "home.sh3d", xml(WALLS, ROOMS, piece("Vase", 600, 200)))
    done = run(path, "--out", tmp_path / "out", "--no-check")
    assert done.stdout.endswith('--goal "vase"\n')


def test_an_error_is_one_line_and_exit_2(tmp_path: Path) -> None:
    path = tmp_path / "home.sh3d"
    path.write_text("not a zip")
    done = run(path, "--out", tmp_path / "out")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert str(path) in done.stderr
    done = run(REAL, "--out", path / "below-a-file")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


def test_the_scene_in_the_documentation_can_be_read() -> None:
    text = (ROOT / "docs" / "own-home.md").read_text(encoding="utf-8")
    block = text.split("```json\n")[1].split("```")[0]
    scene = parse_scene(json.loads(block), "own-home.md", {"builtin:box"})
    assert (len(scene.walls), len(scene.rooms), len(scene.doors)) == (5, 2, 1)
