"""Several detectors as one. Each says what it sees and is asked as often as it is worth: those that
were trained for what the images are, our own now and then where another is; and of the other domain
those that have a word that nobody else has."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from models.detection.boxes import pairwise_iou
from models.detection.clip import ClipDetector, Way
from models.detection.closer import Window, joined, joined_views, part
from models.detection.detections import NO_FEATURES, Detector, Floats, RawDetections, checked
from models.detection.detector import DetectorView, OpenDetector, open_detector
from models.detection.domain import DomainEvidence, DomainSetting
from models.detection.fusion import ONE_THING_IOU, FusedPlaces, FusionWeights, fused, read_weights
from models.detection.grounding import GroundingDetector
from models.detection.second_look import SecondLook, Sought, look_twice
from models.errors import ModelFileError
from models.store import manifest
from models.words.text_encoder import TextEncoder

T = TypeVar("T")
Seen = TypeVar("Seen", DetectorView, RawDetections)
SECOND = "second look"


def open_detectors(
    names: Sequence[str], encoder: TextEncoder, threads: int = 1
) -> dict[str, Detector]:
    """Models' names or paths -> detectors by what weights of them go by (manifest.called). Raises
    ModelFileError."""
    return {
        manifest.called(name): open_detector(manifest.located(name), "auto", encoder, threads)
        for name in names
    }


class DetectorEnsemble:
    """Detectors by name as one (models.detection.detections.Detector). The first of our own that
    looks says which room it is, what regions look like, and which domain the images are of.

    `others_every`: frames between two looks of a detector that was trained for the other domain,
    and of our own beside another; 1: none rests but those of the other domain that add no word.
    `again`: the classifier of second looks, and what it looks for.
    `closer`: what is looked for is small.
    `features_from`: SHA-256 of the file whose features are wanted, though another speaks for ours,
    and no other's; "": those of the one that speaks.
    """

    def __init__(
        self,
        detectors: Mapping[str, Detector],
        domain: DomainSetting = "auto",
        others_every: int = 1,
        weights: FusionWeights | None = None,
    ) -> None:
        if not detectors:
            raise ModelFileError("models.detectors: is empty, name one at least")
        self.detectors = dict(detectors)
        self.domain = DomainEvidence(domain)
        self.others_every = others_every
        self.again: tuple[SecondLook, Sought] | None = None
        self._weights = read_weights() if weights is None else weights
        self._ours = {n: d for n, d in self.detectors.items() if isinstance(d, OpenDetector)}
        self._frames = 0
        self._knows: dict[str, NDArray[np.bool_]] = {}
        self._classes: tuple[tuple[str, ...], ...] = ()
        self.closer, self.features_from = False, ""
        self._memo = _Memo()
        self._goal: int | None = None
        self._way: Way = "patch"

    def begin(self) -> None:
        """A run begins: nothing of the images before it counts, so that runs repeat."""
        self.domain, self._frames = DomainEvidence(self.domain.setting), 0

    def remember(self, images: int) -> None:
        """Keep what was seen in the last so many images: a harness shows the same ones again."""
        self._memo.images = images

    def find_by(self, way: Way) -> None:
        """Choose how detectors of CLIP's kind find things. Raises ModelFileError where the file of
        one lacks what it needs."""
        for detector in self.detectors.values():
            if isinstance(detector, ClipDetector):
                detector.find_by(way)
        self._way = way

    def look_for(self, goal: int) -> None:
        """From now on this class of the vocabulary is the goal, of those that look for one."""
        for detector in self.detectors.values():
            if isinstance(detector, ClipDetector | GroundingDetector):
                detector.look_for(goal)
        self._goal = goal

    @property
    def open_detector(self) -> OpenDetector | None:
        """The first of our own."""
        return next(iter(self._ours.values()), None)

    @property
    def features_of(self) -> tuple[str, ...]:
        """SHA-256 of each detector's file whose features may be told."""
        return tuple(d.sha256 for d in self._ours.values() if d.tells_features)

    @property
    def capabilities(self) -> dict[str, Any]:
        """Of all together; each one's own under `detectors`."""
        each = {name: d.capabilities for name, d in self.detectors.items()}
        lists = [c["classes"] for c in each.values()]
        matched: dict[str, Any] = {}
        for said in each.values():
            for name, by in said.get("matched", {}).items():
                matched.setdefault(name, by)
        unseen = [c.get("unseen", []) for c in each.values()]
        return {
            "contract": ", ".join(str(c["contract"]) for c in each.values()),
            **{k: any(c[k] for c in each.values()) for k in _ABILITIES},
            "classes": None if None in lists else sorted({n for names in lists for n in names}),
            "matched": matched,
            "unseen": [n for n in unseen[0] if all(n in others for others in unseen[1:])],
            "domain": self.domain.told(),
            "detectors": each,
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Choose the classes (each its names, canonical first) and the room types."""
        for name, detector in self.detectors.items():
            detector.set_vocabulary(classes, rooms)
            unseen = set(detector.capabilities["unseen"])
            self._knows[name] = np.array([c[0] not in unseen for c in classes], bool)
        self._classes, self._goal = tuple(tuple(names) for names in classes), None

    def detect(
        self, rgb: NDArray[np.uint8], window: Callable[[], Window | None] = lambda: None
    ) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections by those whose turn it is. `window`: where in the image
        what is small may be, looked at more closely while others rest."""
        image, names = self._memo.of(checked(rgb)), self._whose_turn()
        resting = self._frames % self.others_every and len(names) < len(self.detectors)
        near = window() if self.closer and resting else None
        self._frames += 1
        teller = next((name for name in names if name in self._ours), None)
        knows = [self._knows[name] for name in names]
        if teller is None:
            found = [self._named(name, image, rgb, near) for name in names]
            return fused(found, names, np.stack(knows), self.domain.believed, self._weights)[0]
        ours = self._ours[teller]
        view = self._view(teller, image, rgb, near)
        said = ours.name(view)
        found = [said if n == teller else self._named(n, image, rgb, near) for n in names]
        at = names.index(teller)
        self.domain.add(ours.photograph_odds(view.scene))
        if self.again is not None:
            second, sought = self.again
            key = image, teller, self._classes, sought.places
            again = self._memo.get(key, lambda: look_twice(ours, second, sought, rgb, view))
            names, found = [*names, SECOND], [*found, again]
            knows.append(np.arange(len(self._classes)) == sought.label)
        domain = self.domain.believed
        one, places = fused(found, names, np.stack(knows), domain, self._weights)
        regions = _regions(places, at, said, view)
        return one._replace(
            embeddings=regions,
            rooms=said.rooms,
            scene=said.scene,
            features=self._features([said, *found], image, rgb),
        )

    def _features(
        self, found: Sequence[RawDetections], image: object, rgb: NDArray[np.uint8]
    ) -> Floats:
        """Of the whole image: what the first of those `found` tells, that of who speaks for ours;
        where a file's are wanted, that one's, of its own look or of one more."""
        told = found if self.features_from else found[:1]
        known = next((f.features for f in told if f.features.size), found[0].features)
        if known.size or not self.features_from:
            return known
        teller = next((n for n, d in self._ours.items() if d.sha256 == self.features_from), None)
        return known if teller is None else self._view(teller, image, rgb, None).features

    def _whose_turn(self) -> list[str]:
        """Those of this domain, and others that have a word for what those have none for; in
        between only those of this domain, without our own where there is another. All at a run's
        first frame, and where none is of this domain."""
        home, names = self._weights.home, list(self.detectors)
        now = self.domain.believed
        at_home = [n for n in names if home.get(n, now) == now]
        if not at_home or not self._frames:
            return names
        if self._frames % self.others_every:
            return [n for n in at_home if n not in self._ours] or at_home
        known = np.any([self._knows[n] for n in at_home], axis=0)
        return [n for n in names if n in at_home or (self._knows[n] & ~known).any()]

    def _view(
        self, name: str, image: object, rgb: NDArray[np.uint8], near: Window | None
    ) -> DetectorView:
        ours = self._ours[name]
        view = self._wanted(name, self._memo.get((image, name), lambda: ours.look(rgb)))
        if near is None:
            return view
        closer = self._memo.get((image, name, near), lambda: ours.look(part(rgb, near)))
        return joined_views(view, closer, near)

    def _named(
        self, name: str, image: object, rgb: NDArray[np.uint8], near: Window | None
    ) -> RawDetections:
        detector = self.detectors[name]
        key: tuple[object, ...] = image, name, self._classes
        if isinstance(detector, ClipDetector | GroundingDetector):
            key = *key, self._goal, self._way  # of others the answer is the same
        found = self._wanted(name, self._memo.get(key, lambda: detector.detect(rgb)))
        if near is None:
            return found
        closer = self._memo.get((*key, near), lambda: detector.detect(part(rgb, near)))
        return joined(found, closer, near)

    def _wanted(self, name: str, seen: Seen) -> Seen:
        """Without features, where another's are wanted."""
        ours = self._ours.get(name)
        if ours is None or self.features_from in ("", ours.sha256):
            return seen
        return seen._replace(features=NO_FEATURES)


class _Memo:
    """Results of the last `images` images, by any key that begins with what `of` gives."""

    def __init__(self) -> None:
        self.images = 0
        self._kept: dict[object, dict[object, Any]] = {}

    def of(self, rgb: NDArray[np.uint8]) -> object:
        """The image's key; the longest unused image is forgotten."""
        if not self.images:
            return None
        digest = hashlib.blake2b(rgb.tobytes(), digest_size=16).digest()
        self._kept[digest] = self._kept.pop(digest, {})  # the newest last
        while len(self._kept) > self.images:
            del self._kept[next(iter(self._kept))]
        return digest

    def get(self, key: tuple[object, ...], make: Callable[[], T]) -> T:
        kept = self._kept.get(key[0])
        if kept is None:
            return make()
        if key not in kept:
            kept[key] = make()
        found: T = kept[key]
        return found


_ABILITIES = ("open_vocabulary", "rooms", "embeddings")


def _regions(places: FusedPlaces, teller: int, said: RawDetections, view: DetectorView) -> Floats:
    """(P, D) what each place looks like: as our own detector has it, else as the region does that
    overlaps it most; 0 where it has seen nothing."""
    rows = np.zeros((len(places.labels), view.regions.shape[1]), np.float32)
    which = places.which[:, teller]
    rows[which >= 0] = said.embeddings[which[which >= 0]]
    others = np.flatnonzero(which < 0)
    if len(others):
        iou = pairwise_iou(places.boxes_px[others], view.boxes_px)
        best = iou.argmax(axis=1)
        near = iou[np.arange(len(others)), best] >= ONE_THING_IOU
        rows[others[near]] = view.regions[best[near]]
    return rows
