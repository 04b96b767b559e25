"""The kernels of the semantic map are to equal what NumPy and OpenCV compute a step at a time."""

import math

import cv2
import numpy as np
import numpy_things
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from runtime.core.geometry import GridFrame, map_to_optical, optical_to_base, project
from runtime.core.kernels import objects as kernels
from runtime.core.objects.depth_segments import STRIDE, things_in
from runtime.core.objects.footprints import STRAYS
from runtime.core.types import Intrinsics, Mount, Observation, Pose

FRAME = GridFrame(-6.0, -5.0, 0.05, 240, 200)
CORNER = FRAME.x0_m, FRAME.y0_m, FRAME.resolution_m
LENS = Intrinsics(60.0, 61.0, 31.0, 25.0, 64, 48)
UNKNOWN = [0.0, math.nan, math.inf, -math.inf, -1.0]


@st.composite
def views(draw):
    """A picture of walls and rectangles, some unknown or noisy, seen from anywhere."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    rows, cols = 4 * draw(st.integers(1, 40)), 4 * draw(st.integers(1, 40))
    depth = np.full((rows, cols), rng.uniform(1, 6), np.float32)
    for _ in range(draw(st.integers(0, 8))):
        top, left = rng.integers(0, rows), rng.integers(0, cols)
        part = depth[top : top + rng.integers(1, rows + 1), left : left + rng.integers(1, cols + 1)]
        part[:] = rng.uniform(0.3, 5) + rng.uniform(-0.02, 0.02) * np.arange(part.shape[1])
    noise = draw(st.sampled_from([0.0, 0.01, 0.1]))
    depth += (noise * rng.normal(size=depth.shape)).astype(np.float32)
    lost = rng.random(depth.shape) < draw(st.sampled_from([0.0, 0.05, 0.6]))
    depth[lost] = rng.choice(np.array(UNKNOWN, np.float32), int(lost.sum()))
    lens = Intrinsics(rng.uniform(30, 200), rng.uniform(30, 200), cols / 2, rows / 2, cols, rows)
    pose = Pose(*rng.uniform(-2, 2, 2).tolist(), rng.uniform(-3.1, 3.1))
    mount = Mount(*rng.uniform(0, 0.3, 2).tolist(), rng.uniform(0.2, 1.2), 0.02, rng.uniform(-1, 1))
    return Observation(0, np.zeros((rows, cols, 3), np.uint8), depth, pose, lens), mount


@st.composite
def boxes(draw):
    """Rows as `things` takes them: in the image, partly or wholly beside it, or of no size."""
    count, ends = draw(st.integers(0, 5)), st.integers(0, 45)
    known = st.one_of(st.just(math.nan), st.floats(0.25, 6.0, width=32))
    rows = [
        (draw(ends), draw(ends), draw(ends), draw(ends), draw(known), draw(st.floats(0, 2)))
        for _ in range(count)
    ]
    return np.array(rows, np.float64).reshape(count, 6)


@st.composite
def blocks(draw):
    """Blocks before and behind one another, all at a height of things, and boxes about as large."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    rows, cols = rng.integers(4, 24, 2)
    depth = np.full((rows, cols), 4.0, np.float32)
    asked = []
    for _ in range(rng.integers(1, 7)):
        top, left = rng.integers(0, rows), rng.integers(0, cols)
        high, wide = rng.integers(1, 10, 2)
        part = depth[top : top + high, left : left + wide]
        part[:] = rng.choice([0.0, 1.5, 2.0, 2.5]) + rng.choice([0.0, 0.04, 0.09]) * np.arange(
            part.shape[1]
        )
        box = np.array([top, left, top + high, left + wide]) + rng.integers(-2, 3, 4)
        known = math.nan if rng.random() < 0.8 else rng.uniform(1, 3)
        asked.append([*np.maximum(box, 0), known, rng.uniform(0, 1)])
    lens = Intrinsics(4000.0, 4000.0, cols * 2, rows * 2, 4 * int(cols), 4 * int(rows))
    image = np.repeat(np.repeat(depth, 4, 0), 4, 1)
    obs = Observation(0, np.zeros((0, 0, 3), np.uint8), image, Pose(0, 0, 0.5), lens)
    return (obs, Mount()), np.array(asked, np.float64)


