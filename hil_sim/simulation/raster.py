"""A scene drawn off screen: colour, depth and object ids in one pass, by OpenGL through EGL.

What stands still is uploaded once; what is outside the view is not drawn; the shadow map is drawn
again only when the light or something in the scene has moved. The shading is the one that the
detector's training frames were drawn with (PyBullet's renderer): half a Lambert term, a share of it
in hard shadow, and light from everywhere.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.furniture.obj import read_geometry
from hil_sim.simulation.projection import (
    FAR_M,
    NEAR_M,
    applied,
    camera_matrices,
    column_major,
    looking,
    orthographic,
    placed,
    side_planes,
)
from runtime.core.types import F64
from runtime.errors import RfNavError

SHADOW_PX = 4096
SHADOW_SHARE = 0.3  # of the directed light, lost in shadow
SHADOW_SLACK_M = 0.04  # surfaces do not shadow themselves
BACKGROUND = (178, 178, 204)
NOTHING = -1

_VERTEX = """
#version 330
uniform mat4 seen, lit, model;
in vec3 at; in vec2 uv;
out vec2 skin; out vec3 place; out vec4 shade;
void main() {
    vec4 world = model * vec4(at, 1.0);
    place = world.xyz; skin = uv; shade = lit * world; gl_Position = seen * world;
}"""
_FRAGMENT = """
#version 330
uniform sampler2D texels; uniform sampler2DShadow shadows;
uniform vec3 tint, paint, light_way, light_colour; uniform int id;
uniform float ambient, diffuse, share, slack, painted;
in vec2 skin; in vec3 place; in vec4 shade;
layout(location = 0) out vec4 colour; layout(location = 1) out int owner;
void main() {
    vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
    float lambert = 0.5 + 0.5 * clamp(dot(normal, light_way), -1.0, 1.0);
    float clear = lambert < 0.5 ? 0.0 : texture(shadows, shade.xyz * 0.5 + 0.5 - vec3(0, 0, slack));
    lambert *= 1.0 - share * (1.0 - clear);
    vec3 flesh = texture(texels, skin).rgb * tint;
    float grey = dot(flesh, vec3(0.299, 0.587, 0.114));
    flesh = mix(flesh, paint * (0.45 + 0.9 * grey), painted);
    colour = vec4(flesh * (lambert * diffuse * light_colour + ambient), 1.0);
    owner = id;
}"""
_DARK = "#version 330\nvoid main() {}"

F32 = NDArray[np.float32]
Colour = tuple[float, float, float]  # RGB, 0..1


class RasterError(RfNavError):
    """Off-screen drawing is not possible here."""


@dataclass
class _Item:
    """One drawn part: its geometry's ranges, skin, place and the object it belongs to."""

    triangles: Any  # VertexArray
    dark: Any  # VertexArray of the shadow pass
    texture: Any
    model: F64  # (4, 4)
    tint: Colour
    paint: Colour | None
    owner: int
    sphere: tuple[F64, float]  # of the mesh: centre (3,), radius

    def outside(self, view: F64, planes: F64) -> bool:
        """Whether nothing of it can be seen."""
        centre = applied(view, applied(self.model, self.sphere[0]))
        return bool((planes @ centre < -self.sphere[1]).any() or centre[2] > self.sphere[1])


