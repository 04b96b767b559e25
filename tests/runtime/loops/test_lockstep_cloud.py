"""A cloud in the loop: asked when experts disagree, its cost journaled, its end noticed."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from cloud_double import Server
from fake_models import FakeModels
from lockstep_double import begin, home, running

from runtime.clock import Deadline, SystemClock
from runtime.core.types import Action, Brief, Vote
from runtime.experts.cloud import Cloud
from runtime.experts.cloud_config import CloudConfig
from runtime.experts.panel import Panel
from runtime.journal import read_journal


def nearest(brief: Brief, by: Deadline) -> Vote:
    near = min(brief.frontiers, key=lambda f: f.distance_m).id
    return Vote("", (near,), ((near, 1.0),), "it is near")


def in_halls(brief: Brief) -> Brief:
    """The apartment tells no room types."""
    told = (replace(frontier, rooms=(("hall", 1.0),)) for frontier in brief.frontiers)
    return replace(brief, frontiers=tuple(told))


class CloudModels(FakeModels):
    """Its local expert is never agreed with; the appeal is the cloud's."""

    def __init__(self, where: Any, cloud: Cloud) -> None:
        super().__init__(where)
        self.cloud = cloud
        appeals = {"r2f": lambda brief, by: cloud.expert("r2f")(in_halls(brief), by)}
        self.panel = Panel({"r2f": nearest}, SystemClock(), appeals, lambda ballot: False)

    def health(self) -> dict[str, object]:
        return {"cloud": self.cloud.status()}

    def bills(self) -> tuple[object, ...]:
        return self.cloud.bills()

    def finish(self) -> None:
        self.cloud.finish()
        super().finish()


@pytest.fixture
def config(tmp_path: Path) -> CloudConfig:
    return CloudConfig(
        enabled=True,
        model="big",
        price_in_usd=1.0,
        price_out_usd=10.0,
        cap_goal_usd=1.0,
        cap_day_usd=1.0,
        spending_file=str(tmp_path / "spending.sqlite"),
    )


@pytest.mark.parametrize("behave", ["vote", "break"])
def test_what_the_cloud_costs_is_journaled_and_told(
    behave: str, tmp_path: Path, config: CloudConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("runtime.core.world.FIRST_LOOKS", 4)
    where = home()
    with Server() as server:
        if behave != "vote":
            server.behave = behave
        with Cloud(replace(config, base_url=server.url), SystemClock()) as cloud:
            cloud.begin("toilet")
            models = CloudModels(where, cloud)
            with running(models) as (peer, _):
                assert begin(peer, tmp_path / "log")["accepted"]
                for _ in range(10):
                    action = peer.show(where)
                    assert action is not None
                    where.apply(Action(action))
                status = peer.ask("status", {})
                assert models.finished == 0
                assert peer.ask("cancel", {})["ended"]
            assert models.finished == 1
    lines = list(read_journal(tmp_path / "log" / "decisions.jsonl"))
    calls = [line["call"] for line in lines if line["kind"] == "cloud"]
    assert 0 < len(calls) == len(server.requests)
    causes = {call["outcome"] for call in calls}
    votes = [v for line in lines if line["kind"] == "decision" for v in line["votes"]]
    if behave == "vote":
        assert causes == {"vote"}
        assert {v["rung"] for v in votes} == {"cloud"}
    else:  # the episode goes on with the votes there are
        assert causes == {"the connection broke (RemoteProtocolError)"}
        assert {v["rung"] for v in votes} == {"local"}
    told = status["models"]["cloud"]
    assert told["calls"] == len(calls)
    assert told["goal_usd"] == pytest.approx(sum(call["usd"] for call in calls))
    assert all(call["expert"] == "r2f" for call in calls)
