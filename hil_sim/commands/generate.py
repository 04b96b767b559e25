"""`hil-sim generate`: write generated homes, and count what stands in them."""

import json
from collections import Counter
from pathlib import Path

import click

from hil_sim.scenes.format import Scene
from hil_sim.scenes.generated.home import draw_rooms, generate
from hil_sim.scenes.generated.layouts import FEWEST, MOST
from hil_sim.scenes.scene_file import save_scene

SPLITS = ("train", "val")


def parse_rooms(text: str) -> tuple[int, int]:
    """ "7" or "4-9" -> (fewest, most). BadParameter says what would be right."""
    low, dash, high = text.partition("-")
    if not low.isdecimal() or (dash and not high.isdecimal()):
        raise click.BadParameter(f"{text!r} is neither a number nor a range such as 4-9")
    first, last = int(low), int(high if dash else low)
    if not FEWEST <= first <= last <= MOST:
        raise click.BadParameter(f"{text!r} is not within {FEWEST}-{MOST}")
    return first, last


def table(homes: dict[str, list[Scene]]) -> str:
    """A Markdown table: objects by category, and in how many homes, for each split."""
    counts = {split: Counter(o.category for home in many for o in home.objects)
              for split, many in homes.items()}  # fmt: skip
    homes_with = {split: Counter(c for home in many for c in {o.category for o in home.objects})
                  for split, many in homes.items()}  # fmt: skip
    total = sum(counts.values(), Counter[str]())
    lines = ["| category | " + " | ".join(f"{s}: objects | homes" for s in homes) + " |",
             "|---|" + "---|---|" * len(homes)]  # fmt: skip
    for category, _ in sorted(total.items(), key=lambda row: (-row[1], row[0])):
        cells = [f"{counts[s][category]} | {homes_with[s][category]}" for s in homes]
        lines.append(f"| {category} | " + " | ".join(cells) + " |")
    cells = [f"{sum(counts[s].values())} | {len(homes[s])}" for s in homes]
    return "\n".join([*lines, "| all | " + " | ".join(cells) + " |"])


@click.command("generate")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="First seed.")
@click.option(
    "--rooms",
    callback=lambda _c, _p, text: parse_rooms(text),
    default=f"{FEWEST}-{MOST}",
    show_default=True,
    help="A number or a range.",
)
@click.option("--split", type=click.Choice([*SPLITS, "both"]), default="train", show_default=True)
@click.option("--count", type=click.IntRange(1), default=1, show_default=True, help="Seeds.")
@click.option("--out", type=click.Path(path_type=Path), help="File to write; several: a folder.")
@click.option("--json", "as_json", type=click.Path(path_type=Path), help="Counts as JSON.")
def generate_command(
    seed: int,
    rooms: tuple[int, int],
    split: str,
    count: int,
    out: Path | None,
    as_json: Path | None,
) -> None:
    """Draw homes by seed, check them, and print how many of what stand in them.

    \b
    Examples: hil-sim generate --seed 17 --split val --out home.json
              hil-sim generate --rooms 7-9 --count 50 --split both
    """
    low, high = rooms
    splits = SPLITS if split == "both" else (split,)
    several = count * len(splits) > 1
    if several and out and out.suffix == ".json":
        raise click.UsageError(f"--out {out}: for several homes name a folder")
    homes: dict[str, list[Scene]] = {
        which: [_home(number, which, low, high) for number in range(seed, seed + count)]
        for which in splits
    }
    for home in (home for many in homes.values() for home in many):
        if out:
            path = out / f"{home.name}.json" if several else out
            path.parent.mkdir(parents=True, exist_ok=True)
            save_scene(home, path)
            click.echo(f"{path}: {len(home.rooms)} rooms, {len(home.objects)} objects")
    click.echo(table(homes))
    if as_json:
        counts = {which: dict(sorted(Counter(o.category for home in many for o in home.objects)
                  .items())) for which, many in homes.items()}  # fmt: skip
        as_json.write_text(json.dumps(counts, indent=1) + "\n", encoding="utf-8")


def _home(seed: int, split: str, low: int, high: int) -> Scene:
    whole = (low, high) == (FEWEST, MOST)
    return generate(seed, split, None if whole else draw_rooms(seed, split, low, high))


if __name__ == "__main__":
    generate_command()
