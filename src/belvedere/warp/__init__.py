"""3D image warping: reference views with depth in, new views out.

Samples move by the warping equation; occlusion-compatible order or warped disparity decides what
hides what; a reconstructor (point, splat, gaussian, mesh, offset, inverse) makes a picture of them
again; several references are merged.

Papers: McMillan's course notes "Image-Based Rendering using Image Warping"; Popescu and Lastra,
"High Quality 3D Image Warping by Separating Visibility from Reconstruction"; Rafferty, Aliaga and
Lastra, "3D Image Warping in Architectural Walkthroughs".
"""

from belvedere.warp.choose import choose_references
from belvedere.warp.depth_views import DepthViews, Photographs
from belvedere.warp.equation import (
    area_growth,
    epipole,
    homography,
    jacobian,
    plane_homography,
    warp_matrix,
    warp_points,
)
from belvedere.warp.explain import explain
from belvedere.warp.features import FEATURE_FILTERS, FeatureFilter
from belvedere.warp.holes import fill_background
from belvedere.warp.order import Sheet, occlusion_compatible_sheets, order_key
from belvedere.warp.prepare import PreparedView, halved, prepare
from belvedere.warp.reconstruct import (
    RECONSTRUCTIONS,
    GaussianOptions,
    OffsetOptions,
    Reconstruction,
    SplatOptions,
    WarpOptions,
)
from belvedere.warp.warp import warp
from belvedere.warp.warper import Warper

__all__ = [
    "FEATURE_FILTERS",
    "RECONSTRUCTIONS",
    "DepthViews",
    "FeatureFilter",
    "GaussianOptions",
    "OffsetOptions",
    "Photographs",
    "PreparedView",
    "Reconstruction",
    "Sheet",
    "SplatOptions",
    "WarpOptions",
    "Warper",
    "area_growth",
    "choose_references",
    "epipole",
    "explain",
    "fill_background",
    "halved",
    "homography",
    "jacobian",
    "occlusion_compatible_sheets",
    "order_key",
    "plane_homography",
    "prepare",
    "warp",
    "warp_matrix",
    "warp_points",
]
