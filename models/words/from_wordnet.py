"""`python -m models.words.from_wordnet DICT`: the table of household nouns, from WordNet 3.0.

DICT holds `data.noun`, `index.noun` and `noun.exc`: usr/share/wordnet in Debian's package
wordnet-base, unpacked. The same files give the same bytes.
"""

import gzip
import json
import re
from collections import Counter, defaultdict
from collections.abc import Container, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import click

from models.words.senses import PATH, key

GLOSS = 48  # characters that are kept of a definition
ARTIFACT, FOOD, PLANT = 6, 13, 20
"""WordNet's lexicographer files."""
KEPT = {
    ARTIFACT: (
        "instrumentality", "furnishing", "covering", "padding", "decoration", "creation", "fixture",
        "plaything", "toiletry", "commodity", "soap",
    ),
    FOOD: ("edible fruit", "vegetable", "bread", "egg", "salad"),
    PLANT: ("houseplant", "pot plant"),
}  # fmt: skip
LEFT_OUT = {
    ARTIFACT: (
        "aircraft", "ammunition", "animal trap", "antenna", "armor", "body armor", "building",
        "circuit", "coating", "conductor", "connection", "cosmetic", "damper", "detector", "drug",
        "electrical device", "electronic device", "engine", "fabric", "fastener", "filter", "flare",
        "garment", "gear", "harness", "hat", "machinery", "magnet", "masonry", "mechanism",
        "medical instrument", "medium", "memory device", "military uniform", "military vehicle",
        "motor", "optical device", "paint", "perfume", "pipe", "restraint", "rigging", "road",
        "roof", "rope", "sail", "scientific instrument", "ship", "structure", "surgical instrument",
        "tube", "vehicle", "vestment", "way", "weapon", "weaponry", "wheel", "wire", "writing",
    ),
    FOOD: (),
    PLANT: (),
}  # fmt: skip
BACK = (
    "baby buggy", "bathrobe", "bicycle", "binoculars", "boot", "candle", "compact disk", "cupboard",
    "curtain", "display", "fan", "fireplace", "heater", "keyboard", "lock", "loudspeaker", "mirror",
    "mouse", "piece of cloth", "rack", "radiator", "shoe", "slipper", "spectacles", "telephone",
    "television receiver", "water closet", "water faucet", "wheelchair",
)  # fmt: skip
"""Below what is left out, and at home after all."""


class Synset(NamedTuple):
    """One of WordNet's; `above` are offsets of its hypernyms."""

    file: int
    names: tuple[str, ...]
    above: tuple[str, ...]
    gloss: str


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), default=PATH, show_default=True)
def main(folder: Path, out: Path) -> None:
    """Write the table of household nouns."""
    synsets = read_synsets(_lines(folder / "data.noun"))
    kept = household(synsets)
    rows = table(synsets, kept)
    elsewhere = used_elsewhere(_lines(folder / "index.noun"), set(kept))
    known = {key(name) for names, _, _ in rows for name in names}
    pairs = [line.split()[:2] for line in _lines(folder / "noun.exc")]
    singular = {key(many): key(one) for many, one in pairs if key(one) in known}
    whole = {"senses": rows, "elsewhere": elsewhere, "singular": singular}
    text = json.dumps(whole, ensure_ascii=False, separators=(",", ":"))
    out.write_bytes(gzip.compress(text.encode(), 9, mtime=0))
    click.echo(f"{out}: {len(rows)} senses, {out.stat().st_size / 1000:.0f} kB")


def _lines(path: Path) -> list[str]:
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if not line.startswith(" ")]  # the licence


def used_elsewhere(lines: Iterable[str], kept: Container[str]) -> list[str]:
    """The words of `index.noun` that are mostly used for what is not kept, although for something
    kept, too: a dog is no andiron. Each has its synsets' offsets there, the most used first."""
    out = set()
    for line in lines:
        field = line.split()
        first, *rarer = field[-int(field[2]) :]
        if first not in kept and any(offset in kept for offset in rarer):
            out.add(key(field[0]))
    return sorted(out)


def read_synsets(lines: Iterable[str]) -> dict[str, Synset]:
    """Nouns of `data.noun`, by offset. wndb(5WN) describes the format."""
    out = {}
    for line in lines:
        data, gloss = line.split(" | ", 1)
        field = data.split()
        end = 4 + 2 * int(field[3], 16)
        names = tuple(name.replace("_", " ").lower() for name in field[4:end:2])
        pointers = [field[i : i + 3] for i in range(end + 1, end + 1 + 4 * int(field[end]), 4)]
        above = tuple(to for sign, to, part in pointers if sign == "@" and part == "n")
        out[field[0]] = Synset(int(field[1]), names, above, gloss.strip())
    return out


def household(synsets: Mapping[str, Synset]) -> list[str]:
    """Offsets of what may stand or lie in a home, in WordNet's order."""
    below = defaultdict(list)
    for offset, synset in synsets.items():
        for above in synset.above:
            below[above].append(offset)

    def under(words: Iterable[str], file: int) -> set[str]:
        roots = set(words)
        todo = [o for o, s in synsets.items() if s.file == file and not roots.isdisjoint(s.names)]
        found: set[str] = set()
        while todo:
            offset = todo.pop()
            if offset not in found:
                found.add(offset)
                todo += below[offset]
        return found

    kept: set[str] = set()
    for file in KEPT:
        kept |= under(KEPT[file], file) - under(LEFT_OUT[file], file)
    kept |= under(BACK, ARTIFACT)
    return [o for o in sorted(kept) if synsets[o].file in KEPT and synsets[o].above]


def table(
    synsets: Mapping[str, Synset], offsets: Iterable[str]
) -> list[tuple[list[str], str, list[int]]]:
    """(names, definition, rows of what it is a kind of). Only meanings that compete for a name have
    a definition: it is there to choose between them."""
    row = {offset: n for n, offset in enumerate(offsets)}
    shared = Counter(word for o in row for word in {key(name) for name in synsets[o].names})
    out = []
    for offset in row:
        synset = synsets[offset]
        competes = any(shared[key(name)] > 1 for name in synset.names)
        gloss = _shortened(synset.gloss) if competes else ""
        out.append((list(synset.names), gloss, [row[a] for a in synset.above if a in row]))
    return out


def _shortened(gloss: str) -> str:
    """The definition without examples and asides, to whole words."""
    plain = re.sub(r"\([^)]*\)", "", gloss.split(";")[0]).split('"')[0]
    return plain.strip()[:GLOSS].rsplit(" ", 1)[0] if len(plain) > GLOSS else plain.strip()


if __name__ == "__main__":
    main()
