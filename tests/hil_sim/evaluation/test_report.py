"""Tables and figures from finished episodes, and a document whose prose survives them."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.__main__ import cli
from hil_sim.driving.episode_result import End, Ended, EpisodeResult
from hil_sim.driving.methods import METHODS
from hil_sim.evaluation.evaluate import Evaluation, claim
from hil_sim.evaluation.failures import Cause, cause, split
from hil_sim.evaluation.report import brief, fill, groups, section
from hil_sim.evaluation.report_tables import purposes
from hil_sim.evaluation.result_folder import read_folder
from hil_sim.evaluation.results import Results
from hil_sim.evaluation.summary import bootstrap, difference
from hil_sim.evaluation.worker import Settings
from hil_sim.ground_truth.episodes import Episode, Start
from hil_sim.ground_truth.witness import Claim
from runtime.errors import RfNavError

EPISODES = tuple(
    Episode(f"maple-{goal}-{i}", "maple", Start(5.0, 6.0, 0.0), goal, 4.0)
    for i in range(5)
    for goal in ("bed", "toilet")
)


def result(method: str, episode: Episode, success: bool, **more: object) -> EpisodeResult:
    blank = EpisodeResult(
        episode=episode.id, scene=episode.scene, goal=episode.goal, method=method, protocol="hm3d",
        success=success, ended=Ended(End.STOP), steps=20, collisions=1, decisions=2,
        shortest_path_m=4.0, path_m=5.0, distance_m=0.0 if success else 2.0,
        spl=0.8 if success else 0.0, soft_spl=0.4,
        actions={"frontier": 12, "target": 8}, stopped=True, frontier_m=(3.0, 5.0),
        wall={"render": 1.0, "runtime.map": 2.0, "total": 3.5, "rendered": 10.0, "recalled": 5.0},
    )  # fmt: skip
    return replace(blank, **more)  # type: ignore[arg-type]


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """10 episodes of rfnav and closest, the first 4 of more; rfnav finds beds, closest nothing."""
    folder = tmp_path / "val"
    claim(Evaluation("val", EPISODES, (), 2, Settings(folder)))
    results = Results(folder)
    for method, count in (
        ("rfnav", 10), ("paper", 4), ("closest", 10), ("o2f", 4), ("single-llm", 4)
    ):  # fmt: skip
        for episode in EPISODES[:count]:
            found = method == "rfnav" and episode.goal == "bed"
            results.add(result(method, episode, found))
            track = folder / method / episode.id / "track.jsonl"
            track.parent.mkdir(parents=True)
            track.write_text('{"x": 5.5, "y": 6.0}\n{"x": 6.0, "y": 6.5}\n')
    results.timed(28, 120.0, 2)
    return folder


def test_the_papers_tables_with_paired_differences(out: Path) -> None:
    folder = read_folder(out)
    assert [(title, len(runs[base]), list(runs)) for title, base, runs in groups(folder)] == [
        ("Against baselines", 10, ["closest", "rfnav"]),
        ("Against baselines", 4, ["closest", "single-llm", "paper", "rfnav"]),
        ("Experts alone, in pairs, all", 4, ["o2f", "paper"]),
        ("Consensus against a majority", 4, ["single-llm", "paper"]),
    ]
    text = section(folder, 0, [])
    assert "| rfnav | 50.0 [20.0, 80.0] | 40.0 [" in text
    assert "| closest | 10 | **50.0 [20.0, 80.0]** | **40.0 [" in text
    assert "4.00 [4.00, 4.00]" in text  # FrontierDist
    assert "| rfnav | 5 of 10 | 0 | 0 | 5 | 0 | 1.00 | 0 | 100 |" in text
    assert "| bed | 5 / 5 | 0 / 5 |" in text
    assert "28 episodes in 2 minutes of wall time" in text
    assert "14.0 a minute with 2 workers" in text
    assert section(folder, 0, []) == text


def test_steps_are_told_by_what_they_were_spent_on() -> None:
    spent = replace(result("rfnav", EPISODES[0], True), purposes={"exploring": 30, "other": 10})
    before = result("closest", EPISODES[0], True)  # of a time when that was not counted
    head, _, row = purposes({"rfnav": [spent], "closest": [before]}).splitlines()
    assert head.startswith("| method | steps an episode | exploring % | looking closer % |")
    assert row == "| rfnav | 40 | 75.0 | 0.0 | 0.0 | 0.0 | 0.0 | 0.0 | 25.0 |"
    assert purposes({"closest": [before]}) == ""


def test_true_labels_are_in_the_title(tmp_path: Path) -> None:
    folder = tmp_path / "labels"
    claim(Evaluation("labels", EPISODES, (), 2, Settings(folder)))
    results = Results(folder)
    for method in ("oracle-perception", "oracle-perception/closest"):
        for episode in EPISODES:
            results.add(result(method, episode, True))
    found = groups(read_folder(folder))
    assert [(title, base) for title, base, _ in found] == [
        ("Against baselines, with true labels (oracle perception)", "oracle-perception")
    ]


def test_true_boxes_alone_have_a_table_of_their_own(tmp_path: Path) -> None:
    folder = tmp_path / "labels"
    claim(Evaluation("labels", EPISODES, (), 2, Settings(folder)))
    results = Results(folder)
    for method in ("labels/rfnav", "labels/geometry", "oracle-perception"):
        for episode in EPISODES:
            results.add(result(method, episode, True))
    ((title, base, rows),) = groups(read_folder(folder))
    assert (title, base) == ("Against baselines, with true boxes and names", "labels/rfnav")
    assert set(rows) == {"labels/geometry", "labels/rfnav", "oracle-perception"}


def test_a_spoilt_expert_and_a_bound_are_compared_with_the_runtime_as_it_is(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "labels"
    claim(Evaluation("labels", EPISODES, (), 2, Settings(folder)))
    results = Results(folder)
    for method in ("rfnav", "geometry", "spoilt-sle", "without-o2f", "beyond-alone"):
        for episode in EPISODES:
            results.add(result(f"labels/{method}", episode, method != "spoilt-sle"))
    read = read_folder(folder)
    aside = ", with true boxes and names"
    assert [(title.removesuffix(aside), list(rows)) for title, _, rows in groups(read)] == [
        ("Against baselines", ["labels/geometry", "labels/rfnav"]),
        ("One expert left out, or at random",
         ["labels/without-o2f", "labels/spoilt-sle", "labels/geometry", "labels/rfnav"]),
        ("What a vote could bring", ["labels/beyond-alone", "labels/geometry", "labels/rfnav"]),
    ]  # fmt: skip
    text = brief(read, 0)
    assert "| labels/spoilt-sle | 10 | **100.0 [100.0, 100.0]** |" in text
    assert text.count("| labels/rfnav minus |") == 3


def test_experts_with_true_labels_stand_beside_the_closest_frontier(tmp_path: Path) -> None:
    folder = tmp_path / "labels"
    claim(Evaluation("labels", EPISODES, (), 2, Settings(folder)))
    results = Results(folder)
    for method in ("oracle-perception/closest", "oracle-perception/o2f"):
        for episode in EPISODES:
            results.add(result(method, episode, method.endswith("o2f")))
    text = section(read_folder(folder), 0, [])
    assert "| oracle-perception/closest minus |" in text
    assert "| oracle-perception/o2f | 10 | **-100.0 [-100.0, -100.0]** |" in text


@pytest.mark.slow
def test_one_command_makes_the_document_and_keeps_prose(out: Path, tmp_path: Path) -> None:
    page = tmp_path / "docs" / "results.md"
    page.parent.mkdir()
    page.write_text("# Results\n\nWhat I think.\n\n<!-- report val -->\nold\n"
                    "<!-- end of report val -->\n\nAnd after.\n")  # fmt: skip
    arguments = ["report", str(out), "--out", str(page), "--json", str(tmp_path / "r.json")]
    done = CliRunner().invoke(cli, arguments)
    assert done.exit_code == 0, done.output
    text = page.read_text()
    assert text.startswith("# Results\n\nWhat I think.\n\n<!-- report val -->\n## Suite `val`")
    assert text.endswith("<!-- end of report val -->\n\nAnd after.\n")
    assert "old" not in text.split()
    pictures = sorted(path.name for path in (page.parent / "figures").iterdir())
    assert pictures[:2] == ["val-actions.png", "val-failures.png"]
    assert len(pictures) == 5
    assert all(f"(figures/{name})" in text for name in pictures)
    data = json.loads((tmp_path / "r.json").read_text())
    assert data["val"]["methods"]["rfnav"]["success"]["mean"] == 0.5
    before = page.read_bytes()
    assert CliRunner().invoke(cli, arguments).exit_code == 0
    assert page.read_bytes() == before


def test_an_earlier_run_is_set_beside_this_one(out: Path, tmp_path: Path) -> None:
    earlier = tmp_path / "earlier"
    claim(Evaluation("val", EPISODES, (), 2, Settings(earlier)))
    results = Results(earlier)
    for episode in EPISODES[:6]:
        results.add(result("rfnav", episode, False, seen_at=3))
    text = section(read_folder(out), 0, [], read_folder(earlier))
    table = text.split("### Before and after\n\n")[1].split("\n\n")[0].splitlines()
    assert len(table) == 3  # rfnav alone is in both
    assert table[2].startswith("| rfnav | 6 | 0.0 → 50.0 | 0.0 → 40.0 | **50.0 [")
    assert table[2].endswith("| 6 → 0 |")
    page = tmp_path / "page.md"
    arguments = ["report", str(out), "--out", str(page), "--no-pictures", "--before"]
    done = CliRunner().invoke(cli, [*arguments, str(earlier)])
    assert done.exit_code == 0, done.output
    assert "### Before and after" in page.read_text()
    other = tmp_path / "other"
    claim(Evaluation("val", EPISODES[1:], (), 2, Settings(other)))
    Results(other).add(result("rfnav", EPISODES[1], True))
    done = CliRunner().invoke(cli, [*arguments, str(other)])
    assert "other episodes; --before takes a run of the same suite" in str(done.exception)


def test_a_page_gets_the_main_table_alone(out: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# Results\n\n<!-- report val -->\nold\n<!-- end of report val -->\n")
    done = CliRunner().invoke(cli, ["report", str(out), "--out", str(page), "--brief"])
    assert done.exit_code == 0, done.output
    text = page.read_text()
    assert "### Against baselines: 10 episodes" in text
    assert "| closest | 10 | **50.0 [20.0, 80.0]** | **40.0 [" in text
    assert "| rfnav | 5 of 10 | 0 | 0 | 5 | 0 | 1.00 | 0 | 100 |" in text
    assert "o2f" not in text  # has fewer episodes
    assert "old" not in text.split()
    assert not (tmp_path / "figures").exists()


def test_a_block_without_end_is_an_error() -> None:
    with pytest.raises(RfNavError, match="its end is missing; write <!-- end of report val -->"):
        fill("<!-- report val -->\nmine", "val", "new")
    assert fill("# Results\n", "a", "x").endswith(
        "<!-- report a -->\nx\n<!-- end of report a -->\n"
    )


def test_a_folder_without_results_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(RfNavError, match="holds no results; name a folder"):
        read_folder(tmp_path)
    claim(Evaluation("val", EPISODES, (), 2, Settings(tmp_path)))
    with pytest.raises(RfNavError, match="no episode is finished"):
        read_folder(tmp_path)


BED = EPISODES[0]


@pytest.mark.parametrize(
    ("facts", "wanted"),
    [
        ({"seen_at": None}, "exploration"),
        ({"seen_at": 9}, "detection"),
        ({"seen_at": 9, "believed_at": 12}, "planning"),
        ({"seen_at": 9, "believed_at": 12, "claim": Claim.TRUE}, "planning"),
        ({"seen_at": 9, "believed_at": 12, "claim": Claim.FALSE}, "detection"),
        ({"seen_at": None, "claim": Claim.FALSE}, "detection"),
        ({"seen_at": 9, "claim": Claim.FALSE, "ended": Ended(End.ERROR, "late")}, "error"),
    ],
)
def test_why_an_episode_failed(facts: dict[str, object], wanted: str) -> None:
    assert cause(result("rfnav", BED, False, **facts)) == wanted
    assert cause(result("rfnav", BED, True, **facts)) is None


@given(st.lists(st.tuples(st.booleans(), st.sampled_from(Claim),
                          st.sampled_from([None, 3]), st.sampled_from([None, 3]))))  # fmt: skip
def test_every_failure_has_one_cause(
    rows: list[tuple[bool, Claim, int | None, int | None]],
) -> None:
    logs = [result("rfnav", BED, ok, claim=claim, seen_at=seen, believed_at=believed)
            for ok, claim, seen, believed in rows]  # fmt: skip
    counts = split(logs)
    assert tuple(counts) == tuple(Cause)
    assert sum(counts.values()) == sum(not ok for ok, *_ in rows)


def test_pairing_tells_apart_what_separate_intervals_do_not() -> None:
    hard = [float(i % 2) * 10 for i in range(40)]
    better = [h + 0.5 + 0.01 * (i % 3) for i, h in enumerate(hard)]
    paired = difference(better, hard)
    assert paired.low > 0.4
    assert bootstrap(better).low < bootstrap(hard).high
    assert difference(hard, hard).low == difference(hard, hard).high == 0.0


def test_every_method_has_a_place_in_a_table() -> None:
    from hil_sim.evaluation.report import GROUPS, TOLD_ALL

    named = {name for _, names in GROUPS for name in names} | set(TOLD_ALL)
    assert {name.removeprefix("labels/") for name in METHODS if "perception/" not in name} == named