@settings(max_examples=500)
@given(st.one_of(st.tuples(views(), boxes()), blocks()))
def test_things_are_what_is_found_a_step_at_a_time(asked_of):
    (obs, mount), asked = asked_of
    found = things_in(obs, asked, mount, FRAME)
    expected = numpy_things.things_in(obs, asked, mount, FRAME)
    for one, other in zip(found, expected, strict=True):
        assert (one is None) == (other is None)
        if one is not None and other is not None:
            assert one[:-1] == other[:-1]
            assert np.array_equal(one.cells_xy, other.cells_xy)


def whole_image(depth: np.ndarray) -> np.ndarray:
    return np.array([[0, 0, *np.ceil(np.array(depth.shape) / STRIDE), math.nan, 1.0]])


@pytest.mark.parametrize("shape", [(480, 640), (481, 643), (5, 4)])
def test_a_thing_as_large_as_the_image_is_one(shape):
    depth = np.full(shape, 2.0, np.float32)
    lens = Intrinsics(900.0, 900.0, shape[1] / 2, shape[0] / 2, shape[1], shape[0])
    obs = Observation(0, np.zeros((*shape, 3), np.uint8), depth, Pose(0, 0, 0), lens)
    found = things_in(obs, whole_image(depth), Mount(), FRAME)
    expected = numpy_things.things_in(obs, whole_image(depth), Mount(), FRAME)
    assert [f and f[:-1] for f in found] == [e and e[:-1] for e in expected]


def test_garbage_depth_is_no_thing():
    """A level row of it would lie under a box of the map as wide as a town."""
    depth = np.full((480, 640), 2.0, np.float32)
    depth[238:243] = 2e4
    lens = Intrinsics(400.0, 400.0, 320.0, 240.5, 640, 480)
    obs = Observation(0, np.zeros((0, 0, 3), np.uint8), depth, Pose(0, 0, 0.5), lens)
    asked = np.array([[0, 0, 120, 160, 2e4, 1.0], [0, 0, 120, 160, 2.0, 1.0]])
    garbage, thing = things_in(obs, asked, Mount(), FRAME)
    assert garbage is None
    assert thing is not None
    assert numpy_things.things_in(obs, asked[:1], Mount(), FRAME) == [None]


def test_what_is_nowhere_on_a_map_is_no_thing():
    depth = np.full((48, 64), 2.0, np.float32)
    asked = np.array([[0.0, 0.0, 12.0, 16.0, 2.0, 1.0]])
    for x_m, there in ((3.0, True), (1e12, False)):
        obs = Observation(0, np.zeros((0, 0, 3), np.uint8), depth, Pose(x_m, 0, 0), LENS)
        (found,) = things_in(obs, asked, Mount(), FRAME)
        assert (found is not None) == there


def cells(most: int = 40):
    """(N, 2) m, few different."""
    return arrays.arrays(np.float64, st.tuples(st.integers(1, most), st.just(2)),
                         elements=st.floats(-2, 2, width=16))  # fmt: skip


@given(cells(200), cells(), st.booleans(), st.sampled_from([1.0, 1000.0]))
def test_joined_cells_are_those_under_both_without_strays(some, others, settled, scale):
    some, others = scale * some, scale * others
    under = numpy_things.footprint(FRAME, np.concatenate([some, others]))
    kept = numpy_things.without_strays(under)
    told = kernels.joined_cells(some, others, CORNER, STRAYS, settled)
    assert told is not None or settled
    if told is not None:
        packed, whole, x, y = told
        assert np.array_equal(np.frombuffer(packed).reshape(-1, 2), kept)
        assert whole == (len(kept) == len(under))
        assert (x, y) == tuple(np.median(kept, axis=0))


