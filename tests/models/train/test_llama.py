"""A GGUF file in torch answers as it does in llama.cpp."""

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from models.errors import ModelFileError  # noqa: E402
from models.language.gguf import load  # noqa: E402
from models.store import manifest  # noqa: E402
from models.train.llama import FrozenLlama  # noqa: E402


@pytest.mark.slow
def test_what_follows_a_text_is_what_llama_cpp_says() -> None:
    torch.set_num_threads(1)
    path = manifest.fetch("smollm2-135m")
    mine, theirs = FrozenLlama(path), load(path, 1, n_ctx=32, logits_all=True)
    for text in ("In the kitchen there is a stove and a", "The capital of France is"):
        ids = theirs.tokenize(text.encode(), add_bos=False, special=False)
        theirs.reset()
        theirs.eval(ids)
        told = np.array(theirs.scores[len(ids) - 1])
        with torch.no_grad():
            said = (mine.last(mine.embedding[ids][None]) @ mine.embedding.T)[0].numpy()
        assert np.corrcoef(told, said)[0, 1] > 0.998
        assert told.argmax() == said.argmax()


def test_another_architecture_is_refused(tmp_path: Path) -> None:
    from gguf import GGUFWriter

    writer = GGUFWriter(str(tmp_path / "x.gguf"), "gpt2")
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.close()
    with pytest.raises(ModelFileError, match="architecture gpt2"):
        FrozenLlama(tmp_path / "x.gguf")
