"""A model that sees, end to end with random weights: what the picture shows reaches the answer."""

import base64
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import gguf
import numpy as np
import pytest
from mmproj import TILE_MARKS, write_mmproj

from models.errors import ModelFileError
from models.language.pictures import TOKENS
from models.language.vision import HANDLERS, VisionModel
from models.store import manifest

pytestmark = pytest.mark.slow  # a language model answers

GRAMMAR = r"""root ::= "{\"frontiers\": [" ( "2" | "5" ) "]}" """


def picture(bgr: tuple[int, int, int]) -> dict[str, Any]:
    data = cv2.imencode(".jpg", np.full((60, 80, 3), bgr, np.uint8))[1].tobytes()
    url = f"data:image/jpeg;base64,{base64.b64encode(data).decode()}"
    return {"type": "image_url", "image_url": {"url": url}}


def data(part: dict[str, Any]) -> bytes:
    """The file that a picture's part shows."""
    return base64.b64decode(part["image_url"]["url"].partition(",")[2])


def asked(*parts: Any) -> list[dict[str, Any]]:
    told = [{"type": "text", "text": p} if isinstance(p, str) else p for p in parts]
    return [{"role": "user", "content": told}]


RED, BLUE = picture((0, 0, 255)), picture((255, 0, 0))