@given(cells(), cells())
def test_settled_cells_are_kept_where_there_are_no_others(some, others):
    settled = numpy_things.footprint(FRAME, some)
    both = numpy_things.footprint(FRAME, np.concatenate([settled, others]))
    told = kernels.joined_cells(settled, others, CORNER, STRAYS, True)
    assert (told is None) == np.array_equal(both, settled)


@given(cells(), cells(), st.floats(-2, 2), st.floats(-2, 2))
def test_the_gap_is_from_a_point_to_the_nearest_cell(one, other, x, y):
    at, beside = (x, y), (y, 0.25)
    least = min(np.hypot(*(one - beside).T).min(), np.hypot(*(other - at).T).min())
    assert kernels.cells_gap(one, at, other, beside) == least


@given(cells())
def test_the_extent_is_along_both_axes(some):
    assert kernels.cells_extent(some) == tuple(np.ptp(some, axis=0))


@given(st.integers(0, 400), st.integers(1, 60), st.integers(0, 10**6))
def test_values_by_rank_are_those_in_order(many: int, few: int, seed: int):
    """By the height of things whose points are as many, or mostly the same."""
    rng = np.random.default_rng(seed)
    rows, cols = few, many + 6
    depth = np.repeat(np.repeat(rng.choice(rng.uniform(1, 1.3, few), (rows, cols)), 4, 0), 4, 1)
    lens = Intrinsics(400.0, 400.0, cols * 2.0, rows * 2.0, cols * 4, rows * 4)
    blank = np.zeros((0, 0, 3), np.uint8)
    obs = Observation(0, blank, depth.astype(np.float32), Pose(0, 0, 0), lens)
    asked = np.array([[0, 0, rows, cols, 1.15, 9.0]])
    (found,) = things_in(obs, asked, Mount(), FRAME)
    (expected,) = numpy_things.things_in(obs, asked, Mount(), FRAME)
    assert (found and found[:-1]) == (expected and expected[:-1])


