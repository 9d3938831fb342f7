"""Write what the start of the thesis' parabola moves: ``open_choices.csv`` in a folder.

    python docs/open_choices.py FOLDER

The parabola of thesis 7.5.1.2 is followed by the nominal control from several starts, since its own
is not printed: the distance at the start, and the average over the 60 s.
"""

import csv
import sys
from pathlib import Path

import numpy as np

from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.tracking.nominal import BoundedIlqr
from octant.navigation.tracking.problem import TrackingProblem, tracking_weights
from octant.navigation.tracking.shapes import parabola
from octant.navigation.tracking.trajectories import desired_trajectory

STARTS_M = ((-5.0, 10.0), (-4.5, 10.0), (-4.0, 8.0), (-4.0, 5.0), (-3.0, 5.0), (-4.0, 2.0))
"""On the way, beside it, and ever farther from it; heading 0 as in the thesis' other tasks."""
PERIOD_S, SUBSTEPS = 0.6, 12
WHEEL_RATE_RAD_PER_S = 10.0


def main(folder: Path) -> None:
    """Solve from every start and write the table [m]."""
    plain = DifferentialDrive()
    robot = DifferentialDrive(max_wheel_speed_m_per_s=WHEEL_RATE_RAD_PER_S * plain.wheel_radius_m)
    desired = desired_trajectory(parabola(), period_s=PERIOD_S / SUBSTEPS)
    rows = []
    for x_m, y_m in STARTS_M:
        problem = TrackingProblem(
            desired=desired,
            start=np.array((x_m, y_m, 0.0)),
            weights=tracking_weights(),
            robot=robot,
            substeps=SUBSTEPS,
        )
        poses = BoundedIlqr().solve(problem).poses
        away = np.linalg.norm(poses[:, :2] - desired.poses[:, :2], axis=1)
        rows.append((f"({x_m:g}, {y_m:g})", away[0], away[:-1].mean()))
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "open_choices.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("parabola_start_m", "first_m", "average_m"))
        writer.writerows(rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
