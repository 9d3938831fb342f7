"""Poses along a way that is known interval by interval."""

import numpy as np

from octant.navigation.robot.motion import move


def dead_reckon(start, *, distance_m, turn_rad, method="exact"):
    """Return the poses (k + 1, 3) from the ways and turns of k intervals."""
    headings = start[2] + np.concatenate([[0.0], np.cumsum(turn_rad)])
    origins = np.column_stack([np.zeros((len(turn_rad), 2)), headings[:-1]])
    steps = move(origins, distance_m=distance_m, turn_rad=turn_rad, method=method)[:, :2]
    places = start[:2] + np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return np.column_stack([places, headings])
