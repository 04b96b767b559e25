"""Fewer triangles for what is drawn small."""

import meshoptimizer
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.furniture.soup import Array


def simplify(vertices: Array, triangles: NDArray[np.int64], limit: int) -> NDArray[np.int64]:
    """At most about `limit` triangles of the given (V, 5) x, y, z, u, v; coordinates of the texture
    stay with their vertex. Tries to keep the topology first."""
    if len(triangles) <= limit:
        return triangles
    xyz = np.ascontiguousarray(vertices[:, :3], np.float32)
    welded, weld = np.unique(xyz, axis=0, return_inverse=True)
    index = np.ascontiguousarray(triangles.reshape(-1), np.uint32)
    out = np.zeros(len(index), np.uint32)
    n = meshoptimizer.simplify(out, index, xyz, target_index_count=3 * limit, target_error=0.04)
    if n <= 3 * limit * 2:
        return _tidy(out[:n])
    # seams of the texture lock too many edges: weld them and take any vertex of a position
    index = np.ascontiguousarray(weld.reshape(-1)[index], np.uint32)
    out = np.zeros(len(index), np.uint32)
    n = meshoptimizer.simplify(out, index, welded, target_index_count=3 * limit, target_error=0.06)
    if n > 3 * limit * 2:
        n = meshoptimizer.simplify_sloppy(
            out, index, welded, target_index_count=3 * limit, target_error=0.1
        )
    some = np.zeros(len(welded), np.int64)
    some[weld.reshape(-1)] = np.arange(len(xyz))
    return _tidy(some[out[:n]])


def _tidy(index: NDArray[np.uint32] | NDArray[np.int64]) -> NDArray[np.int64]:
    triangles = index.astype(np.int64).reshape(-1, 3)
    a, b, c = triangles.T
    whole: NDArray[np.int64] = triangles[(a != b) & (b != c) & (a != c)]
    return whole
