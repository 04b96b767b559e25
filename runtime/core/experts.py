"""DEFA: the experts' questions and votes. Prompts out, numbers in; no model and no clock here.

A small language model is never asked to choose. It scores the same continuation (the goal) in the
context of one object or one room type; code turns those likelihoods into a set of frontiers.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Question:
    """Score `continuation` after `context`; equal questions have equal answers and are memoised."""

    context: str
    continuation: str
