from hil_sim.commands.beyond import home_names
from hil_sim.expert_bench.bank import side_of


def test_a_longer_list_of_homes_begins_with_the_shorter_one():
    names = home_names(20, 200_000, "train", replicas=True)
    assert names[:7] == home_names(7, 200_000, "train", replicas=True)
    assert len(set(names)) == 20
    replicas = [name for name in names if name.startswith("FloorPlan_Train")]
    assert len(replicas) == 4
    assert {side_of(name) for name in replicas} == {"fit"}


def test_homes_of_the_other_split_have_no_replicas():
    assert home_names(3, 300_000, "val", replicas=False) == [
        "val-300000", "val-300001", "val-300002",
    ]  # fmt: skip
