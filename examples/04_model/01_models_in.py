"""A model in two formats, back as one house.

The built-in house is written as GLB, with what it states of its rooms, and by hand as an OBJ in
millimetres with y up, as many tools export it. Both are read: the GLB says all of itself, the units
and axes of the OBJ are guessed from its floors and their headroom, and the report says so. In
`models.png` the same rays meet both: the upper picture is colored by the GLB's materials, the
middle one by the OBJ's normals, and the plan below shows the room that the GLB states, cut 1.5 m
above the floor.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from belvedere import Camera, OrthographicCamera
from belvedere.ground.color import color_to_linear, encode_srgb8
from belvedere.model import (
    Building,
    Hits,
    ImportedModel,
    Opening,
    RayCaster,
    Room,
    build_interior,
    read_model,
    write_glb,
)
from belvedere.scene import CameraModel, Mesh
from belvedere.scene.io import write_color


def write_obj(path: Path, mesh: Mesh) -> None:
    """Positions in millimetres, y up; nothing else."""
    x, y, z = mesh.vertices.T * 1000.0
    with path.open("w", encoding="utf-8") as file:
        np.savetxt(file, np.stack([x, z, -y], axis=1), "v %.3f %.3f %.3f")
        np.savetxt(file, mesh.faces + 1, "f %d %d %d")


def surface(mesh: Mesh, hits: Hits) -> np.ndarray:
    """(N, 3) linear color of what was met: base color times the nearest texel."""
    index = mesh.material_index[hits.face]
    color = np.array([m.base_color for m in mesh.materials])[index]
    b, c = hits.barycentric.T[..., None]
    uv = np.array([1 - b - c, b, c]).transpose(1, 2, 0) @ mesh.uv[hits.face]
    for k, material in enumerate(mesh.materials):
        if material.texture is None:
            continue
        height, width = material.texture.shape[:2]
        u, v = (uv[index == k, 0] % 1.0).T
        texels = material.texture[
            (v * height).astype(int) % height, (u * width).astype(int) % width
        ]
        color[index == k] *= color_to_linear(texels[None])[0]
    return color


def look(model: ImportedModel, camera: CameraModel, by_normal: bool) -> np.ndarray:
    """(H, W, 3) what rays meet, by its normal or by its base color in a soft light."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    rays = camera.rays(u.ravel(), v.ravel())
    hits = RayCaster(model.mesh).cast(camera.origins(u.ravel(), v.ravel()), rays)
    normal = model.mesh.normals()[hits.face]
    normal *= -np.sign((normal * rays).sum(axis=1, keepdims=True))  # towards the eye
    if by_normal:
        color = encode_srgb8(0.5 + 0.5 * normal)
    else:
        light = 0.6 + 0.4 * normal @ np.array([0.3, -0.4, 0.85])
        color = encode_srgb8(surface(model.mesh, hits) * light[:, None])
    color[hits.face < 0] = 255
    return color.reshape(camera.height, camera.width, 3)


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    ring = np.array([[0.0, 0.0], [5.2, 0.0], [5.2, 4.2], [0.0, 4.2]])
    way = np.array([[5.2, 1.5, 0.0], [5.2, 2.7, 0.0], [5.2, 2.7, 2.1], [5.2, 1.5, 2.1]])
    stated = Building(
        (Room("living room", (ring,), 0.0, 2.6),),
        (Opening("way to the kitchen", "opening", way, ("living room", None)),),
    )
    output.mkdir(parents=True, exist_ok=True)
    write_glb(output / "house.glb", house.mesh, stated, force=True)
    write_obj(output / "house.obj", house.mesh)

    models = [read_model(output / name) for name in ("house.glb", "house.obj")]
    for model in models:
        size = np.ptp(model.mesh.bounds, axis=0)
        print(f"{model.source.format}: {len(model.mesh.faces)} faces, {size.round(2)} m")
        for line in model.dropped:
            print(f"  {line}")
    glb, obj = models
    apart = np.abs(glb.mesh.bounds - obj.mesh.bounds).max() * 1000
    print(f"the two are at most {apart:.2f} mm apart")

    camera = Camera.look_at((0.95, 1.35, 1.6), (4.2, 2.75, 1.2), fov_deg=70, width=480, height=300)
    plan = OrthographicCamera.look_at(
        (4.6, 3.9, 1.5), (4.6, 3.9, 0), up=(0, 1, 0), view_height=9.0, width=480, height=300
    )
    drawn = look(glb, plan, by_normal=False)
    assert glb.building is not None
    for room in glb.building.rooms:
        for a, b in zip(room.rings[0], np.roll(room.rings[0], -1, axis=0), strict=True):
            points = a + np.linspace(0, 1, 400)[:, None] * (b - a)
            u, v, _ = plan.project(np.column_stack([points, np.full(400, room.floor)]))
            for shift in range(3):
                drawn[np.rint(v).astype(int) + shift, np.rint(u).astype(int)] = (200, 30, 30)
    pictures = [look(glb, camera, by_normal=False), look(obj, camera, by_normal=True), drawn]
    write_color(output / "models.png", np.vstack(pictures))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
