"""The six inertia parameters θ = [J11, J22, J33, J23, J13, J12] and the regressors that they multiply."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Matrix3, Theta, Vectors3

PARAMETER_NAMES = ("J11", "J22", "J33", "J23", "J13", "J12")
"""Order of the inertia parameters. Source: paper section 2, below eq. (4)."""

ROWS = np.array([0, 1, 2, 1, 0, 0])
COLUMNS = np.array([0, 1, 2, 2, 2, 1])
"""Of J, in the order of θ."""


def theta_of(inertia: Matrix3) -> Theta:
    """Return θ of a symmetric inertia matrix, kg·m². Broadcasts over leading axes."""
    return np.asarray(inertia[..., ROWS, COLUMNS], dtype=np.float64)


def inertia_of(theta: Theta) -> Matrix3:
    """Return the symmetric matrix J of θ, kg·m². Broadcasts over leading axes. Source: paper eq. (3)."""
    theta = np.asarray(theta, dtype=np.float64)
    inertia = np.empty((*theta.shape[:-1], 3, 3))
    inertia[..., ROWS, COLUMNS] = theta
    inertia[..., COLUMNS, ROWS] = theta
    return inertia


def momentum_regressor(body_rate: Vectors3) -> Array:
    """Return Γ(ω), shape (..., 3, 6), so that Γ(ω) θ = J ω. Source: paper eq. (6).

    Args:
        body_rate: ω, shape (..., 3), rad/s, body axes.
    """
    x, y, z = np.moveaxis(np.asarray(body_rate, dtype=np.float64), -1, 0)
    gamma = np.zeros((*x.shape, 3, 6))
    gamma[..., 0, 0], gamma[..., 0, 4], gamma[..., 0, 5] = x, z, y  # eq. (6)
    gamma[..., 1, 1], gamma[..., 1, 3], gamma[..., 1, 5] = y, z, x
    gamma[..., 2, 2], gamma[..., 2, 3], gamma[..., 2, 4] = z, y, x
    return gamma


def torque_regressor(body_rate: Vectors3, body_acceleration: Vectors3) -> Array:
    """Return ψ(ω, ω̇) = Γ(ω̇) + ω× Γ(ω), shape (..., 3, 6). Source: paper eqs. (5), (7).

    Args:
        body_rate: ω, shape (..., 3), rad/s, body axes.
        body_acceleration: ω̇, shape (..., 3), rad/s², body axes.
    """
    return momentum_regressor(body_acceleration) + cross_matrix(body_rate) @ momentum_regressor(body_rate)


def turning_regressor(products: Array) -> Array:
    """Return ω× Γ(ω), shape (..., 3, 6), of the six products ω_a ω_b, in which it is linear.

    Args:
        products: shape (..., 6), (rad/s)², as from `rate_products`; also what a linear filter makes of them.
    """
    return np.asarray((products @ _TURNING).reshape(*products.shape[:-1], 3, 6))


def rate_products(body_rate: Vectors3) -> Array:
    """Return ω_a ω_b of the six pairs of axes, shape (..., 6), in the order of θ."""
    return np.asarray(body_rate[..., ROWS] * body_rate[..., COLUMNS])


def cross_matrix(vector: Vectors3) -> Array:
    """Return the matrix of v×, shape (..., 3, 3). Source: paper eq. (2).

    Args:
        vector: shape (..., 3).
    """
    x, y, z = np.moveaxis(np.asarray(vector, dtype=np.float64), -1, 0)
    matrix = np.zeros((*x.shape, 3, 3))
    matrix[..., 0, 1], matrix[..., 0, 2] = -z, y
    matrix[..., 1, 0], matrix[..., 1, 2] = z, -x
    matrix[..., 2, 0], matrix[..., 2, 1] = -y, x
    return matrix


def symmetric_inverse(matrix: Array) -> Array:
    """Return the inverses of symmetric 3 × 3 matrices, shape (..., 3, 3), by cofactors; analytic in the entries."""
    a, b, c = matrix[..., 0, 0], matrix[..., 1, 1], matrix[..., 2, 2]
    d, e, f = matrix[..., 1, 2], matrix[..., 0, 2], matrix[..., 0, 1]
    xx, yy, zz = b * c - d * d, a * c - e * e, a * b - f * f
    yz, xz, xy = e * f - a * d, d * f - b * e, d * e - c * f
    determinant = a * xx + f * xy + e * xz
    rows = [np.stack(row, axis=-1) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))]
    return np.asarray(np.stack(rows, axis=-2) / determinant[..., None, None])


def log_ratio(inertia: Matrix3, nominal: Matrix3) -> Theta:
    """Return the logarithm U of an inertia over a nominal one, J = L exp(U) Lᵀ with J_nominal = L Lᵀ, in θ's order.

    Its eigenvalues are the logarithms of the ratios about the axes that both share; any U is of a body.

    Args:
        inertia: J, positive definite, shape (3, 3), kg·m².
        nominal: likewise.
    """
    root = np.linalg.inv(np.linalg.cholesky(nominal))
    ratios, axes = np.linalg.eigh(root @ inertia @ root.T)
    return theta_of((axes * np.log(ratios)) @ axes.T)


def of_log_ratio(logarithm: Theta, nominal: Matrix3) -> Matrix3:
    """Return the inertia of which `log_ratio` is U, shape (3, 3), kg·m²."""
    root = np.linalg.cholesky(nominal)
    ratios, axes = np.linalg.eigh(inertia_of(logarithm))
    return np.asarray(root @ (axes * np.exp(ratios)) @ axes.T @ root.T)


def slopes_of_log_ratio(logarithm: Theta, nominal: Matrix3, turned: Matrix3) -> Array:
    """Return ∂θ/∂U, shape (6, 6), kg·m², along the six symmetric directions of U in axes of one's choice.

    Source: Daleckii and Krein, derivatives of a function of a symmetric matrix by divided differences (1965).

    Args:
        logarithm: U, shape (6,).
        nominal: shape (3, 3), kg·m².
        turned: the axes, columns, shape (3, 3).
    """
    root = np.linalg.cholesky(nominal)
    ratios, axes = np.linalg.eigh(inertia_of(logarithm))
    middle, half = 0.5 * np.add.outer(ratios, ratios), 0.5 * np.subtract.outer(ratios, ratios)
    divided = np.exp(middle) * np.sinc(1j * half / np.pi).real  # sinh(x)/x
    ways = turned @ inertia_of(np.eye(6)) @ turned.T
    changes = root @ axes @ (divided * (axes.T @ ways @ axes)) @ axes.T @ root.T
    return np.asarray(theta_of(changes).T)


def _turning() -> Array:
    """Return ω× Γ(ω) as a linear map of the six products, shape (6, 18)."""
    axes = np.eye(3)
    product = np.einsum("aij,bjk->abik", cross_matrix(axes), momentum_regressor(axes))
    product += np.swapaxes(product, 0, 1) * (1.0 - axes)[..., None, None]  # ω_a ω_b stands for both orders
    return np.asarray(product[ROWS, COLUMNS].reshape(6, 18))


_TURNING = _turning()
