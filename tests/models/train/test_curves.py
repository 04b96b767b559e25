from pathlib import Path

import cv2
import pytest

from models.errors import ModelFileError
from models.train.curves import draw, read_log, smooth

HEAD = "step,epoch,spent_s,pace,total,objectness,box,words,room,frames_per_s"


def test_a_log_becomes_a_picture(tmp_path: Path) -> None:
    rows = [f"{20 * i},0,{i},1.0,5,{1 / i},0.3,2.0,1.5,9.1" for i in range(1, 40)]
    (tmp_path / "log.csv").write_text("\n".join([HEAD, *rows]))
    log = read_log(tmp_path / "log.csv")
    assert log["objectness"][:2] == [1.0, 0.5]
    draw(log, tmp_path / "curves.png")
    assert cv2.imread(str(tmp_path / "curves.png")).std() > 0


def test_a_point_is_the_mean_of_what_came_before() -> None:
    assert smooth([4.0, 2.0, 0.0], span=2) == [4.0, 3.0, 1.0]


def test_another_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ModelFileError, match=r"log.csv: not the log"):
        read_log(tmp_path / "log.csv")
