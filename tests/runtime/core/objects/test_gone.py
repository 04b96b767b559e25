"""What was taken away: its place has been seen through, and it leaves the map. What is hidden."""

from dataclasses import replace

import numpy as np
import pytest
from boxes import CAMERA, HERE, MOUNT, Box, depth_of, seen, wall

from runtime.core.mapping.grid import NavigationMap
from runtime.core.objects.gone import LOOKS, NEAR_M, hidden, seen_through
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.objects.semantic_map import SemanticMap, place
from runtime.core.types import Detections, Observation, Pose

CHAIR = Box(2.0, 0.0, (0.4, 0.4), 0.0, 0.9)
WALL = wall(4.5)
OUTLINE = np.zeros((3, 2))


def detected(*boxes_px: tuple[float, float, float, float]) -> Detections:
    n = len(boxes_px)
    return Detections(
        np.array(boxes_px, np.float32).reshape(n, 4),
        np.full(n, 0.9, np.float32),
        np.zeros(n, np.int32),
        np.zeros((n, 0), np.float32),
        np.zeros(0, np.float32),
    )


IN_VIEW, NOTHING = detected((277, 237, 363, 410)), detected()


def known(thing: Box = CHAIR) -> tuple[SemanticMap, NavigationMap]:
    """A chair that was seen once."""
    grid = NavigationMap.around(HERE, 0.18)
    semantic = SemanticMap.empty(("chair",), (), grid.frame)
    place(semantic, grid, seen(depth_of(WALL, thing)), IN_VIEW, OUTLINE, MOUNT)
    assert len(semantic.instances) == 1
    return semantic, grid


def look(
    semantic: SemanticMap, grid: NavigationMap, obs: Observation, times: int,
    there: Detections = NOTHING,
) -> None:  # fmt: skip
    for _ in range(times):
        place(semantic, grid, obs, there, OUTLINE, MOUNT)


def test_it_goes_after_some_looks_and_is_no_candidate_any_more():
    semantic, grid = known()
    away = seen(depth_of(WALL))
    look(semantic, grid, away, LOOKS - 1)
    assert semantic.called("chair")
    look(semantic, grid, away, 1)
    assert not semantic.instances
    assert not semantic.called("chair")
    assert len(semantic.places) == 0


def test_a_look_that_sees_it_begins_the_count_anew():
    semantic, grid = known()
    away = seen(depth_of(WALL))
    look(semantic, grid, away, LOOKS - 1)
    look(semantic, grid, seen(depth_of(WALL, CHAIR)), 1, IN_VIEW)
    look(semantic, grid, away, LOOKS - 1)
    assert semantic.called("chair")


def test_what_a_detector_misses_stays():
    semantic, grid = known()
    look(semantic, grid, seen(depth_of(WALL, CHAIR)), 5 * LOOKS)
    assert semantic.instances


def test_what_is_hidden_stays():
    semantic, grid = known()
    look(semantic, grid, seen(depth_of(WALL, wall(1.2))), 5 * LOOKS)
    assert semantic.instances


FAR_CHAIR, FAR_BOX = Box(3.6, 0.0, (0.4, 0.4), 0.0, 0.9), detected((297, 237, 344, 345))


@pytest.mark.parametrize(
    ("chair", "box", "before", "missed"),
    [
        (CHAIR, IN_VIEW, (), True),
        (CHAIR, IN_VIEW, (wall(1.6),), False),  # the other side of which it stands against
        (CHAIR, IN_VIEW, (Box(1.6, 0.0, (0.1, 3.0), 0.0, 0.3),), True),  # a plinth
        (FAR_CHAIR, FAR_BOX, (), True),
        (FAR_CHAIR, FAR_BOX, (wall(3.2),), False),
    ],
)
def test_what_a_wall_covers_is_not_missed(
    chair: Box, box: Detections, before: tuple[Box, ...], missed: bool
):
    grid = NavigationMap.around(HERE, 0.18)
    semantic = SemanticMap.empty(("chair",), (), grid.frame)
    place(semantic, grid, seen(depth_of(WALL, chair)), box, OUTLINE, MOUNT)
    (thing,) = semantic.instances.values()
    known = thing.odds_of("chair")
    look(semantic, grid, seen(depth_of(WALL, chair, *before)), 3)
    assert (thing.odds_of("chair") < known) is missed


