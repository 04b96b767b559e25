"""The scene-layout expert's own eyes: one ONNX file that looks at a keyframe's parts toward a
frontier, and answers with a vector to compare names with and with soft tokens for a language
model. models/train/beyond.py teaches it."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError
from models.onnx_session import open_session, run

FORMAT = "rf-nav-scene-layout/1"
INPUTS = ("features", "depth", "way")
OUTPUTS = ("beyond", "view", "tokens", "blank")
SILENT = OUTPUTS[:2]
"""Of a file that has nothing to show to a language model."""
TEMPLATES = ("beyond", "view", "room")
"""Of what: what is said between a picture's soft tokens and a name."""
VECTOR, SURE, AREA = slice(0, -2), -2, -1
"""Of an answer: what is compared with a name's row, what holds of any name, log of m2 beyond."""

Floats = NDArray[np.float32]


class SceneLooks(NamedTuple):
    """What was seen in N sights: `beyond` and `view` (N, D + 2), what lies through there and what
    is in view; `tokens` (N, T, E) in a language model's space, (N, 0, 0) where it has none."""

    beyond: Floats
    view: Floats
    tokens: Floats


class SceneLayout:
    """The file's graph and what its metadata say. Any thread may use it.

    `detector` and `language` are the sha256 of the files that it was trained with: another's
    features, or another's tokens, mean nothing to it. `text` is how a goal is put for the text
    encoder, `templates` what is said after the tokens; `blank` (T, E) are the tokens of no picture.
    A file of the outputs SILENT has no tokens, and `language` is "".
    """

    def __init__(self, path: Path, threads: int = 1) -> None:
        """Raises ModelFileError."""
        self._path = Path(path)
        self._session = open_session(self._path, threads)
        told = self._session.get_modelmeta().custom_metadata_map
        if told.get("format") != FORMAT:
            raise ModelFileError(
                f"{path}: no scene-layout expert (format {told.get('format', 'missing')!r:.40}, "
                f"expected {FORMAT!r}); run `rfnav models pull`"
            )
        names = [i.name for i in self._session.get_inputs()]
        outputs = [o.name for o in self._session.get_outputs()]
        self.speaks = outputs == list(OUTPUTS)
        if names != list(INPUTS) or not (self.speaks or outputs == list(SILENT)):
            raise ModelFileError(
                f"{path}: inputs {', '.join(names)} and outputs {', '.join(outputs)}; expected "
                f"{', '.join(INPUTS)} and {', '.join(OUTPUTS)}, or {' and '.join(SILENT)} alone: "
                "make it anew with models.train.beyond_export"
            )
        try:
            self.detector, self.text = told["detector"], told["text"]
            self.language = told["language"] if self.speaks else ""
            written = json.loads(told["templates"])
            self.templates = {key: str(written[key]) for key in TEMPLATES}
        except (KeyError, ValueError, TypeError) as error:
            raise ModelFileError(
                f"{path}: its metadata lack {error}; make it anew with models.train.beyond_export"
            ) from error
        self.grid = tuple(self._session.get_inputs()[0].shape[1:])
        if len(self.grid) != 3 or not all(isinstance(size, int) for size in self.grid):
            raise ModelFileError(
                f"{path}: features are {self.grid}, not three numbers: channels, rows, columns; "
                "make it anew with models.train.beyond_export"
            )
        none = [
            np.zeros((1, *shape), np.float32) for shape in (self.grid, (2, *self.grid[1:]), (2,))
        ]
        told_of_none = self._run(*none)
        self.blank = told_of_none[-1] if self.speaks else np.zeros((0, 0), np.float32)

    @property
    def template(self) -> str:
        """What is said between the tokens and the name of what may lie beyond."""
        return self.templates["beyond"]

    def look(self, features: Floats, depth: Floats, way: Floats) -> SceneLooks:
        """(N, C, h, w) of the detector, (N, 2, h, w) m and share known, (N, 2) column 0..1 and
        range in units of 5 m -> what is there. Raises ModelFileError for other shapes."""
        beyond, view, *shown = self._run(features, depth, way)
        tokens = shown[0] if self.speaks else np.zeros((len(beyond), 0, 0), np.float32)
        return SceneLooks(beyond, view, tokens)

    def evidence(self, answer: Floats, row: Floats) -> Floats:
        """(N, D + 2) `beyond` or `view`, (D,) a text's row -> (N,) nats that it is there;
        beyond: above what it is in the mean over views of homes."""
        return np.asarray(answer[:, VECTOR] @ row + answer[:, SURE], np.float32)

    def _run(self, *given: Floats) -> list[Floats]:
        feeds = dict(zip(INPUTS, (np.asarray(x, np.float32) for x in given), strict=True))
        return run(self._session, feeds, self._path)
