"""What the thesis found in its section 5.3, claim by claim, and what a study finds instead.

Claims are tested on the designs that the claim is about; where the sweep has not scored them, the
claim is left out. Nothing is assumed about the outcome.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from octant.em.decibels import power_dbm
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import Candidate, Choice
from octant.reader_design.showing.pages import ReportTable

NEAR_M, FAR_M = 0.05, 0.10
"""The thesis' two radii r_a [m]."""
BARE_M, LOW_M, HIGH_M = 0.0, 0.08, 0.15
"""The thesis' three plate heights h_p [m]."""
THESIS_GROUND_PLANE_M = 0.20
THESIS_LEVEL_W = 1.25e-6
"""Greatest RSS at the start of the thesis' first mission (section 5.4.1) [W]."""
THESIS_START_M = math.hypot(2.0, 0.5)
"""Horizontal distance from that start to the first tag [m]."""
UNDER_TAG_M = 0.4
"""Distance from the point under the tag below which the thesis receives too little [m]."""
USELESS_RAD = math.radians(45.0)
"""Rms error of the vector sum beyond which a reader is called useless [rad]: the spacing of its
antennas."""
USELESS_SHARE = 0.5
"""Share of right antennas below which a reader is called useless [-]."""
SAME_LEVEL_DB = 1.0
"""Levels this close agree [dB]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A claim of the thesis, tested.

    Attributes
    ----------
    text : What the thesis says, with its lengths in [cm].
    agrees : Whether this study finds the same; None where the thesis names no number.
    found : What this study finds, with numbers and units [%, deg, dB, W, m].
    """

    text: str
    agrees: bool | None
    found: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sweep:
    """Cells of the thesis' designs by antenna, r_a and h_p, and their places in the ranking."""

    cells: dict[tuple[str, float, float], Cell]
    places: dict[str, int]

    def get(self, antenna: str, radius_m: float, height_m: float) -> Cell | None:
        return self.cells.get((antenna, round(radius_m, 6), round(height_m, 6)))

    def best(self, antenna: str) -> Cell | None:
        mine = [c for (kind, _, _), c in self.cells.items() if kind == antenna]
        return min(mine, key=lambda c: self.places[c.key], default=None)


def thesis_claims(
    cells: Sequence[Cell],
    candidates: Sequence[Candidate],
    choice: Choice,
    *,
    tag_power_w: float,
) -> tuple[Claim, ...]:
    """Return the claims of thesis section 5.3 that a sweep can test, by scores in free space.

    Only cells of its designs count: eight antennas on a 20 cm square ground plane, full plates.

    Parameters
    ----------
    cells, candidates, choice : All cells, the scored ones, their ranking.
    tag_power_w : Power that the study's tags send [W]; levels are scaled to the thesis' 1 W.
    """
    places = {candidates[index].key: place for place, index in enumerate(choice.ranking)}
    table: dict[tuple[str, float, float], Cell] = {
        (
            c.design.antenna_kind,
            round(c.design.antenna_radius_m, 6),
            round(c.design.plate_height_m, 6),
        ): c
        for c in cells
        if c.free is not None and _is_the_thesis(c)
    }
    sweep = _Sweep(cells=table, places=places)
    return tuple(
        claim
        for claims in (
            _dipole_claims(sweep),
            _monopole_claims(sweep),
            _level_claims(sweep, tag_power_w),
        )
        for claim in claims
    )


def claim_sentence(claims: Sequence[Claim]) -> str:
    """Return in one sentence which claims of the thesis this study does not find.

    Parameters
    ----------
    claims : At least one.
    """
    tested = [c for c in claims if c.agrees is not None]
    against = [c.text.rstrip(".") for c in tested if not c.agrees]
    text = f"Of {len(tested)} claims of the thesis that this sweep can test, "
    if not against:
        return f"{text}all hold."
    return f"{text}{len(tested) - len(against)} hold; these do not: {'; '.join(against)}."


def claim_table(claims: Sequence[Claim]) -> ReportTable:
    """Return the claims as a table; numbers carry their units [%, deg, dB, W, m].

    Parameters
    ----------
    claims : At least one.
    """
    verdict = {True: "yes", False: "no", None: "–"}
    return ReportTable(
        caption="The thesis (section 5.3) and this study. Shares and errors are those of free "
        f"space; useless, or not told apart, means the wrong antenna in more than "
        f"{1.0 - USELESS_SHARE:.0%} of the directions, or a vector sum more than "
        f"{math.degrees(USELESS_RAD):.0f}° rms off.",
        header=("the thesis", "same here", "this study"),
        rows=tuple((c.text, verdict[c.agrees], c.found) for c in claims),
        words=True,
    )


def _is_the_thesis(cell: Cell) -> bool:
    d = cell.design
    plain = d.plate_height_axis_m in {None, d.plate_height_m} and d.plate_outer_radius_m in {
        None,
        0.5 * d.ground_plane_m,
    }
    return (
        plain
        and d.antennas == 8
        and d.ground_plane_shape == "square"
        and math.isclose(d.ground_plane_m, THESIS_GROUND_PLANE_M)
    )


def _scores(cell: Cell) -> str:
    """Return the scores in free space that claims are judged by."""
    free = cell.free
    if free is None:
        return "no scores"
    return (
        f"right antenna in {free.right_share:.0%} of the directions, vector sum "
        f"{math.degrees(free.vector_rms_rad):.0f}° rms off"
    )


def _useless(cell: Cell) -> bool:
    free = cell.free
    if free is None:
        return True
    return free.vector_rms_rad > USELESS_RAD or free.right_share < USELESS_SHARE


def _cm(length_m: float) -> str:
    return f"{100.0 * length_m:.4g} cm"


