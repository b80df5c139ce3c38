"""Fingerprint of a compiled model."""

from __future__ import annotations

import hashlib

import mujoco
import numpy as np


def model_sha256(model: mujoco.MjModel) -> str:
    """Return the SHA-256 of the compiled model: it changes with any number that MuJoCo simulates or draws."""
    buffer = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return hashlib.sha256(buffer.tobytes()).hexdigest()
