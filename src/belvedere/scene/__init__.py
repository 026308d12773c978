"""The nouns everything is said with: cameras, reference views, frames, paths, scenes.

Conventions (axes, pixel centres, disparity, colour) are drawn in docs/conventions.md. Camera
algebra is float64; pictures are ``uint8`` sRGB or ``float32`` linear radiance.
"""

from belvedere.scene.camera import Camera
from belvedere.scene.camera_model import CameraModel
from belvedere.scene.explanation import Explanation, Hole
from belvedere.scene.loops import wobble
from belvedere.scene.mesh import Material, Mesh
from belvedere.scene.moves import dolly, orbit, through
from belvedere.scene.orthographic import OrthographicCamera
from belvedere.scene.panoramic import CylinderCamera, SphereCamera
from belvedere.scene.path import CameraPath, Keyframe
from belvedere.scene.scene import Affordances, Scene, ViewingRegion
from belvedere.scene.view import Frame, ReferenceView
from belvedere.scene.views import ViewEntry, ViewSet

__all__ = [
    "Affordances",
    "Camera",
    "CameraModel",
    "CameraPath",
    "CylinderCamera",
    "Explanation",
    "Frame",
    "Hole",
    "Keyframe",
    "Material",
    "Mesh",
    "OrthographicCamera",
    "ReferenceView",
    "Scene",
    "SphereCamera",
    "ViewEntry",
    "ViewSet",
    "ViewingRegion",
    "dolly",
    "orbit",
    "through",
    "wobble",
]