def _dipole_claims(sweep: _Sweep) -> Iterator[Claim]:
    best = sweep.best("dipole")
    if best is not None and sweep.get("dipole", FAR_M, LOW_M) and len(sweep.cells) > 1:
        d = best.design
        yield Claim(
            text="The best dipole design is r_a = 10 cm, h_p = 8 cm.",
            agrees=sweep.get("dipole", FAR_M, LOW_M) is best,
            found=f"The best dipole design is {d.label()}: {_scores(best)}.",
        )
    for radius_m in (NEAR_M, FAR_M):
        bare = sweep.get("dipole", radius_m, BARE_M)
        if bare is not None and bare.free is not None:
            worst = math.degrees(bare.free.strongest_max_rad)
            yield Claim(
                text=f"Dipoles at r_a = {_cm(radius_m)} without plates are useless."
                if radius_m == NEAR_M
                else f"At r_a = {_cm(radius_m)}, too, dipoles need plates.",
                agrees=_useless(bare),
                found=f"{_scores(bare)}; the strongest antenna is up to {worst:.0f}° off.",
            )
    for radius_m, confused in ((NEAR_M, True), (FAR_M, False)):
        for height_m in (LOW_M, HIGH_M):
            cell = sweep.get("dipole", radius_m, height_m)
            if cell is None or cell.free is None:
                continue
            worst_db = cell.free.margin_worst_db
            yield Claim(
                text=f"At r_a = {_cm(radius_m)}, h_p = {_cm(height_m)} the dipole that faces the "
                f"tag is {'not ' if confused else ''}always the strongest.",
                agrees=(worst_db < 0.0) == confused,
                found=f"The facing dipole leads its neighbours by {worst_db:+.1f} dB at worst, any "
                "of the eight facing the tag; antenna 1, which the thesis shows, is the strongest "
                f"over {_front_share(cell):.0%} of a drive away from {UNDER_TAG_M:g} m on; "
                f"{_scores(cell)}.",
            )


def _front_share(cell: Cell) -> float:
    """Return the share of the way on which antenna 1, which faces the tag, is the strongest."""
    beyond = cell.travel_m >= UNDER_TAG_M - LENGTHS.same_m
    return float((cell.travel_rss_w[beyond].argmax(axis=1) == 0).mean())


def _monopole_claims(sweep: _Sweep) -> Iterator[Claim]:
    for radius_m in (NEAR_M, FAR_M):
        bare = sweep.get("monopole", radius_m, BARE_M)
        if bare is not None:
            yield Claim(
                text=f"Monopoles at r_a = {_cm(radius_m)} without plates cannot be told apart.",
                agrees=_useless(bare),
                found=f"{_scores(bare)}.",
            )
    near = [sweep.get("monopole", NEAR_M, h) for h in (LOW_M, HIGH_M)]
    far = [sweep.get("monopole", FAR_M, h) for h in (LOW_M, HIGH_M)]
    shares = [[c.free.right_share for c in cs if c and c.free] for cs in (near, far)]
    if all(len(s) == 2 for s in shares):
        yield Claim(
            text="With plates of 8 or 15 cm, monopoles are told apart better at r_a = 10 cm.",
            agrees=min(shares[1]) > max(shares[0]),
            found="Right antenna in "
            + " and ".join(f"{s:.0%}" for s in shares[1])
            + " of the directions at 10 cm, "
            + " and ".join(f"{s:.0%}" for s in shares[0])
            + " at 5 cm.",
        )
    dipole, monopole = sweep.best("dipole"), sweep.best("monopole")
    if dipole is not None and monopole is not None:
        ahead = sweep.places[dipole.key] < sweep.places[monopole.key]
        yield Claim(
            text="Dipoles perform better than monopoles.",
            agrees=ahead,
            found=f"{dipole.design.label()}: {_scores(dipole)}; {monopole.design.label()}: "
            f"{_scores(monopole)}; the {'dipole' if ahead else 'monopole'} ranks first.",
        )


def _level_claims(sweep: _Sweep, tag_power_w: float) -> Iterator[Claim]:
    cell = sweep.get("dipole", FAR_M, LOW_M)
    if cell is None:
        return
    rss_w, distance = cell.travel_rss_w / tag_power_w, cell.travel_m
    front = rss_w[:, 0]
    peak = int(front.argmax())
    inside = rss_w[distance <= 0.5 * UNDER_TAG_M + LENGTHS.same_m].max()
    drop = float(power_dbm(front[peak]) - power_dbm(max(float(inside), 1e-30)))
    yield Claim(
        text=f"Within about {_cm(UNDER_TAG_M)} of the point under the tag, too little is received.",
        agrees=bool(drop > 10.0),
        found=f"Within {_cm(0.5 * UNDER_TAG_M)}, the strongest antenna stays {drop:.0f} dB or more "
        "below its greatest RSS.",
    )
    if distance[-1] < THESIS_START_M:
        return
    level = float(np.interp(THESIS_START_M, distance, front))
    off = float(power_dbm(level) - power_dbm(THESIS_LEVEL_W))
    yield Claim(
        text=f"At {THESIS_START_M:.2f} m from the tag the strongest antenna receives "
        f"{1e6 * THESIS_LEVEL_W:.3g} µW of the 1 W sent (section 5.4.1).",
        agrees=abs(off) <= SAME_LEVEL_DB,
        found=f"It receives {1e6 * level:.3g} µW there, {abs(off):.1f} dB "
        f"{'more' if off > 0.0 else 'less'}.",
    )
    yield Claim(
        text="The RSS has a maximum at some distance (Fig. 5.9; its text gives no number).",
        agrees=None,
        found=f"The RSS of the antenna that faces the tag is greatest, {1e6 * front[peak]:.3g} µW, "
        f"{distance[peak]:.2f} m from the point under the tag.",
    )
