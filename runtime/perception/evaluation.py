"""`python -m runtime.perception.evaluation --data DIR`: how well a detector does on labelled frames.

Average precision at IoU 0.5 by pycocotools, in groups; names that training never saw; what was held
out of training, with a second look; rooms; what scores are worth, and the threshold for "target
seen"; what a frame costs. Calibration and threshold are fitted on the frames of --dev and reported
on those of --data.
"""

import json
from pathlib import Path

import click
import cv2

from models.detection.detector import open_detector
from models.detection.second_look import SecondLook
from models.errors import told
from models.evaluation.cost import measure_cost
from models.evaluation.measures import measure
from models.evaluation.report import markdown
from models.evaluation.sheet import draw_sheet
from models.evaluation.truth import read_truth, read_words
from models.store import manifest
from models.words.text_encoder import TextEncoder

FILE = click.Path(path_type=Path)


@click.command(
    epilog="Example:  python -m runtime.perception.evaluation --data frames/val --dev frames/dev"
)
@click.option("--data", type=FILE, required=True, help="Frames to judge on.")
@click.option("--dev", type=FILE, help="Frames to fit calibration and threshold on.")
@click.option("--detector", type=FILE, help="ONNX file; default: the project's.")
@click.option("--second-look", type=FILE, help="Its classifier; default: the project's.")
@click.option("--limit", type=click.IntRange(1), help="Only as many frames of each directory.")
@click.option("--threads", default=2, show_default=True)
@click.option("--cost/--no-cost", default=True, show_default=True, help="Time it, too.")
@click.option("--synonyms/--no-synonyms", default=True, show_default=True)
@click.option("--sheet", type=FILE, help="Draw detections of some frames here (PNG), and no more.")
@click.option("--json", "json_file", type=FILE, help="Write the figures here.")
def main(
    data: Path, dev: Path | None, detector: Path | None, second_look: Path | None,
    limit: int | None, threads: int, cost: bool, synonyms: bool, sheet: Path | None,
    json_file: Path | None,
) -> None:  # fmt: skip
    """Measure a detector on labelled frames."""
    cv2.setNumThreads(1)
    encoder, words = TextEncoder(manifest.fetch("minilm")), read_words()
    path = detector or manifest.fetch("rfnav-det")
    truth = read_truth(data, limit)
    opened = open_detector(path, "auto", encoder, threads)
    if sheet is not None:
        draw_sheet(opened, truth, words, sheet)
        click.echo(f"{sheet}: detections of {path.name} on {data}")
        return
    fitting = read_truth(dev, limit) if dev else None
    looks = second_look or manifest.fetch("second-look")
    second = SecondLook(looks, encoder, threads)
    report = measure(opened, truth, fitting, words, encoder, synonyms, second)
    if cost:
        report["cost"] = measure_cost(path, looks)
    click.echo(markdown(report))
    if json_file:
        json_file.write_text(json.dumps(report, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    told(main)
