"""How many official episodes can be driven in the replicas: their starts must be free places of
ours, connected to a place that sees the goal.

    python -m hil_sim.importers.robothor_starts --episodes DIR FloorPlan_Val1_1 [...]
"""

import math
import subprocess
import sys
from pathlib import Path

import click

from hil_sim.ground_truth.goals import not_asked
from hil_sim.importers.robothor_episodes import OfficialEpisode, official_episodes
from hil_sim.scenes.format import SceneError
from hil_sim.simulation.quiet import hushed, keep_stdout_for_python
from runtime.core.types import Pose
from runtime.errors import RfNavError

LONG_M = 1.0
"""Shorter paths are not compared."""


def verdicts(name: str, episodes: tuple[OfficialEpisode, ...]) -> list[str]:
    """For each episode of a scene: "good"; "tight" (the body fits, but less than a cell is left to
    an obstacle), "blocked" or "cut off" at its start; "goal unseen" (no free place sees it from 1
    m) or "goal unrecognised" (by a person). Prints their counts and the median of our shortest path
    over the official one."""
    with hushed():
        from hil_sim.ground_truth.truth import SceneTruth
        from hil_sim.scenes.furniture.assets import Assets
        from hil_sim.simulation.scene_physics import ScenePhysics

    from hil_sim.scenes.robothor.scenes import robothor_scene

    found: list[str] = []
    ratios: list[float] = []
    with ScenePhysics(robothor_scene(name), Assets(), "auto", None) as world:
        truth = SceneTruth(world, Assets())
        for episode in episodes:
            at = episode.start
            if not_asked(world.scene, episode.goal):
                found.append("goal unrecognised")
                continue
            try:
                away = truth.distance_m(episode.goal, Pose(at.x_m, at.y_m, at.yaw_rad))
            except SceneError:
                found.append("goal unseen")
                continue
            if not truth.space.is_free(at.x_m, at.y_m):
                found.append("blocked" if world.collides(at.x_m, at.y_m) else "tight")
            else:
                found.append("good" if math.isfinite(away) else "cut off")
            if found[-1] == "good" and episode.shortest_path_m > LONG_M:
                ratios.append(away / episode.shortest_path_m)
    counts = ", ".join(f"{found.count(k)} {k}" for k in sorted(set(found)))
    middle = sorted(ratios)[len(ratios) // 2] if ratios else math.nan
    click.echo(f"{name}: {len(found)} episodes: {counts}; our path / official: {middle:.2f}")
    return found


@click.command()
@click.argument("scenes", nargs=-1, required=True)
@click.option("--episodes", type=click.Path(path_type=Path), required=True, help="Their folder.")
def main(scenes: tuple[str, ...], episodes: Path) -> None:
    """Count the official episodes of SCENES whose starts are free and connected to success.

    \b
    Example: python -m hil_sim.importers.robothor_starts --episodes ../shared/robothor/episodes/val
             FloorPlan_Val1_1
    """
    if len(scenes) == 1:
        keep_stdout_for_python()
        verdicts(scenes[0], official_episodes(episodes, scenes))
        return
    for name in scenes:  # a process for each: one that has drawn a scene should not draw another
        command = [
            sys.executable,
            "-m",
            "hil_sim.importers.robothor_starts",
            "--episodes",
            str(episodes),
        ]
        subprocess.run([*command, name], check=True)


if __name__ == "__main__":
    try:
        main()
    except RfNavError as error:
        click.echo(f"starts: {error}", err=True)
        sys.exit(2)
