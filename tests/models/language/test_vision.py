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
from mmproj import write_mmproj

from models.errors import ModelFileError
from models.language.vision import HANDLERS, VisionModel
from models.store import manifest

pytestmark = pytest.mark.slow  # a language model answers

GRAMMAR = r"""root ::= "{\"frontiers\": [" ( "2" | "5" ) "]}" """


def picture(bgr: tuple[int, int, int]) -> dict[str, Any]:
    data = cv2.imencode(".jpg", np.full((60, 80, 3), bgr, np.uint8))[1].tobytes()
    url = f"data:image/jpeg;base64,{base64.b64encode(data).decode()}"
    return {"type": "image_url", "image_url": {"url": url}}


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


def with_template(source: Path, target: Path, template: str) -> Path:
    """A copy of a GGUF with another chat template."""
    reader = gguf.GGUFReader(str(source))
    writer = gguf.GGUFWriter(str(target), reader.fields["general.architecture"].contents())
    for name, field in reader.fields.items():
        if name.startswith("GGUF.") or name == "general.architecture":
            continue
        value = template if name == "tokenizer.chat_template" else field.contents()
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
