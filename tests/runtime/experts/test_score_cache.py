"""Scores outlive the process and never mix models; a broken file is said and not used."""

from pathlib import Path

from runtime.clock import Deadline, SystemClock
from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.experts.score_cache import ScoreFile
from runtime.experts.scorer import Scorer

Q, R = (
    LikelihoodQuestion("a kitchen has a", " stove"),
    LikelihoodQuestion("a kitchen has a", " bed"),
)


class Counting:
    def __init__(self) -> None:
        self.asked: list[str] = []

    def score(self, context, continuations):
        self.asked += continuations
        return [-float(len(c)) for c in continuations]


def test_the_next_process_asks_only_what_is_new(tmp_path: Path):
    clock = SystemClock()
    for expected in ([" stove"], [" bed"]):
        model = Counting()
        with Scorer([("m", model)], clock, ScoreFile(tmp_path / "s.sqlite", "one")) as scorer:
            asked = [Q] if expected == [" stove"] else [Q, R]
            answers = scorer.answer(asked, Deadline.after(5.0, clock))
        assert model.asked == expected
        assert answers[Q] == -6.0


def test_models_do_not_mix(tmp_path: Path):
    ScoreFile(tmp_path / "s.sqlite", "one").load()
    ScoreFile(tmp_path / "s.sqlite", "one").keep([(Q, -0.1234567890123456)])
    assert ScoreFile(tmp_path / "s.sqlite", "one").load() == {Q: -0.1234567890123456}
    assert ScoreFile(tmp_path / "s.sqlite", "two").load() == {}


def test_a_damaged_file_is_named_and_left_alone(tmp_path: Path):
    path = tmp_path / "s.sqlite"
    path.write_bytes(b"this is no database" * 100)
    file = ScoreFile(path, "one")
    assert file.load() == {}
    opened = [entry.resolve() for entry in Path("/proc/self/fd").iterdir()]
    assert path.resolve() not in opened
    assert str(path) in file.error
    file.keep([(Q, 1.0)])
    assert path.read_bytes() == b"this is no database" * 100


def test_damage_that_sqlite_has_no_words_for_is_said_too(tmp_path: Path):
    path = tmp_path / "s.sqlite"
    ScoreFile(path, "one").load()
    path.write_bytes(path.read_bytes().replace(b"CREATE TABLE", b"CREATE \xbb\xbb\xbb\xbb\xbb"))
    file = ScoreFile(path, "one")
    assert file.load() == {}
    assert file.error.startswith(f"{path}: ")
