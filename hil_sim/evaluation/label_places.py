"""Where words may stand in a picture without covering each other."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

CHARACTER_PT, LINE_PT = 4.4, 11.0  # of a label of 7 pt, with its frame
LABEL_PT = 7.0

Extent = tuple[float, float, float, float]  # x from, to, y from, to, m
Point = tuple[float, float]


@dataclass
class LabelPlaces:
    """`window`: what of the plane the picture shows; `point_m`: metres to a point of the page."""

    window: Extent
    point_m: float
    taken: list[Extent] = field(default_factory=list)

    def first(
        self, spots: Iterable[Sequence[float]], text: str, size_pt: float = LABEL_PT
    ) -> Point | None:
        """The first of these middles, m, where the words fit, which is taken then; None where all
        are covered, or outside."""
        for xy in spots:
            place = self._place(xy, text, size_pt)
            if self._inside(place) and not any(_meet(place, other) for other in self.taken):
                self.taken.append(place)
                return float(xy[0]), float(xy[1])
        return None

    def keep(self, xy: Sequence[float], text: str, size_pt: float = LABEL_PT) -> None:
        """What stands there whatever else does."""
        self.taken.append(self._place(xy, text, size_pt))

    def _place(self, xy: Sequence[float], text: str, size_pt: float) -> Extent:
        scale_m = self.point_m * size_pt / LABEL_PT / 2
        half_x, half_y = len(text) * CHARACTER_PT * scale_m, LINE_PT * scale_m
        return xy[0] - half_x, xy[0] + half_x, xy[1] - half_y, xy[1] + half_y

    def _inside(self, place: Extent) -> bool:
        x0, x1, y0, y1 = self.window
        return x0 <= place[0] and place[1] <= x1 and y0 <= place[2] and place[3] <= y1


def _meet(a: Extent, b: Extent) -> bool:
    return a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]
