"""WordNet's household nouns, and what is no table of them or word list."""

import gzip
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from models.errors import ModelFileError
from models.words.from_wordnet import main
from models.words.senses import PATH, Senses
from models.words.vocabulary import load_vocabulary


@pytest.fixture(scope="module")
def senses() -> Senses:
    return Senses()


def names_of(senses: Senses, word: str) -> set[str]:
    return {name for sense in senses(word) for name in sense.names}


def test_synonyms_share_a_sense(senses: Senses) -> None:
    assert "television" in names_of(senses, "telly")
    assert "trash can" in names_of(senses, "dustbin")
    assert "armchair" in names_of(senses, "arm chair")
    assert "ottoman" in names_of(senses, "pouffe")


def test_plurals_and_spelling(senses: Senses) -> None:
    assert senses("knives") == senses("knife") != ()
    assert senses("Boxes") == senses("box") != ()
    assert senses("shelves") == senses("shelf") != ()
    assert senses("wash-basin") == senses("washbasin") != ()


@pytest.mark.parametrize("word", ["qwertyuiop", "", "  ", "s", "ses", "猫", "democracy", "a" * 80])
def test_what_is_no_household_noun(senses: Senses, word: str) -> None:
    assert senses(word) == ()


def test_a_word_that_mostly_means_something_else_says_so(senses: Senses) -> None:
    assert not any(sense.common for sense in senses("dog"))
    assert all(sense.common for sense in senses("telly"))


def test_related_senses_point_at_each_other(senses: Senses) -> None:
    (recliner,) = senses("recliner")
    (armchair,) = senses("armchair")
    assert recliner.broader == (armchair.id,)
    assert recliner.id in armchair.narrower


@pytest.mark.parametrize(
    "content", [b"", b"no gzip", gzip.compress(b"{}", mtime=0), gzip.compress(b"[", mtime=0)]
)
def test_a_damaged_table_is_told_in_one_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "nouns.json.gz").write_bytes(content)
    with pytest.raises(ModelFileError, match="not a table of senses") as caught:
        Senses(tmp_path / "nouns.json.gz")
    assert "\n" not in str(caught.value)


DATA = """\
  1 a line of the licence
00000001 06 n 01 instrumentality 0 001 @ 00000009 n 0000 | what serves a purpose
00000002 06 n 02 sofa 0 Lounge_suite 0 001 @ 00000001 n 0000 | a seat (soft) for many; "sit down"
00000003 06 n 01 settee 0 001 @ 00000002 n 0000 | a small sofa
00000004 06 n 01 settee 0 001 @ 00000001 n 0000 | a bench
00000005 05 n 01 settee 0 001 @ 00000001 n 0000 | an animal
00000006 06 n 01 weapon 0 001 @ 00000001 n 0000 | what hurts
"""
INDEX = """\
  1 a line of the licence
settee n 3 1 @ 3 0 00000005 00000003 00000004
sofa n 1 1 @ 1 0 00000002
"""


def test_the_table_is_made_from_wordnets_own_files(tmp_path: Path) -> None:
    (tmp_path / "data.noun").write_text(DATA)
    (tmp_path / "index.noun").write_text(INDEX)
    (tmp_path / "noun.exc").write_text("sofae sofa\nmice mouse\n")
    out = tmp_path / "out.json.gz"
    result = CliRunner().invoke(main, [str(tmp_path), "--out", str(out)])
    assert result.exit_code == 0, result.output
    table = json.loads(gzip.decompress(out.read_bytes()))
    assert table["senses"] == [
        [["instrumentality"], "", []],
        [["sofa", "lounge suite"], "", [0]],
        [["settee"], "a small sofa", [1]],
        [["settee"], "a bench", [0]],
    ]
    assert (table["singular"], table["elsewhere"]) == ({"sofae": "sofa"}, ["settee"])
    made = Senses(out)
    assert [s.names for s in made("sofae")] == [("sofa", "lounge suite")]
    assert not made("settee")[0].common


def test_the_licence_is_beside_the_table() -> None:
    assert "Princeton University" in (PATH.parent / "LICENSE").read_text(encoding="utf-8")
    assert PATH.stat().st_size < 100_000


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("objects = [['sofa']]", "not a word list"),
        ("objects = ['sofa']\nrooms = ['hall']", "no list of names"),
        ("objects = [['sofa']]\nrooms = ['hall']\n[also]\nbed = ['cot']", "also.bed: no class"),
        (
            "objects = [['sofa'], ['bed']]\nrooms = ['hall']\n[also]\nsofa = ['divan', 'bed']",
            "also.sofa: 'bed' is bed, too",
        ),
        ("objects = [['bed']]\nrooms = ['hall']\n[kinds]\nbed = ['cot']", "kinds.bed: no class"),
        ("objects = 5\nrooms = ['hall']", "not a word list"),
        ("objects = [", "not a word list"),
    ],
)
def test_a_word_list_that_is_none_is_told_in_one_line(
    tmp_path: Path, content: str, told: str
) -> None:
    (tmp_path / "words.toml").write_text(content)
    with pytest.raises(ModelFileError, match=told) as caught:
        load_vocabulary(tmp_path / "words.toml")
    assert "\n" not in str(caught.value)
