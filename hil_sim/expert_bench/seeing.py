"""The robot's own map in a home that is driven through without a bus: true objects, and the
detector's word on rooms and views."""

import hashlib
from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np

from hil_sim.driving.methods import GEOMETRY
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.ground_truth.true_labels import true_labels
from hil_sim.scenes.format import Scene
from hil_sim.simulation.camera import Frame
from hil_sim.simulation.protocol import HM3D
from runtime.clock import SystemClock
from runtime.config import Config, load
from runtime.core.types import Detections, Pose
from runtime.perception.loaded_models import LoadedModels
from runtime.robot.labels import read_labels

DETECTOR: Final = "rfnav-det"


@dataclass(frozen=True)
class BenchDetector:
    """The detector, and the names that objects go by on the map."""

    models: LoadedModels
    names: tuple[str, ...]
    config: Config

    @classmethod
    def open(cls, detector: str = DETECTOR) -> Self:
        """ModelError when a model is missing."""
        config = cls.settings(detector)
        models = LoadedModels(config, SystemClock())
        goal, _ = models.accept("toilet", config)
        return cls(models, tuple(known[0] for known in goal.classes), config)

    @staticmethod
    def settings(detector: str = DETECTOR) -> Config:
        """As `oracle-perception/geometry` sets the runtime, without experts."""
        names = ", ".join(repr(name) for name in LABELLED)
        labels = f"research.detector_labels=[{names}]"
        sets = (
            "panel.experts=[]",
            "models.threads=1",
            f"models.detectors=[{detector!r}]",  # rooms and views are its words
            *GEOMETRY,
            labels,
        )
        return load(None, (*sets, *HM3D.settings))

    def see(self, scene: Scene, pose: Pose, frame: Frame) -> Detections:
        """The truth's objects, the detector's room and view."""
        told = true_labels(scene, pose, frame.segmentation, frame.depth_m)
        true = read_labels(told, self.names, self.models.rooms)
        seen = self.models.detect(frame.rgb)
        return replace(true, rooms=seen.rooms, scene=seen.scene, features=seen.features)

    def sha256(self) -> str:
        """Of the file that tells features, "" where none does."""
        return next(iter(self.models.features_of()), "")

    def identity(self) -> str:
        """Changes with the detector's weights."""
        seen = self.models.detect(np.full((480, 640, 3), 128, np.uint8))
        return hashlib.blake2b(seen.scene.astype("<f2").tobytes(), digest_size=6).hexdigest()
