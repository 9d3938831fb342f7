"""The scores that a tolerance study shows: names, units, and how to read them from a case."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.tolerance.cases import CaseScores
from octant.reader_design.study_file.tolerance import Limits

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """One score as shown.

    Attributes
    ----------
    name, title : Name in files, and for people.
    unit : Unit of the values shown, ``1`` without.
    where : ``free``, ``room`` or ``level``.
    field : Field of the scores, or the number of the distance.
    factor : What the field's own value is multiplied by [-].
    high_is_good : Whether more is better.
    """

    name: str
    title: str
    unit: str
    where: str
    field: str
    factor: float = 1.0
    high_is_good: bool = True

    def of(self, scores: CaseScores) -> float:
        """Return the value for a case [``unit``]; NaN for one that cannot be built.

        Parameters
        ----------
        scores : The case.
        """
        if scores.reason:
            return math.nan
        if self.where == "level":
            return scores.levels_dbm[int(self.field)]
        return self.factor * float(getattr(getattr(scores, self.where), self.field))

    @property
    def change_unit(self) -> str:
        """Unit of differences of the values: that of levels in dBm is dB."""
        return "dB" if self.unit == "dBm" else self.unit

    def label(self) -> str:
        """Return title and unit [``unit``], for axes and tables."""
        return self.title if self.unit == "1" else f"{self.title} [{self.unit}]"


DEGREES = 180.0 / math.pi


def views(distances_m: tuple[float, ...], *, room: bool) -> tuple[View, ...]:
    """Return the scores to show, in their order.

    Parameters
    ----------
    distances_m : Distances in free space [m].
    room : Whether the room is scored, too.
    """
    shown = [
        View(
            name="right_share",
            title="share of right antennas",
            unit="1",
            where="free",
            field="right_share",
        ),
        View(
            name="margin_worst_db",
            title="worst margin over the neighbours",
            unit="dB",
            where="free",
            field="margin_worst_db",
        ),
        View(
            name="vector_rms_deg",
            title="bearing error of the vector sum, rms",
            unit="°",
            where="free",
            field="vector_rms_rad",
            factor=DEGREES,
            high_is_good=False,
        ),
        View(
            name="front_to_back_mean_db",
            title="front-to-back ratio, mean",
            unit="dB",
            where="free",
            field="front_to_back_mean_db",
        ),
    ]
    for i, distance in enumerate(distances_m):
        shown.append(
            View(
                name=f"level_{distance:g}m_dbm",
                title=f"level at {distance:g} m",
                unit="dBm",
                where="level",
                field=str(i),
            )
        )
    if room:
        for name, title, unit, factor in (
            ("right_share", "share of right antennas in the room", "1", 1.0),
            ("vector_rms_rad", "bearing error of the vector sum in the room, rms", "°", DEGREES),
            ("margin_mean_db", "mean margin in the room", "dB", 1.0),
            ("level_median_dbm", "median level in the room", "dBm", 1.0),
        ):
            shown.append(
                View(
                    name=f"room_{name.replace('_rad', '_deg')}",
                    title=title,
                    unit=unit,
                    where="room",
                    field=name,
                    factor=factor,
                    high_is_good=unit != "°",
                )
            )
    return tuple(shown)


def values_of(shown: tuple[View, ...], cases: tuple[CaseScores, ...]) -> FloatArray:
    """Return the scores of cases, a row each [units of the views]; NaN where it cannot be built.

    Parameters
    ----------
    shown, cases : Columns and rows.
    """
    return np.array([[view.of(case) for view in shown] for case in cases]).reshape(
        len(cases), len(shown)
    )


def meets(limits: Limits, case: CaseScores) -> bool:
    """Return whether a reader meets every limit given; one that cannot be built does not.

    Parameters
    ----------
    limits, case : What it must reach; the reader's scores.
    """
    free = case.free
    if free is None:
        return False
    least = (
        (limits.least_right_share, free.right_share),
        (limits.least_margin_db, free.margin_worst_db),
        (limits.least_front_to_back_db, free.front_to_back_mean_db),
        (limits.least_level_dbm, min(case.levels_dbm)),
    )
    most = limits.most_vector_rms_deg
    if most is not None and DEGREES * free.vector_rms_rad > most:
        return False
    # Shares are sums of weights: 1 may come out as 1 - 1e-16.
    return all(limit is None or value >= limit - 1e-12 for limit, value in least)


def limit_texts(limits: Limits) -> tuple[str, ...]:
    """Return a half-sentence for each limit that is given, with its unit.

    Parameters
    ----------
    limits : What is asked for.
    """
    texts = (
        (limits.least_right_share, "share of right antennas at least {:.3g}"),
        (limits.least_margin_db, "worst margin at least {:.3g} dB"),
        (limits.most_vector_rms_deg, "vector-sum bearing error at most {:.3g}° rms"),
        (limits.least_front_to_back_db, "mean front-to-back ratio at least {:.3g} dB"),
        (limits.least_level_dbm, "level at least {:.4g} dBm at every distance"),
    )
    return tuple(text.format(value) for value, text in texts if value is not None)
