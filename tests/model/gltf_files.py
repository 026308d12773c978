"""glTF files put together by hand, for tests: written from the specification, not by our writer."""

from __future__ import annotations

import base64
import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

KINDS = {"b": 5120, "B": 5121, "h": 5122, "H": 5123, "I": 5125, "f": 5126}
TRIANGLE = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]], np.float32)
"""In glTF's axes; its front looks along +z."""


class Gltf:
    """A file with one buffer; arrays become accessors."""

    def __init__(self) -> None:
        self.blob = b""
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "thing"}], "meshes": [], "accessors": [],
            "bufferViews": [], "materials": [], "textures": [], "images": [],
        }  # fmt: skip

    def view(self, data: bytes, **more: Any) -> int:
        self.blob += b"\0" * (-len(self.blob) % 4)
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), **more}
        )
        self.blob += data
        return len(self.json["bufferViews"]) - 1

    def add(self, values: npt.NDArray[Any], **more: Any) -> int:
        kind = "SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}"
        self.json["accessors"].append(
            {"bufferView": self.view(values.tobytes()), "componentType": KINDS[values.dtype.char],
             "count": len(values), "type": kind, **more}
        )  # fmt: skip
        return len(self.json["accessors"]) - 1

    def mesh(self, points: npt.NDArray[Any] = TRIANGLE, **more: Any) -> dict[str, Any]:
        """Add a mesh of one primitive and return the primitive."""
        attributes = {
            k: self.add(np.asarray(v)) for k, v in more.items() if k == k.upper()
        }  # fmt: skip
        primitive: dict[str, Any] = {"attributes": {"POSITION": self.add(points), **attributes}}
        primitive |= {k: v for k, v in more.items() if k != k.upper()}
        self.json["meshes"].append({"primitives": [primitive]})
        return primitive

    def picture(self, pixels: npt.NDArray[np.uint8]) -> int:
        """Add an embedded PNG with its texture, and return the texture."""
        buffer = io.BytesIO()
        Image.fromarray(pixels).save(buffer, "PNG")
        self.json["images"].append(
            {"bufferView": self.view(buffer.getvalue()), "mimeType": "image/png"}
        )
        self.json["textures"].append({"source": len(self.json["images"]) - 1})
        return len(self.json["textures"]) - 1

    def material(self, **entry: Any) -> int:
        self.json["materials"].append(entry)
        return len(self.json["materials"]) - 1

    def glb(self, path: Path) -> Path:
        """Write it as one file."""
        self.blob += b"\0" * (-len(self.blob) % 4)
        head = json.dumps({**self.json, "buffers": [{"byteLength": len(self.blob)}]}).encode()
        head += b" " * (-len(head) % 4)
        total = 28 + len(head) + len(self.blob)
        path.write_bytes(
            struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(head), b"JSON") + head
            + struct.pack("<I4s", len(self.blob), b"BIN\0") + self.blob
        )  # fmt: skip
        return path

    def gltf(self, path: Path, uri: str | None = None) -> Path:
        """Write it as JSON; the buffer is embedded, or named by ``uri``."""
        inline = "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        buffers = [{"byteLength": len(self.blob), "uri": uri or inline}]
        path.write_text(json.dumps({**self.json, "buffers": buffers}))
        return path
