"""The network that was taught what lies beyond a view, opened for SLE: only beside the detector
whose features it was taught on, and with words only beside its own language model."""

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Final, NamedTuple

from models.errors import ModelFileError
from models.language.scene_layout import SceneLayout
from models.store import manifest
from runtime.config import ModelsConfig
from runtime.core.types import F32
from runtime.experts.scene_layout import SceneLayoutExperts
from runtime.experts.scorer import Scorer
from runtime.experts.seating import Unseated

MODEL: Final = "scene-layout"  # as the manifest has it, of the default detector
TASK: Final = "scene layout"
REMEDY: Final = 'research.scene_layout = "embedding"'


class Speaker(NamedTuple):
    """A language model that scores: its file's SHA-256, and who asks it."""

    sha256: str
    scorer: Scorer


def layout_for(models: ModelsConfig) -> str:
    """Name or path of the network that is to be opened: the configured one, else of the manifest
    one that was taught on what a configured detector sees, else the default's. ModelFileError where
    the manifest cannot be read."""
    known = manifest.load_manifest().values()
    taught = {entry.beside: entry.name for entry in known if entry.task == TASK and entry.beside}
    fitting = (taught[name] for name in models.detectors if name in taught)
    return models.scene_layout or next(fitting, MODEL)


def seat_layout(
    locate: Callable[[], Path],
    detectors: Collection[str],
    speaker: Speaker | None,
    row: Callable[[str], F32],
    threads: int,
) -> SceneLayoutExperts | Unseated:
    """The experts, or in a line why they cannot be: a fault where the file is missing or damaged.
    `detectors`: SHA-256 of each file that may tell features; `row`: text -> its (D,) embedding."""
    try:
        path = locate()
        layout = SceneLayout(path, threads)
    except ModelFileError as error:
        return Unseated(str(error), fault=True)
    if layout.detector not in detectors:
        return Unseated(
            f"{path}: made for a detector that models.detectors does not have; SLE goes by "
            f"likeness, as with {REMEDY}"
        )
    mute = _why_mute(layout, path, speaker)
    return SceneLayoutExperts(layout, row, speaker.scorer if speaker and not mute else None, mute)


def _why_mute(layout: SceneLayout, path: Path, speaker: Speaker | None) -> str:
    """Why no language model can be shown views; "" where one can."""
    if not layout.speaks:
        return f"{path}: has nothing to show to a language model; export it with a projector"
    if speaker is None:
        return f"{path}: models.language does not score words, so views cannot be put before them"
    if speaker.sha256 != layout.language:
        return f"{path}: made for another language model than models.language"
    return ""
