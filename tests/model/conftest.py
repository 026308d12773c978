"""The built-in house, built once and with few rays: light is not what most tests look at."""

from __future__ import annotations

import pytest

pytest.importorskip("embreex", reason="ray casting needs embreex (pip install 'belvedere[model]')")

from belvedere.model import Interior, build_interior

RAYS = 8


@pytest.fixture(scope="session")
def house() -> Interior:
    return build_interior(seed=0, rays=RAYS)
