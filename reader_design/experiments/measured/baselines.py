"""Laws of distance and of walls that a model has to beat, fitted to the same local means.

Each is fitted in two ways: to all observations, and with each source's own numbers from its own
observations but everything that sources share from the others (leave one out).
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

LEVEL_CUT = 0.2
"""Least slope to the horizontal, as a cosine of the normal, from which a facet is no wall [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Baseline:
    """One law: what is left of the local means when it is fitted.

    Parameters
    ----------
    name, own, shared : What it is called, and how many numbers each source and all share [-].
    residual_db : (o,) float64 — Measured less fitted [dB], with shared numbers from the others.
    sd_db : Root mean square of that [dB].
    """

    name: str
    own: int
    shared: int
    residual_db: FloatArray
    sd_db: float


def walls_crossed(scene: Scene, starts_m: FloatArray, ends_m: FloatArray) -> IntArray:
    """Return how many upright faces the straight line between two places crosses, (o,) [-].

    Parameters
    ----------
    scene : The room.
    starts_m, ends_m : (o, 3) float64 — Ends of the lines [m].
    """
    corners = scene.triangle_corners_m
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1)
    upright = np.abs(normal[:, 2]) < LEVEL_CUT * size
    facets = scene.triangle_facet[upright]
    base, u, v = (corners[upright, i] for i in range(3))
    u, v = u - base, v - base
    count = np.zeros(len(starts_m), dtype=np.int64)
    for i, (start, end) in enumerate(zip(starts_m, ends_m, strict=True)):
        way = end - start
        p = np.cross(way, v)
        det = np.sum(u * p, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = start - base
            a = np.sum(t * p, axis=1) / det
            q = np.cross(t, u)
            b = np.sum(way * q, axis=1) / det
            s = np.sum(v * q, axis=1) / det
            hit = (a >= 0.0) & (b >= 0.0) & (a + b <= 1.0) & (s > 1e-9) & (s < 1.0 - 1e-9)
        count[i] = len(np.unique(facets[hit]))  # a line through a seam of triangles meets one wall
    return count


def baselines(
    level_dbm: FloatArray, sources: IntArray, distance_m: FloatArray, walls: IntArray
) -> tuple[Baseline, ...]:
    """Return the standing laws, fitted to local means.

    Log-distance: L = L0 - 10 n lg d, with n of each source or one n of all. COST 231 multi-wall:
    besides, each wall that the straight line crosses costs the same [1]_.

    Parameters
    ----------
    level_dbm, sources : (o,) — Local means, not finite ones are left out [dBm]; their sources.
    distance_m, walls : (o,) — Distance [m], and walls between.

    References
    ----------
    .. [1] COST Action 231, "Digital mobile radio towards future generation systems", final report
       (1999), section 4.7.2, equation 4.7.2, with one kind of wall and no floor.
    """
    lg = -10.0 * np.log10(np.maximum(distance_m, 1e-3))
    count = -walls.astype(np.float64)
    laws = [
        ("log-distance, own exponent", [lg], []),
        ("log-distance, exponent from the others", [], [lg]),
    ]
    if walls.any():
        laws += [
            ("multi-wall (COST 231), own exponent", [lg], [count]),
            ("multi-wall (COST 231), exponent 2", [], [count]),
        ]
    out = []
    for name, own, shared in laws:
        offset = lg * 2.0 if name.endswith("exponent 2") else np.zeros_like(lg)
        residual = _left_out(level_dbm - offset, sources, own, shared)
        finite = residual[np.isfinite(residual)]
        sd = float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")
        out.append(
            Baseline(
                name=name, own=1 + len(own), shared=len(shared), residual_db=residual, sd_db=sd
            )
        )
    return tuple(out)


def _left_out(
    level: FloatArray, sources: IntArray, own: list[FloatArray], shared: list[FloatArray]
) -> FloatArray:
    """Return residuals with a source's own numbers from itself, shared ones from the others."""
    residual = np.full(len(level), np.nan)
    finite = np.isfinite(level)
    every = np.unique(sources[finite])
    for held in every:
        slopes: npt.NDArray[np.floating] = np.zeros(len(shared))
        others = finite & (sources != held) if len(every) > 1 else finite
        if shared:
            design = _without_own(np.column_stack(shared)[others], sources[others], own, others)
            target = _without_own(level[others][:, None], sources[others], own, others)[:, 0]
            slopes = np.linalg.lstsq(design, target, rcond=None)[0]
        mine = finite & (sources == held)
        rest: FloatArray = level[mine].copy()
        if shared:
            rest -= np.column_stack(shared)[mine] @ slopes
        columns = np.column_stack([np.ones(int(mine.sum())), *(c[mine] for c in own)])
        residual[mine] = rest - columns @ np.linalg.lstsq(columns, rest, rcond=None)[0]
    return residual


def _without_own(
    values: FloatArray, sources: IntArray, own: list[FloatArray], rows: npt.NDArray[np.bool_]
) -> FloatArray:
    """Return columns less what each source's own numbers explain of them (Frisch and Waugh)."""
    out = values.astype(np.float64).copy()
    for source in np.unique(sources):
        mine = sources == source
        columns = np.column_stack([np.ones(int(mine.sum())), *(c[rows][mine] for c in own)])
        out[mine] -= columns @ np.linalg.lstsq(columns, out[mine], rcond=None)[0]
    return out
