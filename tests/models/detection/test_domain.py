"""What a run's images are taken for, and that it does not flicker."""

from models.detection.domain import OTHERWISE, DomainEvidence


def test_an_image_that_is_sure_is_believed_at_once_and_one_other_changes_nothing() -> None:
    seen = DomainEvidence()
    seen.add(-9.0)
    assert seen.believed == "renderings"
    seen.add(3.0)
    assert seen.believed == "renderings"
    for _ in range(4):
        seen.add(4.0)
    assert seen.believed == "photographs"
    assert seen.told() == {"is": "photographs", "set": False, "log_odds": 2.17, "images": 6}


def test_unsure_images_at_the_start_change_nothing_until_they_are_many() -> None:
    seen = DomainEvidence()
    for _ in range(3):
        seen.add(-1.9)
        assert seen.believed == "photographs"
    seen.add(-1.9)
    assert seen.believed == "renderings"


def test_images_that_say_little_never_make_it_flicker() -> None:
    seen, believed = DomainEvidence(), set()
    seen.add(2.0)
    for k in range(1000):
        seen.add((1.0 if k % 2 else -1.0) * (OTHERWISE + 0.5))
        believed.add(seen.believed)
    assert believed == {"photographs"}


def test_no_one_image_outweighs_the_run() -> None:
    seen = DomainEvidence()
    for _ in range(20):
        seen.add(-2.0)
    seen.add(1e9)
    assert seen.believed == "renderings"


def test_another_camera_is_believed_in_time() -> None:
    seen = DomainEvidence()
    for _ in range(5000):
        seen.add(-4.0)
    for _ in range(300):
        seen.add(4.0)
    assert seen.believed == "photographs"


def test_what_is_set_stays() -> None:
    seen = DomainEvidence("renderings")
    for _ in range(10):
        seen.add(6.0)
    assert seen.believed == "renderings"
    assert seen.told()["set"]
