"""A tiny image projector with random weights, for the text model of the tests: it shows that images
go all the way, and its answers mean nothing."""

from pathlib import Path

import gguf
import numpy as np

SIZE, PATCH, WIDTH, LAYERS, HEADS = 56, 14, 32, 2, 2
TILE_PATCH, SHUFFLE = 7, 2  # 64 patches a tile, four of which are one token
TILE_MARKS = (
    "<fake_token_around_image>",
    "<global-img>",
    *(f"<row_{row}_col_{col}>" for row in (1, 2) for col in (1, 2)),
)
"""What a text model with a tiled tower has words for."""


def write_mmproj(path: Path, text_width: int = 576, seed: int = 0, kind: str = "mlp") -> Path:
    """A LLaVA-style CLIP tower (2 layers of 32) and MLP projector into `text_width`; of kind
    "idefics3" it shows a picture as four tiles and a whole of 16 tokens each, of kind "lfm2" as so
    many tokens as it has pixels for."""
    shuffled = kind != "mlp"
    rng = np.random.default_rng(seed)

    def random(*shape: int) -> np.ndarray:
        return rng.normal(0.0, 0.2, shape).astype(np.float32)

    patch = TILE_PATCH if shuffled else PATCH
    writer = gguf.GGUFWriter(str(path), "clip")
    writer.add_bool("clip.has_vision_encoder", True)
    writer.add_bool("clip.has_text_encoder", False)
    writer.add_bool("clip.use_gelu", True)
    writer.add_string("clip.projector_type", kind)
    writer.add_file_type(gguf.LlamaFileType.ALL_F32)
    for key, value in {
        "image_size": SIZE,
        "patch_size": patch,
        "embedding_length": WIDTH,
        "feed_forward_length": 2 * WIDTH,
        "projection_dim": text_width,
        "block_count": LAYERS,
        "attention.head_count": HEADS,
        **({"projector.scale_factor": SHUFFLE, "preproc_image_size": 2 * SIZE} if shuffled else {}),
    }.items():
        writer.add_uint32(f"clip.vision.{key}", value)
    writer.add_float32("clip.vision.attention.layer_norm_epsilon", 1e-5)
    writer.add_array("clip.vision.image_mean", [0.5, 0.5, 0.5])
    writer.add_array("clip.vision.image_std", [0.25, 0.25, 0.25])
    tensors = {
        "v.patch_embd.weight": random(WIDTH, 3, patch, patch),
        "v.position_embd.weight": random((SIZE // patch) ** 2 + (not shuffled), WIDTH),
    }
    if kind == "idefics3":
        tensors["mm.model.fc.weight"] = random(text_width, WIDTH * SHUFFLE**2)
    elif kind == "lfm2":
        tensors |= {
            "mm.1.weight": random(WIDTH, WIDTH * SHUFFLE**2),
            "mm.1.bias": random(WIDTH),
            "mm.2.weight": random(text_width, WIDTH),
            "mm.2.bias": random(text_width),
        }
        for part in ("weight", "bias"):
            tensors[f"mm.input_norm.{part}"] = random(WIDTH * SHUFFLE**2)
    else:
        tensors |= {
            "v.class_embd": random(WIDTH),
            "mm.0.weight": random(text_width, WIDTH),
            "mm.0.bias": random(text_width),
            "mm.2.weight": random(text_width, text_width) * 0.1,
            "mm.2.bias": random(text_width),
        }
    for norm in ("v.post_ln",) if shuffled else ("v.pre_ln", "v.post_ln"):
        tensors |= {f"{norm}.weight": np.ones(WIDTH, np.float32), f"{norm}.bias": random(WIDTH)}
    for n in range(LAYERS):
        for part in ("attn_q", "attn_k", "attn_v", "attn_out"):
            tensors[f"v.blk.{n}.{part}.weight"] = random(WIDTH, WIDTH)
            tensors[f"v.blk.{n}.{part}.bias"] = random(WIDTH)
        for part in ("ln1", "ln2"):
            tensors[f"v.blk.{n}.{part}.weight"] = np.ones(WIDTH, np.float32)
            tensors[f"v.blk.{n}.{part}.bias"] = random(WIDTH)
        tensors[f"v.blk.{n}.ffn_up.weight"] = random(2 * WIDTH, WIDTH)
        tensors[f"v.blk.{n}.ffn_up.bias"] = random(2 * WIDTH)
        tensors[f"v.blk.{n}.ffn_down.weight"] = random(WIDTH, 2 * WIDTH)
        tensors[f"v.blk.{n}.ffn_down.bias"] = random(WIDTH)
    for name, value in tensors.items():
        writer.add_tensor(name, value)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()
    return path
