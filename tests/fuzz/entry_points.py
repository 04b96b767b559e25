"""Where bytes from outside become values: what is fuzzed, by Hypothesis in the tests beside this
file and by atheris in scripts/fuzz. Each entry is given bytes, and may raise nothing."""

import json

from answers import REFUSALS, EntryPoint, refused
from doctor_entries import heard, told
from drawn import ROOMS, WALLS, door, text, xml
from file_entries import (
    MODELS,
    TEXTS,
    WORDS,
    a_drawing,
    a_gguf,
    a_journal,
    an_onnx,
    configuration,
    database_of,
    drawing,
    drawing_xml,
    embeddings,
    gguf_head,
    goals,
    journal,
    manifest,
    onnx_head,
    recording,
    scene,
    scores,
    shortened,
    some_embeddings,
    some_goals,
    some_scores,
    some_spending,
    some_zones,
    spending,
    vocabulary,
    zones,
)
from image_entries import images, pictures
from kept_entries import A_MEMORY, PLACE_QUERIES, SOME_PLACES, memory, places
from places import TESTS
from robot_entries import GOALS, HARNESS, QUERY_KINDS, ZONES, mavlink, messages, numbered, request
from ros_entry import ros, seeds
from rover_bytes import SEEDS

GOAL = QUERY_KINDS.index("goal")
ASKED = (*range(len(QUERY_KINDS)), HARNESS | GOAL)
__all__ = ["ENTRY_POINTS", "REFUSALS"]

ENTRY_POINTS: dict[str, EntryPoint] = {
    "messages": EntryPoint(numbered(), messages),
    "images": EntryPoint(pictures(), images),
    "mavlink": EntryPoint(SEEDS, mavlink),
    "doctor": EntryPoint(told(), heard),
    "requests": EntryPoint(
        [
            *(bytes((n,)) + json.dumps(body).encode() for n in ASKED for body in GOALS),
            *(bytes((QUERY_KINDS.index("zones"),)) + json.dumps(body).encode() for body in ZONES),
            *(
                bytes((QUERY_KINDS.index("places"),)) + json.dumps(b).encode()
                for b in PLACE_QUERIES
            ),
        ],
        request,
    ),
    "ros": EntryPoint(seeds(), lambda data: ros(data, refused)),
    "configuration": EntryPoint(TEXTS, configuration),
    "scenes": EntryPoint(((TESTS / "refs" / "flat.json").read_bytes(),), scene),
    "manifest": EntryPoint((MODELS,), manifest),
    "vocabulary": EntryPoint((WORDS,), vocabulary),
    "onnx": EntryPoint((an_onnx(),), onnx_head),
    "gguf": EntryPoint((a_gguf(),), gguf_head),
    "goals": EntryPoint((some_goals(),), goals),
    "memories": EntryPoint((A_MEMORY,), memory),
    "places": EntryPoint((SOME_PLACES,), places),
    "journals": EntryPoint((a_journal(),), journal),
    "recordings": EntryPoint((shortened(TESTS / "refs" / "lockstep.mcap"),), recording, True),
    "sh3d": EntryPoint((a_drawing(),), drawing, True),
    "sh3d drawings": EntryPoint(
        (xml(WALLS, ROOMS, door(400, 200), text("Bath", 200, 200)),), drawing_xml, True
    ),
    "zones": EntryPoint((some_zones(),), zones, True),
    "scores": EntryPoint((database_of(some_scores),), scores, True),
    "spending": EntryPoint((database_of(some_spending),), spending, True),
    "embeddings": EntryPoint((some_embeddings(),), embeddings, True),
}