@pytest.fixture(scope="module")
def projector(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_mmproj(tmp_path_factory.mktemp("vision") / "mmproj.gguf")


@pytest.fixture(scope="module")
def model(projector: Path) -> Iterator[VisionModel]:
    model = VisionModel(
        manifest.fetch("smollm2-135m"), projector, "llava-1.5", threads=1, context=512
    )
    yield model
    model.close()


def test_another_picture_is_another_answer(
    model: VisionModel, capfd: pytest.CaptureFixture[str]
) -> None:
    question = "Is it a bathroom? Answer yes or no."
    red, blue = model.likes(asked(RED, question)), model.likes(asked(BLUE, question))
    assert red != blue
    assert model.likes(asked(RED, question)) == red
    assert capfd.readouterr().err == ""


def test_several_pictures_in_one_question(model: VisionModel) -> None:
    message = asked("Frontier 2:", RED, "Frontier 5:", BLUE, "Where to?")
    assert json.loads(model.reply(message, GRAMMAR, max_tokens=30))["frontiers"] in ([2], [5])


def test_what_is_encoded_before_is_answered_as_what_is_not(
    model: VisionModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    import llama_cpp.mtmd_cpp as mtmd

    question = "Is it a bathroom? Answer yes or no."
    alone = [model.likes(asked(p, question)) for p in (RED, BLUE)]
    both = model.reply(asked(RED, BLUE, question), GRAMMAR, max_tokens=30)
    encoded = [model.encode(data(p)) for p in (RED, BLUE)]
    monkeypatch.setattr(mtmd, "mtmd_helper_eval_chunk_single", None)  # it would encode
    assert [model.likes(asked(p, question), pictures=encoded) for p in (RED, BLUE)] == alone
    assert model.reply(asked(RED, BLUE, question), GRAMMAR, 30, pictures=encoded) == both
    assert encoded[0].nbytes == encoded[0].parts[0].size * 4 > 0
    with pytest.raises(ModelFileError, match="what should be a picture is none"):
        model.encode(b"no picture")


def test_handlers_are_those_of_the_binding() -> None:
    from llama_cpp import llama_chat_format

    for name in HANDLERS.values():
        assert callable(getattr(llama_chat_format, name))


def test_parts_that_do_not_go_together_are_refused(projector: Path, tmp_path: Path) -> None:
    text = manifest.fetch("smollm2-135m")
    with pytest.raises(ModelFileError, match=r"by handler 'mtmd': cannot see \(.*its family's$"):
        VisionModel(text, projector, "mtmd")  # its chat template knows no pictures
    other = write_mmproj(tmp_path / "other.gguf", text_width=64)
    with pytest.raises(ModelFileError, match="cannot see") as error:
        VisionModel(text, other, "llava-1.5")
    assert "\n" not in str(error.value)
    with pytest.raises(ModelFileError, match="no such mmproj file"):
        VisionModel(text, tmp_path / "none.gguf", "llava-1.5")
    with pytest.raises(ModelFileError, match="vision handler clip: unknown; known are mtmd"):
        VisionModel(text, projector, "clip")


TEMPLATE = (
    "{% for m in messages %}<|im_start|>{{ m.role }}\n{% if m.content is string %}{{ m.content }}"
    "{% else %}{% for p in m.content %}{{ p.text }}{% endfor %}{% endif %}<|im_end|>\n"
    "{% endfor %}{% if add_generation_prompt %}<|im_start|>assistant\n{% endif %}"
)


@pytest.mark.slow
def test_a_chat_template_with_pictures_is_followed(projector: Path, tmp_path: Path) -> None:
    """MTMDChatHandler, on the same model with a template that takes lists of parts."""
    path = with_template(manifest.fetch("smollm2-135m"), tmp_path / "text.gguf", TEMPLATE)
    model = VisionModel(path, projector, "mtmd", threads=1, context=512)
    assert model.likes(asked(RED, "Red?")) != model.likes(asked(BLUE, "Red?"))
    model.close()


@pytest.mark.slow
def test_a_picture_in_tiles_is_shown_as_a_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As SmolVLM2 shows it: five times 16 tokens are too many, and 16 of them do."""
    text = with_template(manifest.fetch("smollm2-135m"), tmp_path / "t.gguf", TEMPLATE, TILE_MARKS)
    projector = write_mmproj(tmp_path / "tiled.gguf", kind="idefics3")
    model = VisionModel(text, projector, "mtmd", threads=1, context=512)
    heard = listened(model, monkeypatch)
    encoded = model.encode(data(RED))
    assert [part.shape for part in encoded.parts] == [(16, 576)]
    alone = model.likes(asked(RED, "Red?"))
    before, after = heard[1], heard[2]
    assert (heard[0], before) == ("<|im_start|>user\n", "\n\n" + "".join(TILE_MARKS[:2]))
    assert after.startswith(TILE_MARKS[0] + "Red?")
    assert model.likes(asked(RED, "Red?"), pictures=[encoded]) == alone
    model.close()


@pytest.mark.slow
def test_a_picture_of_many_pixels_is_few_tokens(tmp_path: Path) -> None:
    """A tower that would make 234 tokens of it."""
    text, projector = manifest.fetch("smollm2-135m"), tmp_path / "many.gguf"
    write_mmproj(projector, kind="lfm2")
    model = VisionModel(
        with_template(text, tmp_path / "text.gguf", TEMPLATE), projector, "mtmd", context=512
    )
    large = cv2.imencode(".jpg", np.zeros((480, 640, 3), np.uint8))[1].tobytes()
    (part,) = model.encode(large).parts
    assert TOKENS[0] <= len(part) <= TOKENS[1]
    model.close()


def listened(model: VisionModel, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The texts that its language model is given from here on."""
    heard: list[str] = []
    llama = model._llama
    given = llama.eval

    def listen(tokens: Any) -> None:
        heard.append(llama.detokenize(list(tokens), special=True).decode())
        given(tokens)

    monkeypatch.setattr(llama, "eval", listen)
    return heard


def with_template(source: Path, target: Path, template: str, words: tuple[str, ...] = ()) -> Path:
    """A copy of a GGUF with another chat template, and `words` in place of some of its special
    tokens that nobody uses."""
    reader = gguf.GGUFReader(str(source))
    writer = gguf.GGUFWriter(str(target), reader.fields["general.architecture"].contents())
    for name, field in reader.fields.items():
        if name.startswith("GGUF.") or name == "general.architecture":
            continue
        value = template if name == "tokenizer.chat_template" else field.contents()
        if name == "tokenizer.ggml.tokens":
            value = [*value[:3], *words, *value[3 + len(words) :]]
        kind = field.types[0]
        sub = field.types[-1] if kind == gguf.GGUFValueType.ARRAY else None
        writer.add_key_value(name, value, kind, sub_type=sub)
    for tensor in reader.tensors:
        writer.add_tensor(tensor.name, tensor.data, raw_dtype=tensor.tensor_type)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()
    return target
