"""`.sh3d` files that are not what they should be."""

import io
import struct
import zipfile
from pathlib import Path

import pytest
from drawn import CUBE, ROOMS, WALLS, piece, save, xml

from hil_sim.scenes.format import SceneError
from hil_sim.scenes.sweethome import archive
from hil_sim.scenes.sweethome.archive import Archive
from hil_sim.scenes.sweethome.importer import import_home


def refused(path: Path, *words: str) -> None:
    with pytest.raises(SceneError) as caught:
        import_home(path, path.parent / "out")
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    for word in words:
        assert word in message


def test_what_is_not_a_zip_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "home.sh3d"
    path.write_bytes(b"PK no zip at all")
    refused(path, "not a zip")
    refused(tmp_path / "absent.sh3d", "no such file")
    refused(tmp_path, "cannot be read")


def test_a_zip_without_a_drawing_is_refused(tmp_path: Path) -> None:
    refused(save(tmp_path / "home.sh3d", None, {"a.txt": b"x"}), "Home.xml", "not a Sweet Home 3D")


def test_an_old_file_says_how_to_save_it_again(tmp_path: Path) -> None:
    path = save(tmp_path / "old.sh3d", None, {"Home": b"\xac\xed\x00\x05"})
    refused(path, "Home.xml: missing", "save it with Sweet Home 3D 5.3 or newer")


def test_what_is_not_xml_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "home.sh3d"
    refused(save(path, b"<home><wall"), "Home.xml: not XML")
    refused(save(path, b"<house/>"), "Home.xml", "<house>")
    refused(save(path, b'<!DOCTYPE h [<!ENTITY a "aa">]><home>&a;</home>'), "entities")


def test_a_damaged_entry_is_refused_with_its_name(tmp_path: Path) -> None:
    path = save(tmp_path / "home.sh3d", xml(WALLS, ROOMS))
    data = bytearray(path.read_bytes())
    data[60:80] = bytes(20)
    path.write_bytes(data)
    refused(path, "Home.xml: damaged")


def test_an_encrypted_entry_is_refused(tmp_path: Path) -> None:
    path = save(tmp_path / "home.sh3d", xml(WALLS, ROOMS))
    data = bytearray(path.read_bytes())
    for signature, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = data.index(signature) + offset
        data[at : at + 2] = struct.pack("<H", 1)
    path.write_bytes(data)
    refused(path, "Home.xml: encrypted")


def test_what_unpacks_too_large_is_refused_unread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archive, "MAX_XML", 1 << 20)
    path = save(tmp_path / "bomb.sh3d", b" " * (3 << 20))
    assert path.stat().st_size < 10_000
    refused(path, "Home.xml: more than 1 MB")
    monkeypatch.setattr(archive, "MAX_MODEL", 1 << 20)
    home = xml(WALLS, ROOMS, piece("Chair", 100, 100, model="1/a.obj"))
    files = {"1/a.obj": CUBE.encode(), "1/b.bin": bytes(2 << 20)}
    refused(save(tmp_path / "home.sh3d", home, files), "1/a.obj: more than 1 MB")


def test_a_model_is_found_in_a_folder_alone_or_in_a_zip_of_its_own(tmp_path: Path) -> None:
    inner = io.BytesIO()
    with zipfile.ZipFile(inner, "w") as file:
        file.writestr("readme.txt", "x")
        file.writestr("sub/chair.obj", CUBE)
    files = {
        "1/chair.obj": CUBE.encode(), "1/chair.mtl": b"newmtl body\n", "2": CUBE.encode(),
        "3": inner.getvalue(), "4": b"<?xml version='1.0'?><COLLADA/>", "5/a b.obj": b"v 0 0 0\n",
    }  # fmt: skip
    with Archive(save(tmp_path / "home.sh3d", xml(WALLS), files)) as found:
        folder = found.model("1/chair.obj")
        assert folder is not None
        assert set(folder.files) == {"1/chair.obj", "1/chair.mtl"}
        kinds = [model.kind for n in "234" if (model := found.model(n))]
        assert kinds == ["obj", "obj", "unknown format"]
        nested = found.model("3")
        assert nested is not None
        assert nested.main == "sub/chair.obj"
        assert found.model("5/a%20b.obj") is not None
        assert found.model("jar:file:/elsewhere.jar!/chair.obj") is None
