"""Whether the models that a configuration names exist, before anything is loaded."""

from pathlib import Path

from models.store import manifest
from models.words.vocabulary import load_vocabulary
from runtime.config import ModelsConfig
from runtime.errors import ModelError
from runtime.perception.loaded_models import TEXT_MODEL
from runtime.perception.model_errors import models_told


def check_models(models: ModelsConfig) -> None:
    """ModelError, one line, for a model that is neither in the manifest nor a file, and for words
    that are none. A model of the manifest may still have to be fetched."""
    named = [
        ("models.language", models.language),
        *(("models.detectors", name) for name in models.detectors),
        ("models.vision", models.vision),
        ("research.second_look", models.second_look),
        ("research.scene_layout_file", models.scene_layout),
    ]
    for key, name in named:
        if name:
            _check(key, name)
    projector = models.vision_projector
    if projector and not Path(projector).is_file():
        raise ModelError(f"models.vision_projector: {projector}: no such file")
    if models.vocabulary:
        with models_told():
            load_vocabulary(Path(models.vocabulary))


def check_present(models: ModelsConfig) -> None:
    """ModelError for one of the manifest's models that is not here or is damaged, with the command
    that fetches it: nothing is fetched."""
    named = TEXT_MODEL, models.language, *models.detectors, models.vision, models.second_look
    for name in named:
        if name and not manifest.by_path(name):
            with models_told():
                manifest.verify(name)


def _check(key: str, name: str) -> None:
    if manifest.by_path(name):
        if not Path(name).exists():
            raise ModelError(f"{key}: {name}: no such file")
        return
    try:
        with models_told():
            manifest.entry(name)
    except ModelError as error:
        raise ModelError(f"{key}: {error}") from error
