"""The room head learns photographs' rooms and keeps what it said of renderings."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")


from models.train.names import load_names  # noqa: E402
from models.train.network import Network  # noqa: E402
from models.train.rooms import learn_rooms  # noqa: E402
from models.words.text_encoder import TextEncoder  # noqa: E402


def test_photographs_are_learned_and_renderings_kept(encoder: TextEncoder) -> None:
    torch.manual_seed(0)
    names, network = load_names(encoder.embed), Network().eval()
    width = next(network.room.parameters()).shape[1]
    middles = torch.randn(2, width)
    room = torch.arange(80) % 2
    photographs = middles[room] + 0.1 * torch.randn(80, width)
    renderings = torch.randn(64, width)
    rng, told = np.random.default_rng(0), []
    done = learn_rooms(network, (photographs, room), renderings, names, rng, told.append, 120)
    rows = names.draw_rooms(rng)
    with torch.no_grad():
        named = (done.embed_scene(photographs) @ rows.T).argmax(-1)
        kept = (done.embed_scene(renderings) * network.embed_scene(renderings)).sum(-1)
    assert float((named == room).float().mean()) > 0.95
    assert float(kept.mean()) > 0.9
    assert "renderings apart" in told[-1]
    before, after = network.state_dict(), done.state_dict()
    assert all(torch.equal(before[k], after[k]) for k in before if not k.startswith("room."))
