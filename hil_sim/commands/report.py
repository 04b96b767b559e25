"""`hil-sim report`: tables and figures of evaluations, put into a document."""

import json
from collections.abc import Sequence
from pathlib import Path

import click

from hil_sim.evaluation.report import brief, figures, fill, section
from hil_sim.evaluation.result_folder import Folder, read_folder
from runtime.errors import RfNavError


@click.command("report")
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Markdown document.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All figures as JSON.")
@click.option("--seed", default=0, show_default=True, help="Of the bootstrap intervals.")
@click.option(
    "--before",
    "earlier",
    type=click.Path(path_type=Path),
    help="An earlier run of the same suite, to be compared with.",
)
@click.option("--episode", "chosen", multiple=True, help="Draw these episodes' paths.")
@click.option("--no-pictures", is_flag=True, help="Tables only.")
@click.option("--brief", "short", is_flag=True, help="The main table of each, without pictures.")
def report_command(
    folders: tuple[Path, ...],
    out: Path,
    json_file: Path | None,
    seed: int,
    earlier: Path | None,
    chosen: tuple[str, ...],
    no_pictures: bool,
    short: bool,
) -> None:
    """Put tables and figures of evaluations (FOLDERS) into a document, whose other text is kept.

    \b
    Example: hil-sim report out/val out/labels --out out/report.md
    """
    document = out.read_text(encoding="utf-8") if out.is_file() else "# Results\n"
    read = [read_folder(path) for path in folders]
    before = _earlier(earlier, read) if earlier else {}
    for folder in read:
        pictures: list[tuple[str, str]] = []
        if not (no_pictures or short):
            from hil_sim.evaluation.report_pictures import (
                draw_all,  # matplotlib takes a second to import
            )

            pictures = draw_all(folder, out.parent, chosen)
        text = (brief(folder, seed) if short else
                section(folder, seed, pictures, before.get(folder.name)))  # fmt: skip
        document = fill(document, folder.name, text)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(document, encoding="utf-8")
    if json_file is not None:
        data = {folder.name: figures(folder, seed) for folder in read}
        json_file.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    click.echo(f"{out}: {', '.join(folder.name for folder in read)}")


def _earlier(path: Path, folders: Sequence[Folder]) -> dict[str, Folder]:
    """The earlier run, under the name of the folder that has the same episodes."""
    before = read_folder(path)
    same = {f.name: before for f in folders if f.run["episodes"] == before.run["episodes"]}
    if not same:
        raise RfNavError(f"{path}: other episodes; --before takes a run of the same suite")
    return same