def table(count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    places = np.zeros((7, count + 3))
    for n in range(count):
        xy, z_m = rng.uniform(-4, 4, 2), rng.uniform(0, 2)
        some = xy + rng.normal(0, 0.3, (rng.integers(1, 9), 2))
        kernels.put_place(places, n, tuple(xy.tolist()), z_m, some)
        expected = [*xy, z_m, *some.min(axis=0), *some.max(axis=0)]
        assert places[:, n].tolist() == expected
    return places


def outside(at, low, high):
    """How far from a range."""
    return np.maximum(0, np.maximum(low - at, at - high))


@given(st.integers(0, 80), cells(), st.floats(0, 1), st.integers(0, 10**6))
def test_near_places_are_the_nearest_first(count: int, some, within_m: float, seed: int):
    places, names = table(count, seed), list(range(100, 100 + count))
    at = (0.5, -0.25)
    found = kernels.near_places(places, names, at, some, within_m)
    assert found == sorted(found)
    x, y, _, *ends = places[:, :count]
    low, high = some.min(axis=0), some.max(axis=0)
    gaps = [
        np.hypot(x - at[0], y - at[1]),
        np.hypot(*(outside(at[k], ends[k], ends[k + 2]) for k in (0, 1))),
        np.hypot(outside(x, low[0], high[0]), outside(y, low[1], high[1])),
    ]
    least = np.min(gaps, axis=0)
    assert {id for _, id in found} >= {names[n] for n in np.flatnonzero(least < within_m - 1e-9)}
    for gap_m, id in found:
        assert gap_m == pytest.approx(least[id - 100], abs=1e-9)
        assert gap_m <= within_m + 1e-9


@given(st.integers(0, 300), st.floats(-3, 3), st.floats(-0.4, 0.4), st.integers(0, 10**6))
def test_in_plain_view_is_what_is_in_the_image_and_not_hidden(
    count: int, yaw: float, pitch: float, seed: int
):
    rng = np.random.default_rng(seed)
    places, names = table(count, seed), list(range(count))
    depth = rng.choice(np.array([0, 0.5, 2, 4, np.nan, np.inf], np.float32), (48, 64))
    depth[:, : rng.integers(0, 64)] = rng.choice(np.array([0, 1.5, 3.3], np.float32))
    pose, mount = Pose(0.3, -0.2, yaw), Mount(0.1, 0.02, 0.9, 0.0, pitch, 0.1)
    turn = optical_to_base(mount).ravel().tolist()
    lens = (
        pose.x_m, pose.y_m, math.cos(yaw), math.sin(yaw), mount.x_m, mount.y_m, mount.z_m, *turn,
        LENS.fx, LENS.fy, LENS.cx, LENS.cy, 1.2, 4.0, 5.0, 0.12, 0.08, 0.6,
    )  # fmt: skip
    expected = []
    optical = map_to_optical(places[:3, :count].T, pose, mount)
    for n, at in enumerate(optical):
        if not 1.2 <= at[2] <= 4.0 or math.dist(places[:2, n], (0.3, -0.2)) > 5.0:
            continue
        ((u, v),) = project(at[None], LENS)
        if not (0.12 * 64 < u < 0.88 * 64 and 0.08 * 48 < v < 0.92 * 48):
            continue
        r, c = (np.clip(int(p) + np.arange(-4, 5), 0, n - 1) for p, n in ((v, 48), (u, 64)))
        known = depth[np.ix_(r, c)][depth[np.ix_(r, c)] > 0]
        if known.size and np.median(known) >= at[2] - 0.6:
            expected.append(n)
    assert kernels.in_plain_view(places, names, depth, lens) == expected


@given(st.integers(1, 30), st.integers(0, 10**6))
def test_a_cosine_is_that_of_the_rows(size: int, seed: int):
    a, b = np.random.default_rng(seed).normal(size=(2, size)).astype(np.float32)
    wide, other = a.astype(float), b.astype(float)
    expected = wide @ other / np.linalg.norm(wide) / np.linalg.norm(other)
    assert kernels.cosine(a, b) == pytest.approx(expected, abs=1e-12)
    assert math.isnan(kernels.cosine(a, b[:-1]))
    assert math.isnan(kernels.cosine(np.zeros_like(a), b))


@given(st.integers(0, 20), st.integers(0, 20), st.floats(0, 1, width=32), st.integers(0, 10**6))
def test_a_number_is_added_where_a_mask_says(rows: int, cols: int, value: float, seed: int):
    rng = np.random.default_rng(seed)
    whole = rng.random((rows + 3, cols + 2), np.float32)
    mask = rng.random((rows, cols)) < 0.5
    expected = whole.copy()
    expected[2 : rows + 2, 1 : cols + 1][mask] += np.float32(value)
    kernels.add_where(whole[2 : rows + 2, 1 : cols + 1], mask, value)
    assert np.array_equal(whole, expected)


@given(cells(), st.floats(0, 3))
def test_an_outline_is_shortened_toward_its_first_point(outline, reach_m: float):
    packed, *ends = kernels.shortened(outline, reach_m)
    found = np.frombuffer(packed).reshape(-1, 2)
    offset = outline - outline[0]
    share = np.minimum(1.0, reach_m / np.maximum(np.hypot(*offset.T), 1e-6))
    assert np.array_equal(found, outline[0] + offset * share[:, None])
    assert ends == [*found.min(axis=0), *found.max(axis=0)]


@pytest.mark.parametrize(("high", "wide"), [(1, 1), (2, 2), (2, 1), (3, 2), (4, 4), (6, 8), (9, 7)])
@given(st.integers(0, 10**6), st.integers(1, 255))
@settings(max_examples=10)
def test_sharpness_is_opencvs(high: int, wide: int, seed: int, most: int):
    rows, cols = 12, 16
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, most, (rows * high, cols * wide, 3), np.uint8, endpoint=True)
    small = cv2.resize(rgb, (cols, rows), interpolation=cv2.INTER_AREA)
    edges = cv2.Laplacian(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), cv2.CV_16S)
    found = kernels.sharpness(rgb.reshape(len(rgb), -1), rows, cols)
    assert found == float(np.abs(edges).mean())
