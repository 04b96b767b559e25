"""What an answer costs where not everything is boxed."""

import zlib
from collections.abc import Sequence

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from models.train.data import Batch  # noqa: E402
from models.train.losses import UNBOXED, answers, loss, word_loss  # noqa: E402
from models.train.names import load_names  # noqa: E402
from models.train.network import Network, Raw  # noqa: E402
from models.train.targets import make_grid  # noqa: E402

SIZE = 64


def embed(texts: Sequence[str]) -> np.ndarray:
    rows = [np.random.default_rng(zlib.crc32(t.encode())).standard_normal(384) for t in texts]
    return np.stack([r / np.linalg.norm(r) for r in rows]).astype(np.float32)


NAMES = load_names(embed)


def batch(boxed: bool, surety: float = 1.0, boxes: int = 1) -> Batch:
    known = torch.full((1, len(NAMES.categories)), float(boxed))
    return Batch(
        image=torch.rand(1, 3, SIZE, SIZE) * 255,
        boxes=[torch.tensor([[8.0, 8, 40, 40]])[:boxes]],
        labels=[torch.zeros(boxes, dtype=torch.long)],
        ignore=[torch.zeros(boxes, dtype=torch.bool)],
        surety=[torch.full((boxes,), surety)],
        room=torch.tensor([-1]),
        boxed=known,
    )


def raw() -> Raw:
    grid = make_grid(SIZE, SIZE)
    boxes = torch.cat((grid.centre - 16, grid.centre + 16), 1)[None]
    torch.manual_seed(0)
    count = boxes.shape[1]
    return Raw(boxes, torch.randn(1, count), torch.randn(1, count, 96), torch.randn(1, 832))


def test_empty_places_of_partly_boxed_frames_cost_less() -> None:
    torch.manual_seed(0)
    network, said = Network(), raw()
    whole, part = (
        loss(network, said, batch(known, boxes=0), make_grid(SIZE, SIZE), NAMES,
             np.random.default_rng(0))
        for known in (True, False)
    )  # fmt: skip
    assert float(part.objectness.detach() / whole.objectness.detach()) == pytest.approx(UNBOXED)
    assert float(whole.words.detach()) > 0
    assert float(part.words.detach()) == 0.0


def test_an_empty_place_must_resemble_no_word_as_far_as_that_is_boxed() -> None:
    torch.manual_seed(0)
    network, count = Network(), len(NAMES.categories)
    regions = torch.randn(1, 96).requires_grad_()
    known = torch.zeros(1, count)
    known[0, 5] = 0.5
    rows = NAMES.draw(np.random.default_rng(0))
    args = (torch.tensor([-1]), torch.ones(1), known, rows, NAMES.compare[:1])
    logit = network.embed(regions) @ rows[5] * network.log_scale.exp() + network.bias
    assert float(word_loss(network, regions, *args).detach()) == pytest.approx(
        float(0.5 * torch.nn.functional.softplus(logit).detach()), rel=1e-3
    )


def test_an_answer_is_no_better_than_its_box_is_sure() -> None:
    grid, said = make_grid(SIZE, SIZE), raw()
    (sure,) = answers(said, batch(True), grid)
    (unsure,) = answers(said, batch(True, 0.5), grid)
    assert (sure.owner >= 0).any()
    assert torch.equal(unsure.owner, sure.owner)
    assert torch.allclose(unsure.quality, 0.5 * sure.quality)
