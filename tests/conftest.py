"""Shared fixtures: seeded numbers, real data when it is there, small exact scenes."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "belvedere",
    deadline=None,
    derandomize=bool(os.environ.get("CI")),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("belvedere")


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20240229)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real test inputs, kept outside the project."""
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("BELVEDERE_TEST_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no real test data at {folder} (set BELVEDERE_TEST_DATA)")
    return folder
