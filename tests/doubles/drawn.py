"""A small home as Sweet Home 3D would save it, for the tests here to change."""

import zipfile
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

CUBE = """\
mtllib cube.mtl
v -1 0 -2
v 1 0 -2
v 1 0 2
v -1 0 2
v -1 6 -2
v 1 6 -2
v 1 6 2
v -1 6 2
usemtl body
f 1 2 3 4
f 5 8 7 6
f 1 5 6 2
f 2 6 7 3
usemtl front
f 3 7 8 4
usemtl body
f 4 8 5 1
"""
"""2 wide, 6 high, 4 deep; its front, at +z (Sweet Home 3D's +y), is of another material."""
MTL = "newmtl body\nKd 0.5 0.5 0.5\nnewmtl front\nKd 1 0 0\n"


def tag(element: str, inner: str = "", /, **attributes: object) -> str:
    row = " ".join(f"{key}={quoteattr(str(value))}" for key, value in attributes.items())
    return f"<{element} {row}>{inner}</{element}>"


def wall(x0: float, y0: float, x1: float, y1: float, **more: object) -> str:
    ends = {"xStart": x0, "yStart": y0, "xEnd": x1, "yEnd": y1}
    return tag("wall", **{"id": f"w{x0}-{y0}-{x1}-{y1}", **ends, "thickness": 10, **more})


def room(name: str, x0: float, y0: float, x1: float, y1: float, **more: object) -> str:
    corners = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    points = "".join(tag("point", x=x, y=y) for x, y in corners)
    return tag("room", points, name=name, **more)


def piece(name: str, x: float, y: float, kind: str = "pieceOfFurniture", **more: object) -> str:
    size = {"width": 100, "depth": 50, "height": 80}
    return tag(kind, **{"name": name, "x": x, "y": y, **size, **more})


def door(x: float, y: float, **more: object) -> str:
    size = {"width": 90, "depth": 12, "height": 205}
    return piece("Door", x, y, "doorOrWindow", **{**size, **more})


def text(words: str, x: float, y: float, **more: object) -> str:
    return tag("label", tag("text", escape(words)), x=x, y=y, **more)


WALLS = (
    wall(0, 0, 800, 0) + wall(800, 0, 800, 400) + wall(800, 400, 0, 400) + wall(0, 400, 0, 0)
    + wall(400, 0, 400, 400)
)  # fmt: skip
ROOMS = room("Kitchen", 5, 5, 395, 395) + room("Bedroom", 405, 5, 795, 395)


def xml(*parts: str, wallHeight: object = 250) -> bytes:
    return tag("home", "".join(parts), version=7000, wallHeight=wallHeight).encode()


def save(path: Path, home: bytes | None, files: dict[str, bytes] | None = None) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        if home is not None:
            file.writestr("Home.xml", home)
        for name, data in (files or {}).items():
            file.writestr(name, data)
    return path
