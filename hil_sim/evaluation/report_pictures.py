"""Which figures a report gets, and where they go."""

from pathlib import Path

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.evaluation.figures import draw_actions, draw_failures, draw_paths
from hil_sim.evaluation.result_folder import FULL, Folder
from hil_sim.ground_truth.episodes import Episode
from hil_sim.scenes.open import open_scene
from runtime.errors import RfNavError

DRAWN = ("oracle-goal", "closest", "geometry", FULL)
"""Methods in the figure of paths; in that of actions without the first."""
PATHS = 3


def draw_all(folder: Folder, beside: Path, chosen: tuple[str, ...]) -> list[tuple[str, str]]:
    """Draws into BESIDE/figures; returns (path from BESIDE, caption)."""
    out = beside / "figures"
    out.mkdir(parents=True, exist_ok=True)
    name = folder.name
    found = [
        (draw_failures(folder.runs, out / f"{name}-failures.png"), "Failed episodes by cause."),
    ]
    actions = {m: folder.runs[m] for m in DRAWN[1:] if m in folder.runs} or dict(
        list(folder.runs.items())[:3]
    )
    found.append((draw_actions(actions, out / f"{name}-actions.png"),
                  "Actions an episode took, by goal, and what they were for."))  # fmt: skip
    for episode in _choose(folder, chosen):
        results = {
            m: r for m in DRAWN for r in folder.runs.get(m, ()) if r.episode == episode.id
        } or _any(folder, episode)
        file = out / f"{name}-{episode.id.replace('/', '_')}.png"
        draw_paths(open_scene(episode.scene), episode, folder.path, results, file)
        found.append((file, f"Paths in {episode.scene}; the {episode.goal} is gold."))
    return [(str(path.relative_to(beside)), caption) for path, caption in found]


def _any(folder: Folder, episode: Episode) -> dict[str, EpisodeResult]:
    rows = {m: r for m, rs in folder.runs.items() for r in rs if r.episode == episode.id}
    return dict(list(rows.items())[:4])


def _choose(folder: Folder, chosen: tuple[str, ...]) -> list[Episode]:
    """Those that were asked for; else where the full method gains and loses most against the
    closest frontier: two gains, one loss."""
    by_id = {episode.id: episode for episode in folder.episodes}
    for name in chosen:
        if name not in by_id and len(chosen) == 1:
            raise RfNavError(f"--episode {name}: not in the suite of {folder.path}")
    if chosen:
        return [by_id[name] for name in chosen if name in by_id]
    ours = {r.episode: r.spl or 0.0 for r in folder.runs.get(FULL, ())}
    theirs = {r.episode: r.spl or 0.0 for r in folder.runs.get("closest", ())}
    order = sorted(ours.keys() & theirs.keys(), key=lambda e: (theirs[e] - ours[e], e))
    picked = [*order[: PATHS - 1], *order[PATHS - 1 :][-1:]]
    return [by_id[name] for name in picked]
