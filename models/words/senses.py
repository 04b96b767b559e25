"""What household nouns mean: synonyms and kinds, from the table of `models.words.from_wordnet`."""

import gzip
import json
from pathlib import Path
from typing import Any, NamedTuple

from models.errors import ModelFileError

PATH = Path(__file__).parents[1] / "wordnet" / "nouns.json.gz"
PLURALS = (
    ("ses", "s"), ("xes", "x"), ("zes", "z"), ("ches", "ch"), ("shes", "sh"), ("men", "man"),
    ("ies", "y"), ("s", ""),
)  # fmt: skip


class NounSense(NamedTuple):
    """One meaning. `names` share it; `broader` and `narrower` are ids of what it is a kind of and
    of its own kinds, one step away. `gloss` is empty where no other meaning competes for a name.
    `common` is False where the word that was asked for mostly means what is not in the table: dog,
    for andirons."""

    id: int
    names: tuple[str, ...]
    gloss: str
    broader: tuple[int, ...]
    narrower: tuple[int, ...]
    common: bool = True


class Senses:
    """Looked up by `senses(text)`; raises ModelFileError where the table is not one."""

    def __init__(self, path: Path = PATH) -> None:
        try:
            table: dict[str, Any] = json.loads(gzip.decompress(path.read_bytes()))
            rows = [(tuple(n), g, tuple(up)) for n, g, up in table["senses"]]
            self._singular: dict[str, str] = dict(table["singular"])
            self._elsewhere = frozenset(table["elsewhere"])
        except (OSError, EOFError, ValueError, KeyError, TypeError) as error:
            raise ModelFileError(
                f"{path}: not a table of senses ({error}); reinstall rf-nav"
            ) from None
        kinds: list[list[int]] = [[] for _ in rows]
        for id, (_, _, up) in enumerate(rows):
            for above in up:
                kinds[above].append(id)
        self._senses = []
        self._by_key: dict[str, list[int]] = {}
        for id, (names, gloss, up) in enumerate(rows):
            self._senses.append(NounSense(id, names, gloss, up, tuple(kinds[id])))
            for word in dict.fromkeys(key(name) for name in names):
                self._by_key.setdefault(word, []).append(id)

    def __call__(self, text: str) -> tuple[NounSense, ...]:
        """All household meanings of a noun, singular or plural, however it is spaced; () where
        none is known."""
        for form in self._forms(key(text)):
            if form in self._by_key:
                found = (self._senses[id] for id in self._by_key[form])
                return tuple(s._replace(common=form not in self._elsewhere) for s in found)
        return ()

    def _forms(self, word: str) -> list[str]:
        """The word, then what it may be the plural of."""
        forms = [word]
        if word in self._singular:
            forms.append(self._singular[word])
        return forms + [word[: -len(a)] + b for a, b in PLURALS if word.endswith(a)]


def key(text: str) -> str:
    """ "Arm-chair" and "arm chair" are spelt "armchair"."""
    return "".join(c for c in text.lower() if c.isalnum())