def test_nothing_is_told_where_nothing_is_read():
    semantic, grid = known()
    look(semantic, grid, seen(depth_of(wall(4.5, glass=True), wall(2.4, glass=True))), 5 * LOOKS)
    assert semantic.instances


@pytest.mark.parametrize("value", [65.535, 1e30, np.inf, np.nan, -1.0])
def test_nothing_is_told_by_what_is_no_distance(value: float):
    """A black screen gives no depth, for which some cameras tell the most that they can."""
    semantic, grid = known()
    obs = seen(np.full_like(depth_of(WALL), value))
    look(semantic, grid, obs, 3 * LOOKS)
    assert semantic.instances


def test_nothing_is_told_from_afar():
    semantic, _ = known()
    obs = seen(depth_of(WALL))
    assert seen_through(semantic.instances.values(), obs, MOUNT)
    back = replace(obs, pose=Pose(-(NEAR_M - 1.7), 0.0, 0.0))
    assert not seen_through(semantic.instances.values(), back, MOUNT)


def test_a_gap_in_the_middle_is_no_gap_all_over():
    """Between two legs the wall is seen; the rest of it stands."""
    sides = [Box(2.0, y, (0.4, 0.12), 0.0, 0.9) for y in (-0.14, 0.14)]
    semantic, grid = known()
    look(semantic, grid, seen(depth_of(WALL, *sides)), 5 * LOOKS)
    assert semantic.instances


def test_what_seems_to_be_there_again_is_no_news():
    semantic, grid = known()
    away = seen(depth_of(WALL))
    look(semantic, grid, away, LOOKS)
    look(semantic, grid, seen(depth_of(WALL, CHAIR)), 1, IN_VIEW)
    look(semantic, grid, away, LOOKS)
    (thing,) = semantic.instances.values()
    assert thing.evidence["chair"].rejections == 1
    assert not semantic.catalogue.sure


def test_what_was_rejected_is_still_known_as_what_it_is_not():
    semantic, grid = known()
    (thing,) = semantic.instances.values()
    thing.evidence["chair"].rejections = 1
    look(semantic, grid, seen(depth_of(WALL)), 3 * LOOKS)
    assert list(semantic.instances.values()) == [thing]
    assert thing.evidence["chair"].rejections == 2  # once more


def test_where_nothing_was_missed_nothing_is_asked():
    assert (
        seen_through(
            [],
            Observation(
                0, np.zeros((1, 1, 3), np.uint8), np.zeros((1, 1), np.float32), HERE, CAMERA
            ),
            MOUNT,
        )
        == []
    )


LOW_WALL = Box(1.4, 0.0, (0.1, 3.0), 0.0, 0.3)


@pytest.mark.parametrize(
    ("x_m", "y_m", "before", "is_hidden"),
    [
        (2.0, 0.0, (), False),
        (2.0, 0.0, (wall(1.2),), True),
        (2.0, 0.0, (LOW_WALL,), False),  # but its lowest part
        (0.6, 0.0, (), True),  # below the image
        (0.0, 2.0, (), True),  # beside it
        (NEAR_M + 0.3, 0.0, (wall(1.2),), False),  # too far away to ask
        (2.0, 0.0, (wall(1.2, glass=True),), False),  # nothing is read: nothing is told
    ],
)
def test_what_is_near_is_hidden_where_its_place_is_not_in_the_image(
    x_m: float, y_m: float, before: tuple[Box, ...], is_hidden: bool
):
    stool = Box(x_m, y_m, (0.4, 0.4), 0.0, 0.6)
    side = np.linspace(-0.15, 0.15, 7)
    cells = np.stack(np.meshgrid(x_m + side, y_m + side), -1).reshape(-1, 2)
    thing = Instance(7, {"stool": Evidence(4.0)}, (x_m, y_m), 0.3, cells, 0.0, 0.6)
    obs = seen(depth_of(WALL, stool, *before))
    assert hidden(thing, obs, MOUNT) is is_hidden
