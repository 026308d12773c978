"""glTF scenes as triangles: nodes walked, transforms applied, what cannot be shown reported."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import BelvedereError, FileFormatError
from belvedere.model._found import Found
from belvedere.model._gltf_file import GltfFile
from belvedere.model._gltf_material import GltfMaterial, GltfMaterials
from belvedere.model._triangles import Triangles
from belvedere.model.report import Report
from belvedere.scene.mesh import Material

F8 = npt.NDArray[np.float64]
FACE_ORDER = "belvedere_face_order"
"""Key of a mesh's extras: the accessor that tells each face's place among all of the file."""
BUILDING = "belvedere_building"
"""Key of a scene's extras that holds a `Building`, as `Building.as_dict` writes it."""
MOST_FACES = 100_000_000
"""Faces that a scene may have once all its instances are drawn."""
POINTS, LINES, TRIANGLES, STRIP, FAN = 0, (1, 2, 3), 4, 5, 6


def read_gltf(path: Path, report: Report) -> Found:
    """The triangles of a glTF or GLB file's scene, in its own units and axes.

    Raises:
        FileFormatError: truncated, broken, compressed, no glTF.
        UnsafePathError: a buffer that lies outside the file's folder.
        MissingFileError: a buffer that is not there.
    """
    try:
        return _Reader(GltfFile(path), report).read()
    except BelvedereError:
        raise
    except (TypeError, ValueError, KeyError, AttributeError, OverflowError) as error:
        raise FileFormatError(
            f"{path}: holds values that glTF does not allow ({error}): export it again"
        ) from error


@dataclass(frozen=True, slots=True, eq=False)
class _Primitive:
    triangles: Triangles
    order: npt.NDArray[np.int64] | None


