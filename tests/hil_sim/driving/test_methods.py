"""What each method's name promises of the truth that its runtime is told."""

import pytest

from hil_sim.driving.methods import METHODS, method_named
from runtime.config import load
from runtime.errors import ConfigError


@pytest.mark.parametrize("name", [name for name, m in METHODS.items() if m.driver == "runtime"])
def test_the_settings_of_every_method_are_known_to_the_runtime(name: str) -> None:
    method = method_named(name)
    config = load(None, [*method.settings, *method.start])
    source = {"": "model", "all": "topic", "boxes": "both"}[method.labels]
    assert config.detector.source == source
    assert bool(config.detector.labels) == bool(method.labels)


def test_true_boxes_go_with_the_views_of_our_own_detector_alone() -> None:
    method = method_named("labels/geometry")
    assert (method.labels, method.eyes) == ("boxes", "rfnav-det")
    assert load(None, method.start).models.detectors == ("rfnav-det",)
    assert method_named("oracle-perception/geometry").start == ()
    assert method_named("geometry").start == ()


def test_an_unknown_method_is_told_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"method labels/cow-mdetr: unknown; .*labels/METHOD"):
        method_named("labels/cow-mdetr")
