"""Laser scans added to the navigation map; see `laser_layer`."""

from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import Pose, Scan


def add_scan(
    grid: NavigationMap, scan: Scan, pose: Pose, radius_m: float, max_range_m: float
) -> None:
    """Add what a laser met within a range, for a body of that radius at that pose."""
    changed = grid.laser.add(grid.frame, scan, pose, radius_m, max_range_m)
    if changed is not None:
        grid.changed(changed)
