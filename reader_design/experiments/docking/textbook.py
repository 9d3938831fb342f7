"""What the textbook and the docking paper derive before they drive: odometry, observability."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from octant.navigation.control.chained_form import chained_step, of_chained, to_chained
from octant.navigation.control.closed_loop import ClosedLoop
from octant.navigation.estimators.observability import (
    attitude_gramian,
    attitude_observability,
    position_gramian,
    slip_deviation,
)
from octant.navigation.robot.motion import Integration, move
from octant.reader_design.study_file.dock import Dock

FloatArray = npt.NDArray[np.float64]

INTEGRATIONS: Mapping[str, Integration] = {
    "Euler (11.83)": "euler",
    "Runge-Kutta (11.84)": "rk2",
    "exact (11.85)": "exact",
}
"""Steps of odometry by their names in the textbook."""

CHAINED = "chained form (11.25)"
PERIODS_S = (0.1, 0.5, 1.0)
SIGHTS_S = (1.0, 5.0, 20.0)
_LEAST_SPEED_SHARE = 1e-6
TURN_RATES_RAD_PER_S = (0.0, 0.2, 1.0)


def half_circle(table: Dock) -> tuple[float, float, float]:
    """Return speed [m/s], turn rate [rad/s] and time [s] of half a circle at the dock's limits.

    Parameters
    ----------
    table : The table ``[dock]``.
    """
    turn_rate = float(np.radians(table.max_turn_rate_deg_per_s))
    return table.max_speed_m_per_s, turn_rate, np.pi / turn_rate


def odometry_error_m(table: Dock, method: Integration | None, period_s: float) -> float:
    """Return how far odometry is off at the end of `half_circle` [m].

    The last period is shorter, so that all end with the circle.

    Parameters
    ----------
    table : The table ``[dock]``.
    method : Of a period; None: through the chained form.
    period_s : Sample period [s].
    """
    speed, turn_rate, time_s = half_circle(table)
    whole = int(time_s / period_s)
    periods = [*[period_s] * whole, time_s - whole * period_s]
    pose, chained = np.zeros(3), to_chained(np.zeros(3))
    for step_s in periods:
        if method is None:
            chained = chained_step(chained, [speed, turn_rate], period_s=step_s)
            pose = of_chained(chained)
        else:
            pose = move(pose, distance_m=speed * step_s, turn_rad=turn_rate * step_s, method=method)
    # Half a circle ends a diameter to the left of where it began.
    return float(np.hypot(pose[0], pose[1] - 2.0 * speed / turn_rate))


def odometry_rows(table: Dock) -> tuple[tuple[str, ...], ...]:
    """Return a row of errors [m] by period for each step of odometry, as the report shows them.

    Parameters
    ----------
    table : The table ``[dock]``.
    """
    methods: dict[str, Integration | None] = {**INTEGRATIONS, CHAINED: None}
    return tuple(
        (name, *(f"{odometry_error_m(table, method, period):.2g}" for period in PERIODS_S))
        for name, method in methods.items()
    )


def observability_rows(table: Dock) -> tuple[tuple[str, ...], ...]:
    """Return a row for attitude and slip and one for each turn rate, as the report shows them.

    What is observed, rank, and the least standard deviation of its slip after `SIGHTS_S`.

    Parameters
    ----------
    table : The table ``[dock]``: noise of the camera and its sample time.
    """
    period_s = table.sample_time_s
    attitude = [attitude_gramian(t) for t in SIGHTS_S]
    variance = float(np.radians(table.attitude_sd_deg)) ** 2
    rows = [
        (
            "attitude ψ, slip s: (7)",
            f"{np.linalg.matrix_rank(attitude_observability())} of 2",
            *(_deviation(gramian, variance, period_s, "rad/s") for gramian in attitude),
        )
    ]
    for rate in TURN_RATES_RAD_PER_S:
        place = [position_gramian(t, turn_rate_rad_per_s=rate) for t in SIGHTS_S]
        variance = table.position_sd_m**2
        rows.append(
            (
                f"place e, slip b: (27), ω = {rate:g} rad/s",
                f"{min(np.linalg.matrix_rank(gramian) for gramian in place)} of 3",
                *(
                    _deviation(gramian, table.position_sd_m**2, period_s, "m/s")
                    for gramian in place
                ),
            )
        )
    return tuple(rows)


def _deviation(gramian: FloatArray, variance: float, period_s: float, unit: str) -> str:
    found = slip_deviation(gramian, measured_variance=variance, period_s=period_s)
    return f"{found:.2g} {unit}"


def regulator_rows(loops: Mapping[str, Sequence[ClosedLoop]]) -> tuple[tuple[str, ...], ...]:
    """Return a row for each law and start, as the report shows them.

    Law, start, final distance and heading, how often the motion is inverted, and which way it ends:
    the textbook has one inversion at most, and forward motion in the end.

    Parameters
    ----------
    loops : Runs by law.
    """
    rows = []
    for name, runs in loops.items():
        for loop in runs:
            (x, y, heading), last = np.round(loop.pose[0], 9) + 0.0, loop.pose[-1]
            speed = loop.twist[:, 0]
            # At the goal the speed's sign is the integrator's noise.
            ways = np.sign(speed[np.abs(speed) > _LEAST_SPEED_SHARE * np.abs(speed).max()])
            rows.append(
                (
                    name,
                    f"({x:.3g}, {y:.3g}) m, {np.degrees(heading):.0f}°",
                    f"{np.hypot(*last[:2]):.2g}",
                    f"{np.degrees(last[2]):.2f}",
                    str(int(np.sum(ways[1:] != ways[:-1]))),
                    "forward" if ways[-1] > 0.0 else "backward",
                )
            )
    return tuple(rows)
