"""All that is measured of the scene-layout expert: on held-out homes' views, on photographs, in a
bank, and by the clock."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Protocol

from hil_sim.expert_bench.bank import HOMES, Bank, load_bank
from hil_sim.expert_bench.judge import Electorate
from hil_sim.expert_bench.learned_homes import check_unknown
from hil_sim.expert_bench.photographs import load_photographs
from hil_sim.expert_bench.plan_counts import count_plans
from hil_sim.expert_bench.scene_bank import SceneRows, judge_scene, prior_insight
from hil_sim.expert_bench.scene_plan import ScenePlan
from hil_sim.expert_bench.scene_report import SceneFigures, SideRows
from hil_sim.expert_bench.scene_speed import THREADS, time_votes
from hil_sim.expert_bench.scene_views import Beholder, HomesCounted, judge_views
from hil_sim.expert_bench.view_questions import Floats, load_views
from hil_sim.ground_truth.labels import LABELLED
from runtime.clock import SystemClock
from runtime.errors import RfNavError


class Voting(Electorate, Protocol):
    """The experts' models; see `Voters`."""

    def warm(self, bank: Bank) -> None: ...


Open = Callable[[Sequence[str]], AbstractContextManager[Voting]]
"""Settings -> the models behind the experts."""
Embed = Callable[[list[str]], Floats]


def measure(
    plan: ScenePlan,
    beholders: Mapping[str, Beholder],
    embed: Embed,
    detector: str,
    never: Collection[str],
    opened: Open,
) -> SceneFigures:
    """Everything; `beholders` by kind, `detector`: SHA-256 of whose features they take, `never`:
    names that none was taught. RfNavError when files cannot be used, or a model fails."""
    check_unknown(sorted(path.stem for path in (plan.views / HOMES).glob("*.npz")))
    views = load_views(plan.views, plan.most, plan.seed)
    train = load_views(plan.counted, sighted=False) if plan.counted else None
    for folder, seen in ((plan.views, views), (plan.counted, train)):
        if seen is not None and seen.detector != detector:
            raise RfNavError(
                f"{folder}: seen by another detector than the one whose features the scene-layout "
                "expert was taught; make the views anew: hil-sim beyond"
            )
    timed = load_views(plan.views).beyond.sights if plan.most else views.beyond.sights
    pictures = load_photographs(plan.photographs) if plan.photographs else None
    banks = {side: load_bank(plan.bank, side) for side in plan.sides} if plan.bank else {}
    judged: dict[str, dict[str, SceneRows]] = {side: {} for side in banks}
    seconds = {}
    for kind in plan.kinds:
        own = f'research.scene_layout="{kind}"', f"models.threads={THREADS}"
        settings = (*plan.settings, *own)
        with opened(settings) as voters:
            seconds[kind] = time_votes(timed, kind, settings, voters, SystemClock())
            for side, bank in banks.items():
                voters.warm(bank)
                judged[side][kind] = judge_scene(bank, settings, voters, plan.seed)
    counted = HomesCounted(train, count_plans(plan.plans))
    table = judge_views(
        views, counted, beholders, embed(list(LABELLED)), never, pictures, plan.seed
    )
    sides = {
        side: SideRows(bank, judged[side], prior_insight(bank)) for side, bank in banks.items()
    }
    return SceneFigures(table, sides, seconds, plan.settings)
