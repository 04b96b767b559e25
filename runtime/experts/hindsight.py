"""What searches teach about the experts, for as long as the runtime runs: once a target is found,
every choice on the way is looked at again."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from runtime.core.distances import planner
from runtime.core.types import Decision, Frontier, Vote
from runtime.core.voting import expert_weights
from runtime.core.voting.consensus import ConsensusConfig
from runtime.core.voting.expert_weights import NormalEquations
from runtime.core.world import World

CHOICES_KEPT = 200  # of one search


@dataclass(frozen=True)
class Choice:
    """What was voted, on which frontiers."""

    votes: tuple[Vote, ...]
    places: tuple[tuple[int, tuple[float, float]], ...]  # frontier and its goal point, m

    @classmethod
    def of(cls, decision: Decision, frontiers: tuple[Frontier, ...]) -> "Choice":
        return cls(decision.ballot.votes, tuple((f.id, f.goal_xy) for f in frontiers))


@dataclass
class Hindsight:
    """The experts' weights, as far as they were learned."""

    learned: dict[tuple[str, ...], NormalEquations] = field(default_factory=dict)
    """By who was seated."""
    configured: dict[tuple[str, ...], dict[str, float]] = field(default_factory=dict)

    def applied(self, rule: ConsensusConfig, seated: tuple[str, ...]) -> ConsensusConfig:
        """A search's rule with the weights of now, where weights count."""
        self.configured[seated] = dict(rule.weights)
        state = self.learned.get(seated)
        if rule.mode != "weighted" or state is None:
            return rule
        return replace(rule, weights=expert_weights.weights(state, dict(rule.weights)))

    def learn(
        self, world: World, choices: Iterable[Choice], seated: tuple[str, ...]
    ) -> dict[str, object]:
        """From a search that stands at its target; what is to be journaled. The way on from a
        frontier is that from its goal point over the map as it is known now: where a shorter one
        was never seen, it is too long."""
        state = self.learned.get(seated) or NormalEquations.of(seated)
        here = planner.march_from(world.terrain, world.pose.xy, unhurried=False)
        for choice in choices:
            onward = {id: here.at(*xy) for id, xy in choice.places}
            state = expert_weights.learned(state, choice.votes, onward)
        self.learned[seated] = state
        weights = expert_weights.weights(state, self.configured.get(seated, {}))
        return {"decisions": state.decisions, "weights": dict(weights)}