class Raster:
    """One OpenGL context and what is in it. Use from one thread; `close` frees it."""

    def __init__(self) -> None:
        try:
            import moderngl

            self._gl = moderngl.create_context(standalone=True, backend="egl")  # type: ignore[arg-type]
        except Exception as error:  # the bindings raise plain Exception
            raise RasterError(f"EGL: cannot draw off screen here ({error})") from error
        self._mgl = moderngl
        self._program: Any = self._gl.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT)
        self._shadow_program: Any = self._gl.program(
            vertex_shader=_VERTEX.replace("seen * world", "lit * world"), fragment_shader=_DARK
        )
        self._shadow = self._gl.depth_texture((SHADOW_PX, SHADOW_PX))
        self._shadow.compare_func = "<="
        self._shadow.repeat_x = self._shadow.repeat_y = False
        self._shadow_target = self._gl.framebuffer(depth_attachment=self._shadow)
        self._shadow_of: tuple[float, ...] | None = None  # the light it was drawn for
        self._lit, self._depth_m = np.eye(4), 1.0
        self._items: list[_Item] = []
        self._meshes: dict[Path, tuple[Any, Any, F64, float]] = {}
        self._textures: dict[Path, Any] = {}
        self._targets: dict[tuple[int, int], Any] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the context. Idempotent."""
        if self._items is not None:
            self._items = []
            self._gl.release()

    def add(
        self,
        obj: Path,
        position_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
        yaw_rad: float = 0.0,
        scale: tuple[float, float, float] = (1.0, 1.0, 1.0),
        tint: Colour = (1.0, 1.0, 1.0),
        owner: int = NOTHING,
        paint: Colour | None = None,
    ) -> int:
        """Put an OBJ that we wrote, with its MTL's texture, into the scene; returns its number. The
        texture is multiplied by `tint`; of `paint` it only makes lighter and darker."""
        if obj not in self._meshes:
            self._meshes[obj] = self._upload(obj)
        vertices, index, centre, radius = self._meshes[obj]
        layout = [(vertices, "3f 2f", "at", "uv")]
        dark = [(vertices, "3f 8x", "at")]
        model = placed(position_m, yaw_rad) @ np.diag([*scale, 1.0])
        item = _Item(
            self._gl.vertex_array(self._program, layout, index),
            self._gl.vertex_array(self._shadow_program, dark, index),
            self._texture(obj),
            model,
            tint,
            paint,
            owner,
            (centre, radius * max(scale)),
        )
        self._items.append(item)
        if owner != NOTHING:
            self._shadow_of = None
        return len(self._items) - 1

    def place(self, number: int, position_m: tuple[float, float, float], yaw_rad: float) -> None:
        """Move what was added (its scale is kept)."""
        item = self._items[number]
        scale = np.linalg.norm(item.model[:3, :3], axis=0)
        item.model = placed(position_m, yaw_rad) @ np.diag([*scale, 1.0])
        if item.owner != NOTHING:
            self._shadow_of = None

    def draw(
        self,
        eye: tuple[float, float, float],
        yaw_rad: float,
        pitch_rad: float,
        size: tuple[int, int],
        hfov_rad: float,
        light: tuple[tuple[float, float, float], tuple[float, float, float], float, float],
        colour: bool = True,
    ) -> tuple[NDArray[np.uint8], F32, NDArray[np.int32]]:
        """The view of a level camera (positive pitch looks down): (H, W, 3) colour, (H, W) m along
        the optical axis (0: nothing), (H, W) owners. `light`: toward it, its colour, ambient and
        diffuse shares. Without `colour` the first is black."""
        toward, tone, ambient, diffuse = light
        way = np.array(toward) / np.linalg.norm(toward)
        self._light(way)
        target = self._target(size)
        target.use()
        self._gl.enable(self._mgl.DEPTH_TEST | self._mgl.CULL_FACE)
        target.color_mask = ((colour,) * 4, (True,) * 4)
        target.clear(depth=1.0)  # zeros: nobody's, whatever the attachment's type
        view, seen = camera_matrices(eye, yaw_rad, pitch_rad, size, hfov_rad)
        program = self._program
        program["seen"].write(column_major(seen))
        program["lit"].write(column_major(self._lit))
        program["light_way"], program["light_colour"] = tuple(way), tone
        program["ambient"], program["diffuse"], program["share"] = ambient, diffuse, SHADOW_SHARE
        program["slack"] = SHADOW_SLACK_M / self._depth_m
        program["texels"], program["shadows"] = 0, 1
        self._shadow.use(1)
        planes = side_planes(size, hfov_rad)
        for item in self._items:
            if item.outside(view, planes):
                continue
            program["model"].write(column_major(item.model))
            program["tint"], program["id"] = item.tint, item.owner + 1
            program["paint"], program["painted"] = item.paint or item.tint, bool(item.paint)
            item.texture.use(0)
            item.triangles.render()
        return self._read(target, size, colour)

    # -- inside --------------------------------------------------------------------------------

    def _read(
        self, target: Any, size: tuple[int, int], colour: bool
    ) -> tuple[NDArray[np.uint8], F32, NDArray[np.int32]]:
        width, height = size
        z = np.frombuffer(target.read(components=1, attachment=-1, dtype="f4"), np.float32)
        z = z.reshape(height, width)[::-1]
        empty = z >= 1.0
        rgb = np.zeros((height, width, 3), np.uint8)
        if colour:
            pixels = np.frombuffer(target.read(components=4, attachment=0), np.uint8)
            rgb = np.ascontiguousarray(pixels.reshape(height, width, 4)[::-1, :, :3])
            rgb[empty] = BACKGROUND
        owners = np.frombuffer(target.read(components=1, attachment=1, dtype="i4"), np.int32)
        metres = np.float32(FAR_M * NEAR_M) / (FAR_M - np.float32(FAR_M - NEAR_M) * z)
        metres[empty] = 0.0
        return rgb, metres, owners.reshape(height, width)[::-1] - 1

    def _light(self, way: F64) -> None:
        """Draw the shadow map, unless it is the same as the last."""
        if self._shadow_of == tuple(way):
            return
        centre, radius = self._bounds()
        self._depth_m = 2 * radius
        self._lit = orthographic(radius) @ looking(centre + way * radius, -way)
        self._shadow_target.use()
        self._shadow_target.clear(depth=1.0)
        self._gl.enable(self._mgl.DEPTH_TEST | self._mgl.CULL_FACE)
        self._shadow_program["lit"].write(column_major(self._lit))
        for item in self._items:
            if item.owner == NOTHING:
                continue  # walls and ceiling would leave no light
            self._shadow_program["model"].write(column_major(item.model))
            item.dark.render()
        self._shadow_of = tuple(way)

    def _bounds(self) -> tuple[F64, float]:
        """A sphere around everything."""
        things = [item for item in self._items if item.owner != NOTHING]
        if not things:
            return np.zeros(3), 1.0
        centres = np.array([applied(item.model, item.sphere[0]) for item in things])
        reach = np.array([item.sphere[1] for item in things])[:, None]
        low, high = (centres - reach).min(axis=0), (centres + reach).max(axis=0)
        return (low + high) / 2, float(np.linalg.norm(high - low) / 2)

    def _upload(self, obj: Path) -> tuple[Any, Any, F64, float]:
        geometry = read_geometry(obj)
        points, corners = geometry.points, geometry.corners.reshape(-1, 2)
        pairs, index = np.unique(corners, axis=0, return_inverse=True)
        vertices = np.concatenate([points[pairs[:, 0]], geometry.uv[pairs[:, 1]]], axis=1)
        low, high = points.min(axis=0), points.max(axis=0)
        centre = (low + high) / 2
        radius = float(np.linalg.norm(points - centre, axis=1).max())
        return (
            self._gl.buffer(vertices.astype(np.float32).tobytes()),
            self._gl.buffer(index.astype(np.int32).tobytes()),
            centre,
            radius,
        )

    def _texture(self, obj: Path) -> Any:
        mtl = obj.with_suffix(".mtl").read_text()
        path = obj.parent / mtl.split("map_Kd", 1)[1].split()[0]
        if path not in self._textures:
            image = cv2.imread(str(path), cv2.IMREAD_COLOR)
            if image is None:
                raise RasterError(f"{path}: not an image")
            pixels = np.ascontiguousarray(image[::-1, :, ::-1])
            texture = self._gl.texture(image.shape[1::-1], 3, pixels.tobytes(), alignment=1)
            texture.build_mipmaps()
            texture.filter = (self._mgl.LINEAR_MIPMAP_LINEAR, self._mgl.LINEAR)
            self._textures[path] = texture
        return self._textures[path]

    def _target(self, size: tuple[int, int]) -> Any:
        if size not in self._targets:
            self._targets[size] = self._gl.framebuffer(
                [self._gl.texture(size, 4), self._gl.texture(size, 1, dtype="i4")],
                self._gl.depth_texture(size),
            )
        return self._targets[size]
