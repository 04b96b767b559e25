"""`hil-sim counts`: count what stands in which room and what near what, for the experts."""

import json
from pathlib import Path
from typing import Any

import click


@click.command(
    "counts", epilog="Example:  hil-sim counts --homes 600 --out models/words/counts.json"
)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="File to write.")
@click.option("--homes", default=600, show_default=True, type=click.IntRange(1),
              help="Generated homes that are counted, beside 120 public rooms.")  # fmt: skip
def counts_command(out: Path, homes: int) -> None:
    """Count what stands in which room, what near what, and what doors lead to, over public rooms
    and generated train homes that nothing is judged by. Two minutes."""
    from tqdm import tqdm

    from hil_sim.importers.standing_counts import counted, train_homes

    scenes = tqdm(train_homes(homes), total=homes, unit="home", disable=None)
    table = counted(scenes, homes)
    out.write_text(_as_text(table), encoding="utf-8")
    click.echo(f"{out}: {len(table['names'])} things, {out.stat().st_size / 1000:.0f} kB")


def _as_text(table: dict[str, Any]) -> str:
    """JSON with one thing's counts a line."""
    head = {k: v for k, v in table.items() if k != "counts"}
    lines = [json.dumps(head, indent=1)[:-2] + ",", ' "counts": {']
    for n, (kind, parts) in enumerate(table["counts"].items()):
        lines.append(f"  {json.dumps(kind)}: {{")
        rows = [f"   {json.dumps(name)}: {_packed(value)}" for name, value in parts.items()]
        lines.append(",\n".join(rows))
        lines.append("  }," if n + 1 < len(table["counts"]) else "  }")
    return "\n".join([*lines, " }", "}"]) + "\n"


def _packed(value: list[Any]) -> str:
    if value and isinstance(value[0], list):
        rows = (json.dumps(row, separators=(",", ":")) for row in value)
        return "[\n" + ",\n".join(rows) + "\n   ]"
    return json.dumps(value, separators=(",", ":"))
