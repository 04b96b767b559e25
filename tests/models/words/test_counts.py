"""The table of counts that comes with the project, and files that are none."""

import json
from pathlib import Path
from typing import Any

import pytest

from models.errors import ModelFileError
from models.words.counts import PATH, load_counts

SMALL: dict[str, Any] = {
    "names": ["mug", "bed", "piano"],
    "rooms": ["kitchen", "study"],
    "counts": {
        "public": {
            "rooms": [2, 0],
            "things": [3, 1, 0],
            "holding": [[2, 0], [1, 0], [0, 0]],
            "beside": [[1, 0, 0], [0, 0, 0], [0, 0, 0]],
            "doors": [[0, 0], [0, 0]],
        }
    },
}


def written(tmp_path: Path, **changes: Any) -> Path:
    table = json.loads(json.dumps(SMALL))
    table["counts"]["public"].update(changes)
    path = tmp_path / "counts.json"
    path.write_text(json.dumps(table), encoding="utf-8")
    return path


def test_what_was_not_counted_is_left_out(tmp_path: Path) -> None:
    (found,) = load_counts(written(tmp_path))
    assert found.rooms == {"kitchen": 2}
    assert found.things == {"mug": 3, "bed": 1}
    assert found.holding == {"mug": {"kitchen": 2}, "bed": {"kitchen": 1}}
    assert found.beside == {"mug": {"mug": 1}, "bed": {}}
    assert found.doors == {}


@pytest.mark.parametrize(
    "changes",
    [
        {"rooms": [1]},
        {"things": [1, 2, -3]},
        {"things": [1.5, 0, 0]},
        {"holding": [[1, 0]]},
        {"beside": "none"},
        {"doors": None},
    ],
)
def test_a_table_that_is_none_says_so(tmp_path: Path, changes: dict[str, Any]) -> None:
    path = written(tmp_path, **changes)
    with pytest.raises(ModelFileError, match=r"counts\.json: not a table of counts"):
        load_counts(path)


def test_no_file_says_so(tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="reinstall rf-nav"):
        load_counts(tmp_path / "none.json")


def test_the_table_of_the_project_names_its_source_and_knows_homes() -> None:
    source = json.loads(PATH.read_text(encoding="utf-8"))["source"]
    assert "Apache-2.0" in source["public"]
    assert "train-900000" in source["generated"]
    assert PATH.stat().st_size < 200_000
    public, generated = load_counts()
    assert public.rooms == dict.fromkeys(("kitchen", "bathroom", "bedroom", "living room"), 30)
    assert set(generated.rooms) > set(public.rooms)
    for count in (public, generated):
        assert count.holding["toilet"]["bathroom"] > 0.9 * count.rooms["bathroom"]
        assert count.holding["toilet"]["kitchen"] == 0