class _Reader:
    def __init__(self, file: GltfFile, report: Report) -> None:
        self.file, self.report = file, report
        self.looks = GltfMaterials(file, report)
        self.materials: list[Material] = []
        self.place: dict[int, int] = {}
        self.clear: dict[str, int] = {}
        self.meshes: dict[int, list[_Primitive]] = {}
        self.things: list[str] = []
        self.parts: list[Triangles] = []
        self.orders: list[npt.NDArray[np.int64] | None] = []
        self.faces = 0

    def read(self) -> Found:
        scene = self._scene()
        self._walk(scene.get("nodes", []))
        self._say_left_out()
        joined = Triangles.joined(self.parts)
        order = self._order(len(joined.faces))
        if order is not None:
            for name in ("faces", "material", "uv", "thing", "colors"):
                values = getattr(joined, name)
                if values is not None:
                    setattr(joined, name, values[order])
        extras = (scene.get("extras"), self.file.json.get("extras"))
        found = [e[BUILDING] for e in extras if isinstance(e, dict) and BUILDING in e]
        return Found("glTF", joined, self.materials, self.things, found[0] if found else None)

    def _scene(self) -> dict[str, Any]:
        scenes = self.file.entries("scenes")
        if len(scenes) > 1:
            self.report.note(f"{len(scenes)} scenes: only the default one is read")
        if scenes:
            return self.file.entry("scenes", self.file.json.get("scene", 0), "scene")
        nodes = self.file.entries("nodes")
        children = {c for node in nodes for c in node.get("children", [])}
        return {"nodes": [k for k in range(len(nodes)) if k not in children]}

    def _walk(self, roots: list[int]) -> None:
        seen: set[int] = set()
        stack = [(index, np.eye(4), "scene.nodes") for index in reversed(roots)]
        while stack:
            index, parent, where = stack.pop()
            node = self.file.entry("nodes", index, where)
            if index in seen:
                raise self.file.broken(f"nodes[{index}] hangs in the scene twice")
            seen.add(index)
            matrix = parent @ self._matrix(node, f"nodes[{index}]")
            if "mesh" in node:
                self._place(node, index, matrix)
            if "camera" in node:
                self.report.note("cameras: not read")
            if "KHR_lights_punctual" in node.get("extensions", {}):
                self.report.note("lights: not read")
            here = f"nodes[{index}].children"
            stack.extend((child, matrix, here) for child in reversed(node.get("children", [])))

    def _matrix(self, node: dict[str, Any], where: str) -> F8:
        """(4, 4) parent from node."""
        if "matrix" in node:
            found = np.array(node["matrix"], np.float64).reshape(4, 4).T
        else:
            found = _trs(
                np.array(node.get("translation", [0.0, 0.0, 0.0]), np.float64),
                np.array(node.get("rotation", [0.0, 0.0, 0.0, 1.0]), np.float64),
                np.array(node.get("scale", [1.0, 1.0, 1.0]), np.float64),
            )
        if not np.isfinite(found).all():
            raise self.file.broken(f"{where} has a transform that is not finite")
        return found

    def _place(self, node: dict[str, Any], index: int, matrix: F8) -> None:
        mesh = self.file.entry("meshes", node["mesh"], f"nodes[{index}].mesh")
        if "skin" in node:
            self.report.note("skins: shown as modelled, not posed")
        if node["mesh"] not in self.meshes:
            self.meshes[node["mesh"]] = self._primitives(mesh, f"meshes[{node['mesh']}]")
        thing = len(self.things)
        self.things.append(str(node.get("name") or mesh.get("name") or f"node {index}"))
        for instance in self._instances(node, f"nodes[{index}]"):
            world = matrix @ instance
            mirrored = np.linalg.det(world[:3, :3]) < 0.0
            for primitive in self.meshes[node["mesh"]]:
                self._add(primitive, world, mirrored, thing)

    def _add(self, primitive: _Primitive, world: F8, mirrored: bool, thing: int) -> None:
        old = primitive.triangles
        self.faces += len(old.faces)
        if self.faces > MOST_FACES:
            raise self.file.broken(f"draws more than {MOST_FACES} faces with its instances")
        turn = [0, 2, 1] if mirrored else [0, 1, 2]  # a mirror turns faces inside out
        self.parts.append(
            Triangles(
                old.vertices @ world[:3, :3].T + world[:3, 3],
                old.faces[:, turn],
                old.material,
                old.uv[:, turn],
                None if old.colors is None else old.colors[:, turn],
                np.full(len(old.faces), thing, np.int32),
            )
        )
        self.orders.append(primitive.order)

    def _instances(self, node: dict[str, Any], where: str) -> list[F8]:
        extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if not extension:
            return [np.eye(4)]
        found = {
            key: self.file.array(index, f"{where}.{key}").astype(np.float64)
            for key, index in extension.get("attributes", {}).items()
            if key in ("TRANSLATION", "ROTATION", "SCALE")
        }
        count = max((len(values) for values in found.values()), default=0)
        if any(len(values) != count for values in found.values()):
            raise self.file.broken(f"{where}: instances with attributes of several lengths")
        default = {"TRANSLATION": [0.0] * 3, "ROTATION": [0.0, 0.0, 0.0, 1.0], "SCALE": [1.0] * 3}
        full = {k: found.get(k, np.tile(np.array(v), (count, 1))) for k, v in default.items()}
        return [_trs(*(full[key][k] for key in default)) for k in range(count)]

    def _primitives(self, mesh: dict[str, Any], where: str) -> list[_Primitive]:
        order = mesh.get("extras", {}) if isinstance(mesh.get("extras"), dict) else {}
        places = None
        if FACE_ORDER in order:
            places = self.file.array(order[FACE_ORDER], f"{where}.extras.{FACE_ORDER}")
        found: list[_Primitive] = []
        first = 0
        for k, primitive in enumerate(mesh.get("primitives", [])):
            triangles, count = self._primitive(primitive, f"{where}.primitives[{k}]")
            if triangles is None:
                places = None
                continue
            part = None if places is None else places[first : first + count].astype(np.int64)
            first += count
            found.append(_Primitive(triangles, part))
        return found

    def _primitive(self, primitive: dict[str, Any], where: str) -> tuple[Triangles | None, int]:
        if "KHR_draco_mesh_compression" in primitive.get("extensions", {}):
            accessor = self.file.entry(
                "accessors", primitive["attributes"].get("POSITION"), f"{where}.POSITION"
            )
            if "bufferView" not in accessor:
                raise self.file.compressed("KHR_draco_mesh_compression")
        if primitive.get("targets"):
            self.report.note("morph targets: not applied")
        mode = primitive.get("mode", TRIANGLES)
        if mode == POINTS or mode in LINES:
            self.report.note(f"{'points' if mode == POINTS else 'lines'}: left out")
            return None, 0
        attributes = primitive["attributes"]
        if "POSITION" not in attributes:
            self.report.note("a part without positions: left out")
            return None, 0
        points = self.file.array(attributes["POSITION"], f"{where}.POSITION").astype(np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise self.file.broken(f"{where}.POSITION has shape {points.shape}, expected (N, 3)")
        faces = self._faces(primitive, mode, len(points), where)
        look, material = self._look(primitive, where)
        if look is not None and look.clear:
            self.clear[look.material.name] = self.clear.get(look.material.name, 0) + len(faces)
            return None, 0
        if "NORMAL" in attributes:
            self.report.note("vertex normals: not kept, faces are shaded as they lie")
        return Triangles(
            points,
            faces,
            np.full(len(faces), material, np.int32),
            self._coordinates(attributes, look, faces, len(points), where),
            self._colors(attributes, faces, len(points), where),
            np.zeros(len(faces), np.int32),
        ), len(faces)

    def _faces(
        self, primitive: dict[str, Any], mode: int, points: int, where: str
    ) -> npt.NDArray[np.int64]:
        if "indices" in primitive:
            index = self.file.array(primitive["indices"], f"{where}.indices").astype(np.int64)
            if index.ndim != 1:
                raise self.file.broken(f"{where}.indices are no plain numbers")
            if len(index) and int(index.max()) >= points:
                raise self.file.broken(
                    f"{where}.indices name vertex {int(index.max())}, but there are {points}"
                )
        else:
            index = np.arange(points, dtype=np.int64)
        if mode == TRIANGLES:
            if len(index) % 3:
                self.report.note("indices that make no whole triangle: left out")
            return index[: len(index) // 3 * 3].reshape(-1, 3)
        count = max(len(index) - 2, 0)
        steps = np.arange(count)
        if mode == STRIP:
            odd = steps % 2
            return np.stack([index[steps], index[steps + 1 + odd], index[steps + 2 - odd]], axis=1)
        if mode == FAN:
            return np.stack([index[np.zeros_like(steps)], index[steps + 1], index[steps + 2]], 1)
        raise self.file.broken(f"{where}.mode is {mode!r}, expected 0 to 6")

    def _look(self, primitive: dict[str, Any], where: str) -> tuple[GltfMaterial | None, int]:
        if "material" not in primitive:
            return None, -1
        look = self.looks.get(primitive["material"], f"{where}.material")
        if look.clear:
            return look, -1
        key = primitive["material"]
        if key not in self.place:
            self.place[key] = len(self.materials)
            self.materials.append(look.material)
        return look, self.place[key]

    def _coordinates(
        self, attributes: dict[str, Any], look: GltfMaterial | None,
        faces: npt.NDArray[np.int64], points: int, where: str,
    ) -> npt.NDArray[np.float32]:  # fmt: skip
        name = f"TEXCOORD_{0 if look is None else look.texcoord}"
        if name not in attributes:
            if look is not None and look.material.texture is not None:
                self.report.note(
                    f"material {look.material.name!r}: textured faces without texture coordinates"
                )
            return np.zeros((len(faces), 3, 2), np.float32)
        uv = self._attribute(attributes[name], (2,), points, f"{where}.{name}")
        if look is not None and look.transform is not None:
            uv = uv @ look.transform[:, :2].T + look.transform[:, 2]
        if look is not None and look.clamps and len(uv) and (uv.min() < 0.0 or uv.max() > 1.0):
            self.report.note(
                f"material {look.material.name!r}: its texture repeats here, clamped or mirrored "
                "in the file"
            )
        return uv.astype(np.float32)[faces]

    def _colors(
        self, attributes: dict[str, Any], faces: npt.NDArray[np.int64], points: int, where: str
    ) -> npt.NDArray[np.float32] | None:
        if "COLOR_0" not in attributes:
            return None
        colors = self.file.array(attributes["COLOR_0"], f"{where}.COLOR_0")
        if colors.ndim != 2 or colors.shape[1] not in (3, 4) or len(colors) != points:
            raise self.file.broken(
                f"{where}.COLOR_0 has shape {colors.shape}, expected ({points}, 3)"
            )
        if colors.shape[1] == 4 and len(colors) and float(colors[:, 3].min()) < 0.999:
            self.report.note("alpha of vertex colors: not used")
        return colors[:, :3].astype(np.float32)[faces]

    def _attribute(
        self, index: object, shape: tuple[int, ...], points: int, where: str
    ) -> npt.NDArray[Any]:
        found = self.file.array(index, where)
        if found.shape != (points, *shape):
            raise self.file.broken(f"{where} has shape {found.shape}, expected {(points, *shape)}")
        return found

    def _order(self, faces: int) -> npt.NDArray[np.int64] | None:
        """Where each face of the mesh that was written comes from, if the file says so."""
        if not self.orders or any(part is None for part in self.orders):
            return None
        places = np.concatenate([part for part in self.orders if part is not None])
        if len(places) != faces or not np.array_equal(np.sort(places), np.arange(faces)):
            return None
        order = np.empty(faces, np.int64)
        order[places] = np.arange(faces)
        return order

    def _say_left_out(self) -> None:
        if self.file.entries("animations"):
            self.report.note("animations: not read, the model stands still")
        for name, count in self.clear.items():
            self.report.note(f"material {name!r}: lets light through, its {count:,} faces left out")


def _trs(shift: F8, turn: F8, scale: F8) -> F8:
    """(4, 4) out of translation, quaternion (x, y, z, w) and scale."""
    x, y, z, w = turn / max(float(np.linalg.norm(turn)), 1e-30)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    found = np.eye(4)
    found[:3, :3] = rotation * scale
    found[:3, 3] = shift
    return found
