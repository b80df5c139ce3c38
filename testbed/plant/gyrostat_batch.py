"""Platforms stepped by the compiled equations of motion, in the place of MuJoCo's batch."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np

from testbed.arrays import Array, Indices, Vectors3
from testbed.dynamics.environment import OrbitTorque
from testbed.dynamics.gyrostat_kernel import advance, total_momentum
from testbed.plant.gyrostat import gyrostats_of


class GyrostatBatch:
    """Platforms that are gyrostats, with what a `Plant` uses of MuJoCo's batch; states stand as MuJoCo orders them."""

    def __init__(self, models: Sequence[mujoco.MjModel], threads: int, orbit_torque: OrbitTorque | None = None) -> None:
        """Put platforms where their models draw them.

        Args:
            models: compiled, of one layout; none has anything `testbed.plant.gyrostat.uncovered`.
            threads: that step the platforms.
            orbit_torque: what an orbit does to the platforms; nothing where None.
        """
        model, count = models[0], len(models)
        self._gyrostats, self._threads = gyrostats_of(models, orbit_torque), threads
        self._pool = ThreadPoolExecutor(threads)  # which starts a thread when it first needs one
        ends = np.cumsum([model.nq, model.nv, model.na, model.nv, 1])
        self._state = np.zeros((count, ends[-1]))
        qpos, qvel, act, torque, time = np.split(self._state, ends[:-1], axis=1)
        qpos[:] = [each.qpos0 for each in models]
        self._bound = {
            "qpos": qpos,
            "qvel": qvel,
            "act": act,
            "qfrc_actuator": torque,
            "time": time[:, 0],
            "ctrl": np.zeros((count, model.nu)),
            "qfrc_applied": np.zeros((count, model.nv)),
            "ncon": np.zeros(count),
        }

    def bind(self, name: str) -> Array:
        """Return a live array by MuJoCo's name, the platforms on its first axis."""
        return self._bound[name]

    def step(self, ids: Indices, nstep: int) -> None:
        """Step some platforms on; what one does depends neither on the others nor on the threads, bit for bit."""

        def take(share: Indices) -> None:
            advance(self._gyrostats, share, self._bound["ctrl"], nstep, self._state)

        shares = [share for share in np.array_split(ids, self._threads) if share.size]
        if len(shares) < 2:
            take(ids)
            return
        list(self._pool.map(take, shares))

    def total_momentum(self, platform: int, qpos: Array, qvel: Array) -> Vectors3:
        """Return the momentum of a platform along its motion, as `testbed.plant.geometry.total_momentum` does."""
        return total_momentum(self._gyrostats, platform, np.concatenate([qpos, qvel, np.zeros((len(qpos), 1))], axis=1))
