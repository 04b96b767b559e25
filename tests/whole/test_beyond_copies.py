"""What lies beyond is taught, judged and voted on by the same numbers, though models may import
neither the runtime nor the harness: their copies are held equal here."""

from hil_sim.expert_bench import view_questions
from hil_sim.ground_truth import lies_beyond
from models.train import beyond_data, beyond_scores
from runtime.core.voting import likelihood_experts, sight_experts


def test_training_weighs_the_prior_as_votes_do():
    assert beyond_scores.UNKNOWN_WEIGHT == likelihood_experts.UNKNOWN_WEIGHT
    assert beyond_scores.LEAST_M2 == likelihood_experts.LEAST_M2
    assert likelihood_experts.ExpertConfig().temperature == beyond_scores.TEMPERATURE


def test_training_compares_names_with_the_words_that_votes_do():
    assert beyond_scores.REFERENCES == sight_experts.SIGHT_REFERENCES


def test_beyond_ends_at_the_same_distance_for_all():
    assert beyond_data.BEYOND_M == view_questions.BEYOND_M == lies_beyond.WITHIN_M
