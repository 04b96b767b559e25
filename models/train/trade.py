"""`python -m models.train.trade`: what input size and 8 bits gain and cost, in one table.

Each size is exported in single precision and in 8 bits, judged on the same frames and timed.
"""

import json
from pathlib import Path
from typing import Any

import click
import cv2

from models.detection.detector import open_detector
from models.errors import ModelFileError, told
from models.evaluation.cost import measure_cost
from models.evaluation.measures import measure, tried
from models.evaluation.truth import read_truth, read_words
from models.store import manifest
from models.train.export import export
from models.train.graph import parse_size
from models.words.text_encoder import TextEncoder

DIRECTORY = click.Path(path_type=Path, exists=True)
SIZES = ("416x320", "512x384", "640x480")
HEAD = (
    "input", "bits", "HM3D", "RoboTHOR", "trained", "held out", "rooms", "false/1,000",
    "ms, 1 thread", "CPU ms", "ratio", "ms, 2 threads", "MB", "memory MB",
)  # fmt: skip


def row(size: str, bits: int, report: dict[str, Any]) -> tuple[str, ...]:
    """One variant's figures, in HEAD's order."""
    one, two = report["cost"]["threads_1"], report["cost"]["threads_2"]
    goals = [g["false_seen"] for g in report["goals"].values()]
    return (
        size,
        str(bits),
        *(f"{group['ap50']:.3f}" for group in report["groups"].values()),
        f"{report['room_top1']:.3f}",
        f"{sum(goals) / max(len(goals), 1):.1f}",
        f"{one['ms']:.1f}",
        f"{one['least_cpu_ms']:.1f}",
        f"{one['ratio']:.2f}",
        f"{two['ms']:.1f}",
        f"{report['cost']['bytes'] / 1e6:.1f}",
        f"{one['memory_mb']:.0f}",
    )


@click.command(
    epilog="Example:  python -m models.train.trade --checkpoint out/finished.pt --out out "
    "--data frames/val --dev frames/dev --int8 frames/train"
)
@click.option("--checkpoint", type=DIRECTORY, required=True)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="For the ONNX files.")
@click.option("--data", type=DIRECTORY, required=True, help="Frames to judge on.")
@click.option("--dev", type=DIRECTORY, required=True, help="Frames to fit thresholds on.")
@click.option("--int8", type=DIRECTORY, required=True, help="Training frames: ranges for 8 bits.")
@click.option("--size", "sizes", multiple=True, default=SIZES, show_default=True)
@click.option("--limit", type=click.IntRange(1), help="Only as many frames of each directory.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Figures as JSON.")
def main(
    checkpoint: Path, out: Path, data: Path, dev: Path, int8: Path, sizes: tuple[str, ...],
    limit: int | None, json_file: Path | None,
) -> None:  # fmt: skip
    """Export, judge and time a checkpoint at several sizes, in 32 and in 8 bits."""
    cv2.setNumThreads(1)
    encoder, words = TextEncoder(manifest.fetch("minilm")), read_words()
    truth, fitting = read_truth(data, limit), read_truth(dev, limit)
    calibrate = sorted((int8 / "images").glob("*.jpg"))
    if not calibrate:
        raise ModelFileError(f"{int8}: holds no images/*.jpg; render some with `hil-sim frames`")
    click.echo("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|")
    reports: dict[str, Any] = {}
    for size in sizes:
        for bits, images in ((32, ()), (8, calibrate)):
            path = out / f"{checkpoint.stem}-{size}-{bits}.onnx"
            export(checkpoint, path, None, parse_size(size), images)
            detector = open_detector(path, "auto", encoder, 1)
            report = measure(tried(detector, truth, fitting, words, encoder), words)
            report["cost"] = measure_cost([str(path)])
            reports[path.stem] = report
            click.echo("| " + " | ".join(row(size, bits, report)) + " |")
            if json_file:
                json_file.write_text(json.dumps(reports, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    told(main)
