"""`python -m models.train.calibrate FILE --report JSON`: what was fitted, put into the file.

What `rfnav models evaluate` then reports of the file as it is, it has reported as "refitted"
before.
"""

import json
from pathlib import Path

import click
import onnx

from models.checksum import sha256
from models.detection.calibration import PREFIX, read_constants
from models.detection.detector import FORMAT, contract_of
from models.errors import ModelFileError, told
from models.onnx_session import open_session
from models.train.graph import constants, read_metadata, set_metadata


def calibrate(path: Path, report: Path) -> dict[str, float]:
    """Set gain and shift of an exported detector, of one that takes texts, or of one with a fixed
    list whose names are in the file. Raises ModelFileError for a file of no use."""
    try:
        fitted = json.loads(report.read_text(encoding="utf-8"))["calibration"]
        written = {PREFIX + key: str(float(fitted[key])) for key in ("gain", "shift")}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelFileError(
            f"{report}: not a report ({error}); write one with `rfnav models evaluate --json`"
        ) from error
    values = read_constants(written, report)
    try:
        model = onnx.load(str(path))
    except Exception as error:  # protobuf's exceptions and the system's
        raise ModelFileError(f"{path}: not a readable ONNX file ({error})") from error
    metadata = read_metadata(model)
    if metadata.get("format") != FORMAT and not _is_a_detector(path, "names" in metadata):
        raise ModelFileError(
            f"{path}: not an RF-NAV detector, nor one that takes texts or whose fixed list is in "
            "the file; export one with models.train.export"
        )
    set_metadata(model, constants(values))
    onnx.save(model, str(path))
    return values


def _is_a_detector(path: Path, named: bool) -> bool:
    contract = contract_of(open_session(path), path)
    return contract == "prompted" or (contract == "yolo" and named)


@click.command(
    epilog="Example:  python -m models.train.calibrate det.onnx --report evaluation.json"
)
@click.argument("path", type=click.Path(path_type=Path))
@click.option(
    "--report", type=click.Path(path_type=Path), required=True, help="Of rfnav models evaluate."
)
def main(path: Path, report: Path) -> None:
    """Put the gain and shift of an evaluation into an exported detector."""
    values = calibrate(path, report)
    digest = sha256(path)
    click.echo(
        f"{path}: gain {values['gain']:.3f} shift {values['shift']:.3f}, "
        f"{path.stat().st_size} bytes, sha256 {digest}"
    )


if __name__ == "__main__":
    told(main)
