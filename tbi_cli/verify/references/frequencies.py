"""Natural frequencies: the vehicle on level, rigid track, closed forms for its body, and Tables 2 and 5."""

from __future__ import annotations

import math

import numpy as np

from tbi_cli.verify.references.energies import DYNAMIC, train_matrices
from tbi_cli.verify.references.parameters import Array, Beam, Train

# Table 5: critical velocities [m/s] of the left beam (modes 1-4) by span [m].
TABLE_5: dict[float, tuple[float, float, float, float]] = {
    30.0: (52.03, 208.14, 468.32, 832.57),
    40.0: (29.27, 117.08, 263.43, 468.32),
    50.0: (18.73, 74.93, 168.59, 299.72),
    60.0: (13.01, 52.03, 117.08, 208.14),
}
# Table 2, fourth mode: frequency [Hz] and critical velocity [m/s]. The table prints 299.745 for the left
# beam, a misprint: 14.986 Hz x 20 m and Table 5 both give 299.72.
TABLE_2_MODE_4: dict[str, tuple[float, float]] = {"right": (14.464, 289.277), "left": (14.986, 299.725)}


def frequencies(beam: Beam) -> Array:
    """(n,) f_j [Hz] = j^2 pi / (2 L^2) sqrt(EI / mu), Eq. (15)."""
    j = np.arange(1.0, beam.n + 1)
    return j**2 * math.pi / (2 * beam.length**2) * math.sqrt(beam.EI / beam.mu)


def critical_velocities(beam: Beam, d: float, i: int = 1) -> Array:
    """(n,) v_cr,j [m/s] = d f_j / i, Eq. (16), d the distance [m] from the first to the last axle."""
    v: Array = d * frequencies(beam) / i
    return v


def vehicle_frequencies(train: Train) -> Array:
    """(27,) natural frequencies [rad/s] of the undamped train on level, rigid track, sorted.

    The generalised eigenvalues of the energies of Eqs. (1a, b) with w = 0 and the wheelset y held. Three
    are zero: nothing holds the train sideways, in yaw, or, with wheelsets free to roll, in roll.
    """
    from scipy.linalg import eigh

    matrices = train_matrices(train)
    rows = matrices.wheel_rows
    K = matrices.K + rows.T @ (matrices.wheel_k[:, None] * rows)
    dynamic = list(DYNAMIC)
    squares = eigh(K[np.ix_(dynamic, dynamic)], np.diag(matrices.M[dynamic]), eigvals_only=True)
    return np.sqrt(np.clip(squares, 0.0, None))


def sprung_mass_bounce(mass: float, stiffness: float) -> float:
    """sqrt(k / m) [rad/s]."""
    return math.sqrt(stiffness / mass)


def body_bounce(train: Train) -> float:
    """Bounce of the body on bogies that cannot move, sqrt(2 (k_b1 + k_b2) / m_c) [rad/s]; l_b1 = l_b2."""
    return math.sqrt(2 * sum(b.secondary_vertical.k for b in train.bogies) / train.car_mass)


def body_pitch(train: Train) -> float:
    """Pitch of the body on bogies that cannot move, [rad/s]; for equal bogies and l_b1 = l_b2.

    sqrt(2 (k_b1 l_b1^2 + k_b2 l_b2^2) / I_cz).
    """
    stiffness = sum(2 * b.secondary_vertical.k * x**2 for b, x in zip(train.bogies, train.l_b, strict=True))
    return math.sqrt(stiffness / train.car_pitch)


def body_roll(train: Train) -> float:
    """Roll of the body against the bogies, each rigidly joined to its wheelsets, [rad/s]; heights zero.

    The wheelsets roll freely under the primary springs' reaction, so the bogies are not held: body and
    bogies swing against each other, omega^2 = kappa (2 / I_cx + 1 / (I_bx + 2 I_wx)), kappa = 2 k_b a^2.
    For equal bogies.
    """
    bogie = train.bogies[0]
    kappa = 2 * bogie.secondary_vertical.k * train.a**2
    return math.sqrt(kappa * (2 / train.car_roll + 1 / (bogie.roll + 2 * train.wheelset_roll)))
