"""The equations of motion of a platform with control moment gyros and reaction wheels, as machine code.

In momenta they need no mass matrix: of every unit the gimbal's p_g = I (ḋ + g·ω) and the rotor's p_r = Js (Ω + s·ω), of
every wheel p_w = Jw (Ω + a·ω), and the platform's total H in inertial axes:

    ω = J(d)⁻¹ (Rᵀ H - Σ p_r s - Σ p_g g - Σ p_w a),   J(d) = J' + Σ (Ix s sᵀ + Iy t tᵀ)
    ṗ_g = τ_g + (t·ω) (p_r + (Ix - Iy) s·ω),   ṗ_r = τ_r,   ṗ_w = τ_w - c Ω,   Ḣ = R τ,   q̇ = ½ q ⊗ (0, ω)

J' is the platform's inertia without what the momenta carry; Ix and Iy are a unit's inertias about s and t that they do
not. H changes by an external torque alone. Platforms are stepped by the classical fourth-order rule, one after the
other: what one does depends on no other.

Source: Lagrange's equations in the gimbals' angles, in quasi-velocities for the body; Hughes, Spacecraft Attitude
Dynamics (1986), ch. 3 and 6.
"""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Indices, Vectors3
from testbed.compiled import kept


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where the quantities of a platform stand in the row of its state, and of its motors' demands.

    Attributes:
        body: attitude, position or -1 on a pivot, velocity, body rate, and how far behind a rate its torque stands,
            shape (5,).
        units: of each gimbal angle, rotor angle, gimbal rate, rotor speed; demand of gimbal and rotor; shape (M, 6).
        wheels: of each angle, speed, torque of a motor with a lag or -1; demand; shape (W, 4).
    """

    body: Indices
    units: Indices
    wheels: Indices


@dataclass(frozen=True, kw_only=True)
class Gyrostats:
    """Numbers of B platforms of one layout.

    Attributes:
        body: J' as J11, J22, J33, J23, J13, J12, kg·m²; weight times place of the centre of mass from the pivot, N·m,
            zero of a platform that floats; drag, N·m·s/rad; step, s; and of an orbit, zero on none, its rate n, rad/s,
            3 n² times the gradient's factor, J about the centre of mass as J', dipole, A·m², field and constant torque
            in local axes, T and N·m; shape (B, 28).
        units: g; s and t at gimbal angle zero; Ix, Iy, I and Js, kg·m²; kv of the motor's tachometer loop, N·m·s/rad,
            the motor's limit, N·m; the rotor servo's torque at rest, N·m, and its change with speed, N·m·s/rad; shape
            (B, M, 17).
        wheels: a; Jw, kg·m²; torque for its demand, 1, its change with speed, N·m·s/rad, and its limit, N·m; viscous
            friction, N·m·s/rad; the motor's time constant, s; shape (B, W, 9).
        places: the same of all.
    """

    body: Array
    units: Array
    wheels: Array
    places: Places


_PLACES = (("i8", 1), ("i8", 2), ("i8", 2))
_INDICES, _LIST, _TABLE, _TABLES = ("i8", 1), ("f8", 1), ("f8", 2), ("f8", 3)
"""Kinds of numbers and numbers of axes of what the loops are given."""


def advance(gyrostats: Gyrostats, platforms: Indices, demand: Array, steps: int, state: Array) -> None:
    """Step some platforms on.

    Args:
        gyrostats: all platforms.
        platforms: which are stepped.
        demand: of the motors, shape (B, nu).
        steps: how many.
        state: of all, shape (B, S), the time last; is changed. Its torques are those of the last step's last stage.
    """
    places = gyrostats.places
    loop = kept(_advance, (*_PLACES, _INDICES, _INDICES, _TABLE, _TABLES, _TABLES, _TABLE, _TABLE))
    given = (places.body, places.units, places.wheels, np.array([steps]), platforms)
    loop(*given, gyrostats.body, gyrostats.units, gyrostats.wheels, demand, state)


def total_momentum(gyrostats: Gyrostats, platform: int, state: Array) -> Vectors3:
    """Return H along a motion, shape (N, 3), N·m·s, inertial axes; on a bearing about the pivot.

    Args:
        gyrostats: platforms.
        platform: which of them moved.
        state: its states, shape (N, S); what stands behind the rates may be left out.
    """
    places, momentum = gyrostats.places, np.empty((len(state), 3))
    loop = kept(_find_momentum, (*_PLACES, _LIST, _TABLE, _TABLE, _TABLE, _TABLE))
    numbers = (gyrostats.body[platform], gyrostats.units[platform], gyrostats.wheels[platform])
    loop(places.body, places.units, places.wheels, *numbers, state, momentum)
    return momentum


# A motion in momenta holds attitude and H; of every unit gimbal angle, rotor angle, p_g and p_r; of every wheel angle,
# p_w and the torque of a motor with a lag. Its rates hold ω; of every unit ḋ and Ω; of every wheel Ω.


def _advance(of_body, of_units, of_wheels, steps, platforms, body, units, wheels, demand, state):
    count, more = units.shape[1], wheels.shape[1]
    size = 7 + 4 * count + 3 * more
    start, at, slope, mean = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    axes, rates, torque = np.empty((count, 6)), np.empty(3 + 2 * count + more), np.empty(2 * count + more)
    for platform in platforms:
        own, gyros, turning, row = body[platform], units[platform], wheels[platform], state[platform]
        step, acted_on = own[10], own[9] + own[11] + abs(own[6]) + abs(own[7]) + abs(own[8]) > 0.0
        _to_momenta(of_body, of_units, of_wheels, own, gyros, turning, row, axes, start)
        for _ in range(steps[0]):
            for index in range(size):
                mean[index], at[index] = 0.0, start[index]
            for stage in range(4):
                _find_rates(own, gyros, turning, at, axes, rates)
                _find_torques(of_units, of_wheels, gyros, turning, demand[platform], at, rates, torque)
                _find_slopes(gyros, turning, at, axes, rates, torque, slope)
                _lag(of_wheels, turning, demand[platform], at, slope)
                if acted_on:
                    now = row[-1] + (0.0 if stage == 0 else step if stage == 3 else 0.5 * step)
                    _act_from_outside(own, now, at, rates, slope)
                weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
                onward = step if stage == 2 else 0.5 * step
                for index in range(size):
                    mean[index] += weight * slope[index]
                    at[index] = start[index] + onward * slope[index]
            for index in range(size):
                start[index] += step * mean[index]
            length = np.sqrt(start[0] ** 2 + start[1] ** 2 + start[2] ** 2 + start[3] ** 2)
            for index in range(4):
                start[index] /= length
            row[-1] += step
        _find_rates(own, gyros, turning, start, axes, rates)
        _from_momenta(of_body, of_units, of_wheels, start, rates, torque, row)
        if of_body[1] >= 0:
            for axis in range(3):
                row[of_body[1] + axis] += steps[0] * step * row[of_body[2] + axis]


def _find_momentum(of_body, of_units, of_wheels, own, gyros, turning, states, momentum):
    axes = np.empty((gyros.shape[0], 6))
    at = np.empty(7 + 4 * gyros.shape[0] + 3 * turning.shape[0])
    for row in range(len(states)):
        _to_momenta(of_body, of_units, of_wheels, own, gyros, turning, states[row], axes, at)
        for axis in range(3):
            momentum[row, axis] = at[4 + axis]


def _to_momenta(of_body, of_units, of_wheels, own, gyros, turning, row, axes, at):
    for index in range(4):
        at[index] = row[of_body[0] + index]
    x, y, z = row[of_body[3]], row[of_body[3] + 1], row[of_body[3] + 2]
    n = 7
    for unit in range(len(gyros)):
        of, place, axis = gyros[unit], of_units[unit], axes[unit]
        at[n] = row[place[0]]
        at[n + 1] = row[place[1]]
        _turn_axes(of, at[n], axis)
        at[n + 2] = of[11] * (row[place[2]] + of[0] * x + of[1] * y + of[2] * z)
        at[n + 3] = of[12] * (row[place[3]] + axis[0] * x + axis[1] * y + axis[2] * z)
        n += 4
    for wheel in range(len(turning)):
        of, place = turning[wheel], of_wheels[wheel]
        at[n] = row[place[0]]
        at[n + 1] = of[3] * (row[place[1]] + of[0] * x + of[1] * y + of[2] * z)
        at[n + 2] = row[place[2]] if place[2] >= 0 else 0.0
        n += 3
    a, b, c, d, e, f = _inertia(own, gyros, axes)
    u, v, w = _held(gyros, turning, axes, at)
    at[4], at[5], at[6] = _to_inertial(
        at, u + a * x + f * y + e * z, v + f * x + b * y + d * z, w + e * x + d * y + c * z
    )


def _from_momenta(of_body, of_units, of_wheels, at, rates, torque, row):
    for index in range(4):
        row[of_body[0] + index] = at[index]
    for index in range(3):
        row[of_body[3] + index] = rates[index]
    behind, n, k = of_body[4], 7, 0
    for unit in range(len(of_units)):
        place = of_units[unit]
        row[place[0]] = at[n]
        row[place[1]] = at[n + 1]
        for part in range(2):
            row[place[2 + part]] = rates[3 + k + part]
            row[place[2 + part] + behind] = torque[k + part]
        n, k = n + 4, k + 2
    for wheel in range(len(of_wheels)):
        place = of_wheels[wheel]
        row[place[0]] = at[n]
        row[place[1]] = rates[3 + k]
        row[place[1] + behind] = torque[k]
        if place[2] >= 0:
            row[place[2]] = at[n + 2]
        n, k = n + 3, k + 1


def _find_rates(own, gyros, turning, at, axes, rates):
    """ω = J(d)⁻¹ (Rᵀ H - h), and from it the rates of all units and wheels."""
    n = 7
    for unit in range(len(gyros)):
        _turn_axes(gyros[unit], at[n], axes[unit])
        n += 4
    a, b, c, d, e, f = _inertia(own, gyros, axes)
    u, v, w = _held(gyros, turning, axes, at)
    x, y, z = _to_body(at, at[4], at[5], at[6])
    x, y, z = x - u, y - v, z - w
    xx, yy, zz = b * c - d * d, a * c - e * e, a * b - f * f
    yz, xz, xy = e * f - a * d, d * f - b * e, d * e - c * f
    over = 1.0 / (a * xx + f * xy + e * xz)
    x, y, z = (
        over * (xx * x + xy * y + xz * z),
        over * (xy * x + yy * y + yz * z),
        over * (xz * x + yz * y + zz * z),
    )
    rates[0], rates[1], rates[2] = x, y, z
    n, k = 7, 3
    for unit in range(len(gyros)):
        of, axis = gyros[unit], axes[unit]
        rates[k] = at[n + 2] / of[11] - (of[0] * x + of[1] * y + of[2] * z)
        rates[k + 1] = at[n + 3] / of[12] - (axis[0] * x + axis[1] * y + axis[2] * z)
        n, k = n + 4, k + 2
    for wheel in range(len(turning)):
        of = turning[wheel]
        rates[k] = at[n + 1] / of[3] - (of[0] * x + of[1] * y + of[2] * z)
        n, k = n + 3, k + 1


def _find_torques(of_units, of_wheels, gyros, turning, demand, at, rates, torque):
    """Torques of all motors: demand and tachometer loop within the limit, the rotors' servos, the wheels' drives."""
    k = 0
    for unit in range(len(gyros)):
        of, place = gyros[unit], of_units[unit]
        wanted = demand[place[4]] - of[13] * rates[3 + k]
        torque[k] = min(max(wanted, -of[14]), of[14])
        torque[k + 1] = demand[place[5]] * (of[15] + of[16] * rates[4 + k])
        k += 2
    n = 7 + 4 * len(gyros)
    for wheel in range(len(turning)):
        of, place = turning[wheel], of_wheels[wheel]
        given = demand[place[3]] if place[2] < 0 else at[n + 2]
        wanted = of[4] * given + of[5] * rates[3 + k]
        torque[k] = min(max(wanted, -of[6]), of[6])
        n, k = n + 3, k + 1


def _find_slopes(gyros, turning, at, axes, rates, torque, slope):
    """How the motion in momenta changes by itself and by its motors."""
    q, i, j, l = at[0], at[1], at[2], at[3]  # noqa: E741 - the quaternion's four letters
    x, y, z = rates[0], rates[1], rates[2]
    slope[0] = 0.5 * -(i * x + j * y + l * z)
    slope[1] = 0.5 * (q * x + (j * z - l * y))
    slope[2] = 0.5 * (q * y + (l * x - i * z))
    slope[3] = 0.5 * (q * z + (i * y - j * x))
    slope[4], slope[5], slope[6] = 0.0, 0.0, 0.0
    n, k = 7, 0
    for unit in range(len(gyros)):
        of, axis = gyros[unit], axes[unit]
        along = axis[0] * x + axis[1] * y + axis[2] * z
        across = axis[3] * x + axis[4] * y + axis[5] * z
        slope[n] = rates[3 + k]
        slope[n + 1] = rates[4 + k]
        slope[n + 2] = torque[k] + across * (at[n + 3] + (of[9] - of[10]) * along)
        slope[n + 3] = torque[k + 1]
        n, k = n + 4, k + 2
    for wheel in range(len(turning)):
        slope[n] = rates[3 + k]
        slope[n + 1] = torque[k] - turning[wheel, 7] * rates[3 + k]
        n, k = n + 3, k + 1


def _act_from_outside(own, time, at, rates, slope):
    """H changes by gravity and drag of a bearing, or by what an orbit does."""
    u, v, w = _to_body(at, 0.0, 0.0, 1.0)
    x = v * own[8] - w * own[7] - own[9] * rates[0]
    y = w * own[6] - u * own[8] - own[9] * rates[1]
    z = u * own[7] - v * own[6] - own[9] * rates[2]
    if own[11] > 0.0:
        u, v, w = _on_orbit(own, time, at)
        x, y, z = x + u, y + v, z + w
    slope[4], slope[5], slope[6] = _to_inertial(at, x, y, z)


def _on_orbit(own, time, at):
    """Return 3 n² r × J r + m × B and the constant torque, body axes; see `environment.orbit_torque`."""
    cos, sin = np.cos(own[11] * time), np.sin(own[11] * time)
    x, y, z = _to_body(at, -sin, 0.0, cos)
    a, b, c = _to_body(at, cos * own[22] - sin * own[24], own[23], sin * own[22] + cos * own[24])
    u, v, w = _to_body(at, cos * own[25] - sin * own[27], own[26], sin * own[25] + cos * own[27])
    i = own[13] * x + own[18] * y + own[17] * z
    j = own[18] * x + own[14] * y + own[16] * z
    k = own[17] * x + own[16] * y + own[15] * z
    return (
        u + own[12] * (y * k - z * j) + own[20] * c - own[21] * b,
        v + own[12] * (z * i - x * k) + own[21] * a - own[19] * c,
        w + own[12] * (x * j - y * i) + own[19] * b - own[20] * a,
    )


def _lag(of_wheels, turning, demand, at, slope):
    """A motor with a lag comes to what is demanded with its time constant."""
    n = len(at) - 3 * len(turning)
    for wheel in range(len(turning)):
        place = of_wheels[wheel]
        slope[n + 2] = (demand[place[3]] - at[n + 2]) / turning[wheel, 8] if place[2] >= 0 else 0.0
        n += 3


def _turn_axes(of, angle, axis):
    """Write s(d) = s0 cos d + t0 sin d and t(d) = t0 cos d - s0 sin d."""
    cos, sin = np.cos(angle), np.sin(angle)
    for index in range(3):
        axis[index] = of[3 + index] * cos + of[6 + index] * sin
        axis[3 + index] = of[6 + index] * cos - of[3 + index] * sin


def _inertia(own, gyros, axes):
    """Return the six numbers of J(d), kg·m²."""
    a, b, c, d, e, f = own[0], own[1], own[2], own[3], own[4], own[5]
    for unit in range(len(gyros)):
        first, second = gyros[unit, 9], gyros[unit, 10]
        s, t, o = axes[unit, 0], axes[unit, 1], axes[unit, 2]
        u, v, w = axes[unit, 3], axes[unit, 4], axes[unit, 5]
        a += first * s * s + second * u * u
        b += first * t * t + second * v * v
        c += first * o * o + second * w * w
        d += first * t * o + second * v * w
        e += first * s * o + second * u * w
        f += first * s * t + second * u * v
    return a, b, c, d, e, f


def _held(gyros, turning, axes, at):
    """Return h = Σ p_r s + Σ p_g g + Σ p_w a, body axes."""
    x, y, z, n = 0.0, 0.0, 0.0, 7
    for unit in range(len(gyros)):
        of, axis, about, along = gyros[unit], axes[unit], at[n + 2], at[n + 3]
        x += along * axis[0] + about * of[0]
        y += along * axis[1] + about * of[1]
        z += along * axis[2] + about * of[2]
        n += 4
    for wheel in range(len(turning)):
        of, along = turning[wheel], at[n + 1]
        x += along * of[0]
        y += along * of[1]
        z += along * of[2]
        n += 3
    return x, y, z


def _to_body(at, x, y, z):
    """Return Rᵀ v; a quaternion between stages may be off unit length."""
    q, i, j, l = at[0], -at[1], -at[2], -at[3]  # noqa: E741 - the quaternion's four letters
    return _turned(q, i, j, l, x, y, z)


def _to_inertial(at, x, y, z):
    """Return R v, likewise."""
    return _turned(at[0], at[1], at[2], at[3], x, y, z)


def _turned(q, i, j, l, x, y, z):  # noqa: E741 - the quaternion's four letters
    """Return q ⊗ v ⊗ q⁻¹ = v + 2 (q (u × v) + u × (u × v)) / |q|² with u = (i, j, l)."""
    twice = 2.0 / (q * q + i * i + j * j + l * l)
    a, b, c = j * z - l * y, l * x - i * z, i * y - j * x
    return (
        x + twice * (q * a + j * c - l * b),
        y + twice * (q * b + l * a - i * c),
        z + twice * (q * c + i * b - j * a),
    )
