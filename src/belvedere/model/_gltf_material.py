"""glTF's materials as diffuse surfaces.

Factors and vertex colors are linear by the specification; color textures are sRGB. What a diffuse
surface has no word for (metal, roughness, normal maps, coats) is reported and left out. A surface
that lets most light through is left out as a whole, so that windows can be looked through.

Source: Khronos Group, glTF 2.0 specification, section 3.9, and the KHR_materials extensions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import FileFormatError, MissingFileError, UnsafePathError
from belvedere.model._gltf_file import GltfFile
from belvedere.model._texture_files import TextureFile, decode_texture
from belvedere.model.report import Report
from belvedere.scene.mesh import Material

CLEAR = 0.5
"""A surface whose opacity is below this is left out: glass must not hide what lies behind."""
_NOT_USED = {
    "normalTexture": "normal maps",
    "occlusionTexture": "occlusion maps",
    "KHR_materials_clearcoat": "clear coats",
    "KHR_materials_sheen": "sheen",
    "KHR_materials_specular": "specular colors",
    "KHR_materials_iridescence": "iridescence",
    "KHR_materials_anisotropy": "anisotropy",
    "KHR_materials_variants": "variants (the first is shown)",
}


@dataclass(frozen=True, slots=True, eq=False)
class GltfMaterial:
    """A material and how its texture lies."""

    material: Material
    """As the mesh will have it."""
    clear: bool
    """Whether most light goes through."""
    texcoord: int
    """Which set of texture coordinates it uses."""
    transform: npt.NDArray[np.float64] | None
    """(2, 3) new from old texture coordinates, or None for the identity."""
    clamps: bool
    """Whether its sampler does not repeat."""


class GltfMaterials:
    """The materials of a file, each decoded when it is first asked for."""

    def __init__(self, file: GltfFile, report: Report) -> None:
        self._file = file
        self._report = report
        self._images: dict[int, TextureFile | None] = {}
        self._done: dict[int, GltfMaterial] = {}

    def get(self, index: object, where: str) -> GltfMaterial:
        """A material by its index; ``where`` names who asks."""
        entry = self._file.entry("materials", index, where)
        assert isinstance(index, int)
        if index not in self._done:
            self._done[index] = self._read(entry, f"materials[{index}]", index)
        return self._done[index]

    def _read(self, entry: dict[str, Any], where: str, index: int) -> GltfMaterial:
        name = str(entry.get("name") or f"material {index}")
        extensions = _objects(entry.get("extensions"))
        color = _objects(entry.get("pbrMetallicRoughness"))
        factor_key, texture_key = "baseColorFactor", "baseColorTexture"
        if "KHR_materials_pbrSpecularGlossiness" in extensions:
            color = _objects(extensions["KHR_materials_pbrSpecularGlossiness"])
            factor_key, texture_key = "diffuseFactor", "diffuseTexture"
        factor = self._numbers(color, factor_key, [1.0, 1.0, 1.0, 1.0], where)
        info = _objects(color.get(texture_key))
        texture = self._texture(info, f"{where}.{texture_key}")
        self._say_unused(entry, color, extensions, name)
        opacity = self._opacity(entry, extensions, factor[3], texture, name)
        texcoord, transform = self._placement(info, where)
        material = Material(
            name,
            (factor[0], factor[1], factor[2]),
            None if texture is None else texture.color,
            self._emission(entry, extensions, where),
        )
        return GltfMaterial(
            material,
            opacity < CLEAR,
            texcoord,
            transform,
            texture is not None and self._clamps(info),
        )

    def _opacity(
        self, entry: dict[str, Any], extensions: dict[str, Any], alpha: float,
        texture: TextureFile | None, name: str,
    ) -> float:  # fmt: skip
        through = _objects(extensions.get("KHR_materials_transmission"))
        clear = 1.0 - float(through.get("transmissionFactor", 0.0) or 0.0)
        mode = entry.get("alphaMode", "OPAQUE")
        if mode == "OPAQUE":
            return clear
        opacity = alpha * (1.0 if texture is None else texture.opacity)
        if mode == "MASK" and opacity >= CLEAR and texture is not None and texture.opacity < 1.0:
            self._report.note(f"material {name!r}: cut out by its alpha, drawn whole")
        elif mode == "BLEND" and CLEAR <= opacity < 0.999:
            self._report.note(f"material {name!r}: {opacity:.0%} opaque, drawn opaque")
        return min(opacity, clear)

    def _emission(
        self, entry: dict[str, Any], extensions: dict[str, Any], where: str
    ) -> tuple[float, float, float]:
        factor = np.array(self._numbers(entry, "emissiveFactor", [0.0, 0.0, 0.0], where))
        strength = _objects(extensions.get("KHR_materials_emissive_strength"))
        factor = factor * float(strength.get("emissiveStrength", 1.0))
        info = _objects(entry.get("emissiveTexture"))
        if info and factor.any():
            texture = self._texture(info, f"{where}.emissiveTexture")
            if texture is not None:
                self._report.note("emissive textures: their mean is given off everywhere")
                factor = factor * texture.mean
        return (float(factor[0]), float(factor[1]), float(factor[2]))

    def _texture(self, info: dict[str, Any], where: str) -> TextureFile | None:
        """The picture a texture shows; None, with a line in the report, where there is none."""
        if not info:
            return None
        texture = self._file.entry("textures", info.get("index"), f"{where}.index")
        extensions = _objects(texture.get("extensions"))
        source = texture.get("source")
        if "EXT_texture_webp" in extensions:
            source = _objects(extensions["EXT_texture_webp"]).get("source", source)
        if source is None:
            kinds = ", ".join(extensions) or "nothing"
            self._report.note(f"a texture given as {kinds}: not read, its base color is shown")
            return None
        image = self._file.entry("images", source, f"textures[{info.get('index')}].source")
        if source not in self._images:
            self._images[source] = self._decoded(image, source)
        return self._images[source]

    def _decoded(self, image: dict[str, Any], index: int) -> TextureFile | None:
        name = str(image.get("name") or image.get("uri", ""))[:60]
        name = f"images[{index}]" + (f" ({name})" if name and not name.startswith("data:") else "")
        try:
            if "bufferView" in image:
                data = self._file.view(image["bufferView"], name)
            else:
                data = self._file.uri(image.get("uri"), f"images[{index}]")
            return decode_texture(data, name)
        except MissingFileError:
            self._report.note(f"{name}: no such file, the base color is shown instead")
        except UnsafePathError:
            self._report.note(f"{name}: lies outside the model's folder, not read")
        except FileFormatError as error:
            self._report.note(f"texture left out: {error}")
        return None

    def _placement(
        self, info: dict[str, Any], where: str
    ) -> tuple[int, npt.NDArray[np.float64] | None]:
        texcoord = info.get("texCoord", 0)
        extension = _objects(_objects(info.get("extensions")).get("KHR_texture_transform"))
        texcoord = extension.get("texCoord", texcoord)
        if isinstance(texcoord, bool) or not isinstance(texcoord, int) or texcoord < 0:
            raise self._file.broken(f"{where}: texCoord is {texcoord!r}, expected a whole number")
        if not extension:
            return texcoord, None
        shift = self._numbers(extension, "offset", [0.0, 0.0], where)
        scale = self._numbers(extension, "scale", [1.0, 1.0], where)
        turn = self._numbers({"r": [extension.get("rotation", 0.0)]}, "r", [0.0], where)[0]
        c, s = math.cos(turn), math.sin(turn)
        return texcoord, np.array(
            [[c * scale[0], s * scale[1], shift[0]], [-s * scale[0], c * scale[1], shift[1]]]
        )

    def _clamps(self, info: dict[str, Any]) -> bool:
        texture = self._file.entry("textures", info.get("index"), "texture")
        if "sampler" not in texture:
            return False
        sampler = self._file.entry("samplers", texture["sampler"], "sampler")
        return any(sampler.get(key, 10497) != 10497 for key in ("wrapS", "wrapT"))

    def _numbers(
        self, entry: dict[str, Any], key: str, default: list[float], where: str
    ) -> list[float]:
        value = entry.get(key, default)
        good = isinstance(value, list) and len(value) == len(default)
        good = good and all(
            isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v)
            for v in value
        )
        if not good:
            raise self._file.broken(f"{where}.{key} is {value!r}, expected {len(default)} numbers")
        if key.endswith("Factor") and min(value) < 0.0:
            self._report.note(f"{where}.{key}: negative values taken as 0")
            return [max(float(v), 0.0) for v in value]
        return [float(v) for v in value]

    def _say_unused(
        self, entry: dict[str, Any], color: dict[str, Any], extensions: dict[str, Any], name: str
    ) -> None:
        found = [word for key, word in _NOT_USED.items() if key in entry or key in extensions]
        for word in found:
            self._report.note(f"{word}: not used, light is diffuse")
        metal = color.get("metallicFactor", 1.0)
        if "metallicRoughnessTexture" in color or "specularGlossinessTexture" in color:
            self._report.note("metal and roughness maps: not used, light is diffuse")
        elif "metallicFactor" in color and isinstance(metal, int | float) and metal > 0.5:
            self._report.note(f"material {name!r}: metal, shown as a diffuse surface of its color")


def _objects(value: Any) -> dict[str, Any]:
    """A JSON object, or an empty one for anything else."""
    return value if isinstance(value, dict) else {}
