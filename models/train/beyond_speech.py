"""What the language model is asked of a picture's soft tokens, and how its answers are read: as the
runtime asks and reads, but for names of several tokens, whose first stands for them here."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from models.language.gguf import load
from models.train.beyond_scores import REFERENCES
from models.train.beyond_words import LayoutWords
from models.train.llama import FrozenLlama
from models.train.names import Embed

BEGINS = 1
"""The token that a text would begin with: what a picture's first soft token starts as."""
BRIDGED, STRENGTH = 2500, 3.0
"""LayoutWords by which the text encoder's space is mapped on the tokens', and its ridge."""


@dataclass(frozen=True)
class Speech:
    """A frozen model and the tokens of what it is asked. `names` (K,) first tokens of the
    categories; `taught` (K,) which may be taught: told never, or alike by their first tokens, are
    none. `prompts` are token vectors (T, E) of the file's [text]."""

    model: FrozenLlama
    names: Tensor
    rooms: Tensor
    references: Tensor
    taught: np.ndarray
    prompts: dict[str, Tensor]

    def heard(self, tokens: Tensor, prompt: str) -> Tensor:
        """(N, 8, E) -> (N, E) what follows them and a prompt; with `model.embedding` the logits."""
        text = self.prompts[prompt]
        return self.model.last(torch.cat((tokens, text.expand(len(tokens), -1, -1)), 1))

    def things(self, heard: Tensor, blank: Tensor, blur: float = 0.0) -> Tensor:
        """(N, E), (E,) of no picture -> (N, K) nats of the categories: how much likelier than the
        references in the mean, above what they are without a picture; with a noise of `blur` times
        its length in each name's direction."""
        table = self.model.embedding
        direction = table[self.names] - table[self.references].mean(0)
        noise = torch.randn_like(direction) * direction.square().mean().sqrt()
        return (heard - blank) @ (direction + blur * noise).T


def read_speech(path: Path, words: LayoutWords) -> Speech:
    """Open the model, and tell what the words are in its tokens."""
    tokenizer = load(path, 1, vocab_only=True)

    def tokens(text: str) -> list[int]:
        return list(tokenizer.tokenize(text.encode(), add_bos=False, special=False))

    def first(texts: Sequence[str]) -> Tensor:
        return torch.tensor([tokens(" " + text)[0] for text in texts])

    model = FrozenLlama(path)
    names = first([called[0] for called in words.called])
    count = Counter(names.tolist())
    alone = [count[int(t)] == 1 or len(tokens(" " + called[0])) == 1
             for t, called in zip(names, words.called, strict=True)]  # fmt: skip
    return Speech(
        model=model,
        names=names,
        rooms=first(words.rooms),
        references=first(REFERENCES),
        taught=words.taught & np.array(alone),
        prompts={
            key: model.embedding[tokens(text)]
            for key, text in words.texts.items()
            if key != "thing"
        },
    )


def bridge(
    path: Path, speech: Speech, words: LayoutWords, embed: Embed, common: int = BRIDGED
) -> Tensor:
    """(384, E) ridge regression from words' rows to their tokens' vectors: `common` words of
    one token, names of rooms and of what may be taught."""
    tokenizer = load(path, 1, vocab_only=True)
    never = {n for c, taught in zip(words.called, words.taught, strict=True) if not taught
             for n in c}  # fmt: skip
    texts: dict[str, int] = {}
    for token in range(300, len(speech.model.embedding)):
        text = tokenizer.detokenize([token]).decode("utf-8", "ignore")
        if text[:1] == " " and len(text) > 3 and text[1:].islower() and text[1:].isalpha():
            texts[text[1:]] = token
        if len(texts) >= common:
            break
    for taught, called, token in zip(words.taught, words.called, speech.names, strict=True):
        if taught:
            texts[called[0]] = int(token)
    texts |= dict(zip(words.rooms, speech.rooms.tolist(), strict=True))
    kept = {text: token for text, token in texts.items() if text not in never}
    rows = torch.from_numpy(np.asarray(embed(list(kept)), np.float32))
    vectors = speech.model.embedding[list(kept.values())]
    gram = rows.T @ rows + STRENGTH * torch.eye(rows.shape[1])
    return torch.linalg.solve(gram, rows.T @ vectors)
