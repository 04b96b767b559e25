"""A search: where its camera is, and what a goal may not ask for."""

from pathlib import Path

import numpy as np
import pytest
from apartment import INTRINSICS, MOUNT, NO_DETECTIONS, TWO_ROOMS, Apartment
from fake_models import FakeModels

from runtime.config import load
from runtime.core.geometry import rays
from runtime.core.types import Mount, Observation, Pose
from runtime.errors import ConfigError
from runtime.loops.search import Search, understand

NODDING = Mount(z_m=0.93, pitch_rad=0.12)


def nodded(obs: Observation) -> Observation:
    """An empty floor as the camera sees it when it nods."""
    table = rays(INTRINSICS, NODDING, 1)
    depth = np.where(table.up < 0, -NODDING.z_m / np.minimum(table.up, -1e-6), 0)
    depth = np.where(depth <= 5.0, depth, 0).astype(np.float32)
    return Observation(obs.stamp_ns, obs.rgb, depth, obs.pose, obs.intrinsics, NODDING)


def free_cells(tmp_path: Path, mount: str) -> int:
    home = Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0))
    models = FakeModels(home)

    def configure(more):
        return load(None, [f"camera.mount='{mount}'", *more])

    search = Search.begin(understand({"goal": "bed", "log_dir": str(tmp_path)}, models, configure))
    world = search.perceive(nodded(home.observe()), NO_DETECTIONS, models)
    search.end("seen")
    models.panel.close()
    assert world.lens is not None
    lens = world.lens[1]
    if mount == "fixed":
        assert (lens.z_m, lens.pitch_rad) == (MOUNT.z_m, 0.0)
    else:
        assert lens.z_m == pytest.approx(NODDING.z_m, abs=0.01)
        assert lens.pitch_rad == pytest.approx(NODDING.pitch_rad, abs=0.01)
    return int(world.map.free.sum())


def test_the_floor_is_kept_where_the_mount_is_known_by_the_frame(tmp_path: Path) -> None:
    fixed, floor, tf = (free_cells(tmp_path, mount) for mount in ("fixed", "floor", "tf"))
    assert tf > 5 * fixed
    assert floor == pytest.approx(tf, rel=0.02)


def test_tf_does_not_come_with_a_goal(tmp_path: Path) -> None:
    models = FakeModels(Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0)))
    body = {"goal": "bed", "log_dir": str(tmp_path), "settings": ["camera.mount='tf'"]}
    with pytest.raises(ConfigError, match=r"^camera.mount: tf is read from the start or not"):
        understand(body, models, lambda more: load(None, more))
    models.panel.close()
    assert models.asked == []
