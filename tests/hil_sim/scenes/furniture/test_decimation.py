"""Fewer triangles, the same shape."""

import numpy as np
import pytest

from hil_sim.scenes.furniture.decimation import simplify
from hil_sim.scenes.furniture.meshes import TRIANGLES


def test_a_dense_mesh_becomes_light_and_keeps_its_shape():
    n = 80
    u, v = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, n), indexing="ij")
    xyz = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)
    sphere = np.concatenate([xyz.reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2)], axis=1)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    triangles = np.concatenate(
        [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    )
    light = simplify(sphere, triangles, TRIANGLES)
    assert len(light) <= 2 * TRIANGLES < len(triangles)
    radius = np.linalg.norm(sphere[np.unique(light), :3], axis=1)
    assert radius == pytest.approx(np.ones(len(radius)), abs=1e-6)
    spans = np.ptp(sphere[np.unique(light), :3], axis=0)
    assert spans == pytest.approx([2, 2, 2], abs=0.1)
