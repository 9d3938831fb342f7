"""What the thesis found in its section 5.3, claim by claim, and what a study finds instead.

Each claim is judged first in the thesis' own measure: antenna 1 towards the tag on a drive away
from it, 3 m below it (`thesis_setup`). What Octant's stricter scores say (any antenna towards the
tag, all azimuths, the study's own heights) stands beside that and does not count. Claims are tested
on the designs that they are about; where the sweep has not scored them, the claim is left out.

The thesis names no numbers for "discriminated", "better" and "best". Its bearing (5.2) is the
strongest antenna's, and its figures and its controller take watts, so that here

* antennas are told apart where antenna 1 is the strongest on more than half of the drive;
* antenna 1 is always the strongest where it is so at every place;
* a design is better the more watts antenna 1 has over the strongest other one, mean of the drive;

each from 40 cm on, as the thesis says of nearer places that too little is received there.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.experiments.choice.thesis_setup import (
    START_M,
    LoneAntenna,
    ThesisDrive,
    ThesisSetup,
)
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import Candidate, Choice
from octant.reader_design.showing.pages import ReportTable

NEAR_M, FAR_M = 0.05, 0.10
"""The thesis' two radii r_a [m]."""
BARE_M, LOW_M, HIGH_M = 0.0, 0.08, 0.15
"""The thesis' three plate heights h_p [m]."""
LEVEL_W = 1.25e-6
"""Greatest RSS at the start of the thesis' first mission (section 5.4.1, page 74) [W]."""
UNDER_TAG_M = 0.4
"""Distance from the point under the tag below which the thesis receives too little [m]."""
USELESS_RAD = math.radians(45.0)
"""Octant's measure: rms error of the vector sum beyond which a reader is useless [rad]."""
APART_SHARE = 0.5
"""Share of places, or of directions, with the right antenna above which antennas are told apart."""
SAME_LEVEL_DB = 1.0
"""Levels this close agree [dB]."""
LITTLE_DB, NOTHING_DB = 10.0, 20.0
"""How far below the drive's greatest RSS too little, and next to nothing, is received [dB]."""
PUBLISHED_ANTENNAS = {
    "dipole": (76.64, 27.79, 1.65, "page 70, Fig. 5.8"),
    "monopole": (32.12, 22.76, 1.22, "pages 71-72, Fig. 5.10"),
}
"""Resistance and reactance [ohm], gain [dBi] and place of the thesis' two antennas."""
READINGS = {
    "dipole": "The published impedance is that of a very thin wire 1 % short of half a wave, and "
    "the gain that of such a dipole less the 0.4 dB that 50 Ω lose with that impedance: 1.76 dBi.",
    "monopole": "The plane, “4 cm² × 4 cm²”, is read as 4 cm × 4 cm: the gain is that of a "
    "monopole on it less the 0.5 dB that 50 Ω lose with the published impedance, which itself is "
    "nearer to that over an endless plane.",
}
"""How the published values are likely to be meant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A claim of the thesis, tested.

    Attributes
    ----------
    text : What the thesis says, with its lengths in [cm].
    where : Page, figure or section of the thesis.
    agrees : Whether this study finds the same in the thesis' measure; None where the thesis claims
        nothing that can be judged.
    found : What it finds in that measure, with numbers and units [%, dB, W, m].
    stricter_agrees, stricter : The same by Octant's scores [%, deg, dB]; None, empty: none.
    """

    text: str
    where: str
    agrees: bool | None
    found: str
    stricter_agrees: bool | None = None
    stricter: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Design:
    """One of the thesis' designs: its cell and its drive."""

    cell: Cell
    drive: ThesisDrive

    @property
    def apart(self) -> float:
        """The share of places at which antenna 1, which faces the tag, is the strongest."""
        return float((self.beyond_w.argmax(axis=1) == 0).mean())

    @property
    def beyond_w(self) -> npt.NDArray[np.float64]:
        """RSS of the places from 40 cm on [W]."""
        return self.drive.rss_w[self.drive.travel_m >= UNDER_TAG_M - LENGTHS.same_m]

    @property
    def lead_w(self) -> float:
        """The mean lead of antenna 1 over the strongest other one [W]."""
        rss = self.beyond_w
        return float((rss[:, 0] - rss[:, 1:].max(axis=1)).mean())

    @property
    def lead_db(self) -> float:
        rss = self.beyond_w
        return float((power_dbm(rss[:, 0]) - power_dbm(rss[:, 1:].max(axis=1))).mean())

    def strongest_text(self) -> str:
        return f"antenna 1 is the strongest over {100 * self.apart:.0f} % of the drive"

    def lead_text(self) -> str:
        return f"{1e6 * self.lead_w:+.2f} µW ({self.lead_db:+.1f} dB)"

    def drive_text(self) -> str:
        return f"{_sentence(self.strongest_text())} Its mean lead is {self.lead_text()}."

    def scores_text(self) -> str:
        free = self.cell.free
        if free is None:
            return "no scores"
        return (
            f"right antenna in {100 * free.right_share:.0f} % of the directions, vector sum "
            f"{math.degrees(free.vector_rms_rad):.0f}° rms off"
        )

    @property
    def useless(self) -> bool:
        free = self.cell.free
        if free is None:
            return True
        return free.vector_rms_rad > USELESS_RAD or free.right_share < APART_SHARE


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sweep:
    """The thesis' designs by antenna, r_a and h_p, and their places in Octant's ranking."""

    designs: dict[tuple[str, float, float], _Design]
    places: dict[str, int]

    def get(self, antenna: str, radius_m: float, height_m: float) -> _Design | None:
        return self.designs.get((antenna, round(radius_m, 6), round(height_m, 6)))

    def all_of(self, antenna: str) -> list[_Design]:
        return [d for (kind, _, _), d in self.designs.items() if kind == antenna]

    def first(self, designs: Sequence[_Design]) -> _Design:
        return min(designs, key=lambda d: self.places[d.cell.key])


def thesis_claims(
    cells: Sequence[Cell], candidates: Sequence[Candidate], choice: Choice, setup: ThesisSetup
) -> tuple[Claim, ...]:
    """Return the claims of thesis section 5.3 that a sweep can test, numbers with their units.

    Parameters
    ----------
    cells, candidates, choice : All cells, the scored ones, their ranking.
    setup : What the thesis' designs among the cells receive in its set-up [W].
    """
    places = {candidates[index].key: place for place, index in enumerate(choice.ranking)}
    designs = {
        (
            cell.design.antenna_kind,
            round(cell.design.antenna_radius_m, 6),
            round(cell.design.plate_height_m, 6),
        ): _Design(cell=cell, drive=setup.drives[cell.key])
        for cell in cells
        if cell.key in setup.drives
    }
    sweep = _Sweep(designs=designs, places=places)
    return (
        *_dipole_claims(sweep),
        *_monopole_claims(sweep),
        *_level_claims(sweep),
        *(_antenna_claim(kind, alone) for kind, alone in setup.antennas.items()),
    )


def claim_sentence(claims: Sequence[Claim]) -> str:
    """Return in one sentence which claims of the thesis this study does not find.

    Parameters
    ----------
    claims : At least one.
    """
    tested = [c for c in claims if c.agrees is not None]
    against = [c.text.rstrip(".") for c in tested if not c.agrees]
    text = (
        f"Of {len(tested)} claims of thesis section 5.3 that this sweep can test, in the thesis' "
        "own measure "
    )
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
        caption="The thesis (section 5.3) and this study. The thesis' measure: the tag, 1 W at 2.4 "
        "GHz, 3 m above the reader's plane, nothing that reflects, antenna 1 towards the tag on a "
        f"drive away from it, from {100.0 * UNDER_TAG_M:.0f} cm to 5 m along the floor. The thesis "
        "gives no number for “discriminated” and “better”; here antennas are told apart where "
        f"antenna 1 is the strongest over more than {100 * APART_SHARE:.0f} % of the drive, "
        "and the better design is that in which it leads by more watts. Octant's measure beside "
        "it: this study's heights, all azimuths, any antenna towards the tag, useless where the "
        f"strongest antenna is the wrong one in more than {100 * (1.0 - APART_SHARE):.0f} % of the "
        f"directions or the vector sum more than {math.degrees(USELESS_RAD):.0f}° rms off.",
        header=(
            "the thesis",
            "where",
            "same here",
            "this study, in the thesis' measure",
            "by Octant's",
            "Octant's stricter measure",
        ),
        rows=tuple(
            (c.text, c.where, verdict[c.agrees], c.found, verdict[c.stricter_agrees], c.stricter)
            for c in claims
        ),
        words=True,
    )


def _cm(length_m: float) -> str:
    return f"{100.0 * length_m:.4g} cm"


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def _dipole_claims(sweep: _Sweep) -> Iterator[Claim]:
    bare = sweep.get("dipole", NEAR_M, BARE_M)
    if bare is not None:
        yield Claim(
            text="Dipoles at r_a = 5 cm without plates cannot be told apart.",
            where="page 71, Fig. 5.9 (a)",
            agrees=bare.apart <= APART_SHARE,
            found=bare.drive_text(),
            stricter_agrees=bare.useless,
            stricter=_sentence(bare.scores_text()),
        )
    for radius_m, confused, figure in ((NEAR_M, True, "(a)"), (FAR_M, False, "(b)")):
        for height_m in (LOW_M, HIGH_M):
            design = sweep.get("dipole", radius_m, height_m)
            if design is None or design.cell.free is None:
                continue
            worst_db = design.cell.free.margin_worst_db
            yield Claim(
                text=f"At r_a = {_cm(radius_m)}, h_p = {_cm(height_m)} the dipole that faces the "
                f"tag is {'not ' if confused else ''}always the strongest.",
                where=f"page 71, Fig. 5.9 {figure}",
                agrees=(design.apart < 1.0) == confused,
                found=design.drive_text(),
                stricter_agrees=(worst_db < 0.0) == confused,
                stricter=f"Any of the eight that faces the tag leads its neighbours by "
                f"{worst_db:+.1f} dB at worst; {design.scores_text()}.",
            )
    chosen, dipoles = sweep.get("dipole", FAR_M, LOW_M), sweep.all_of("dipole")
    if chosen is not None and len(dipoles) > 1:
        best, ranked = max(dipoles, key=lambda d: d.lead_w), sweep.first(dipoles)
        yield Claim(
            text="The best dipole design is r_a = 10 cm, h_p = 8 cm.",
            where="pages 71 and 73",
            agrees=chosen is best,
            found=f"Antenna 1 of the {best.cell.design.label()} has the greatest mean lead, "
            f"{best.lead_text()}; that of r_a = 10 cm, h_p = 8 cm has {chosen.lead_text()}.",
            stricter_agrees=chosen is ranked,
            stricter=f"{ranked.cell.design.label()} ranks first: {ranked.scores_text()}.",
        )


def _monopole_claims(sweep: _Sweep) -> Iterator[Claim]:
    for radius_m, figure in ((NEAR_M, "(a)"), (FAR_M, "(b)")):
        bare = sweep.get("monopole", radius_m, BARE_M)
        if bare is not None:
            yield Claim(
                text=f"Monopoles at r_a = {_cm(radius_m)} without plates cannot be told apart.",
                where=f"page 72, Fig. 5.11 {figure}",
                agrees=bare.apart <= APART_SHARE,
                found=bare.drive_text(),
                stricter_agrees=bare.useless,
                stricter=_sentence(bare.scores_text()),
            )
    near = [d for h in (LOW_M, HIGH_M) if (d := sweep.get("monopole", NEAR_M, h))]
    far = [d for h in (LOW_M, HIGH_M) if (d := sweep.get("monopole", FAR_M, h))]
    if len(near) == len(far) == 2:
        leads = [[d.lead_w for d in designs] for designs in (far, near)]
        shares = [[d.cell.free.right_share for d in ds if d.cell.free] for ds in (far, near)]
        yield Claim(
            text="With plates of 8 or 15 cm, monopoles are told apart better at r_a = 10 cm.",
            where="page 72, Fig. 5.11",
            agrees=min(leads[0]) > max(leads[1]),
            found="The mean lead of antenna 1 is "
            + " and ".join(d.lead_text() for d in far)
            + " at 10 cm, "
            + " and ".join(d.lead_text() for d in near)
            + " at 5 cm.",
            stricter_agrees=min(shares[0]) > max(shares[1]),
            stricter="Right antenna in "
            + " and ".join(f"{100 * s:.0f} %" for s in shares[0])
            + " of the directions at 10 cm, "
            + " and ".join(f"{100 * s:.0f} %" for s in shares[1])
            + " at 5 cm.",
        )
    dipoles, monopoles = sweep.all_of("dipole"), sweep.all_of("monopole")
    if dipoles and monopoles:
        best = [max(designs, key=lambda d: d.lead_w) for designs in (dipoles, monopoles)]
        ranked = [sweep.first(designs) for designs in (dipoles, monopoles)]
        ahead = sweep.places[ranked[0].cell.key] < sweep.places[ranked[1].cell.key]
        yield Claim(
            text="Dipoles perform better than monopoles.",
            where="pages 72-73, Figs. 5.9, 5.11",
            agrees=best[0].lead_w > best[1].lead_w,
            found="The greatest mean leads of antenna 1 are "
            + " and ".join(f"{d.lead_text()}, {d.cell.design.label()}" for d in best)
            + ".",
            stricter_agrees=ahead,
            stricter=f"{'; '.join(f'{d.cell.design.label()}: {d.scores_text()}' for d in ranked)}; "
            f"the {'dipole' if ahead else 'monopole'} ranks first.",
        )


def _level_claims(sweep: _Sweep) -> Iterator[Claim]:
    design = sweep.get("dipole", FAR_M, LOW_M)
    if design is None:
        return
    rss_w, distance = design.drive.rss_w, design.drive.travel_m
    levels_dbm = power_dbm(np.maximum(rss_w.max(axis=1), 1e-30))
    below_db = float(levels_dbm.max()) - levels_dbm
    yield Claim(
        text="Right under the tag all antennas receive close to 0 µW.",
        where="page 70",
        agrees=bool(below_db[0] > NOTHING_DB),
        found=f"The strongest receives {1e6 * rss_w[0].max():.1g} µW there, the greatest of the "
        f"drive is {1e6 * rss_w.max():.3g} µW.",
    )
    near_db = float(below_db[distance <= UNDER_TAG_M + LENGTHS.same_m].min())
    yield Claim(
        text=f"Within about {_cm(UNDER_TAG_M)} of the point under the tag, too little is received.",
        where="page 73",
        agrees=near_db > LITTLE_DB,
        found=f"The strongest antenna stays {near_db:.0f} dB or more below its greatest RSS there.",
    )
    level = float(design.drive.start_rss_w[0])
    facing = float(np.interp(START_M, distance, rss_w[:, 0]))
    off = float(power_dbm(level) - power_dbm(LEVEL_W))
    yield Claim(
        text=f"At the start of the mission antenna 1 receives {1e6 * LEVEL_W:.3g} µW.",
        where="section 5.4.1, page 74, Fig. 5.12 (c)",
        agrees=abs(off) <= SAME_LEVEL_DB,
        found=f"It receives {1e6 * level:.3g} µW, {abs(off):.1f} dB "
        f"{'more' if off > 0.0 else 'less'}, the tag {START_M:.2f} m along the floor and 14° "
        f"beside it; {1e6 * facing:.3g} µW if it faced the tag.",
    )
    peak = int(rss_w[:, 0].argmax())
    yield Claim(
        text="The RSS has a maximum at some distance (the text gives no number).",
        where="Fig. 5.9",
        agrees=None,
        found=f"The RSS of antenna 1 is greatest, {1e6 * rss_w[peak, 0]:.3g} µW, "
        f"{distance[peak]:.2f} m from the point under the tag.",
    )


def _antenna_claim(kind: str, alone: LoneAntenna) -> Claim:
    resistance, reactance, gain_db, where = PUBLISHED_ANTENNAS[kind]
    return Claim(
        text=f"A {kind} alone has {resistance:g} + j{reactance:g} Ω and about {gain_db:g} dBi.",
        where=where,
        agrees=None,
        found=f"The {kind} of this study's wire and feed, which the thesis does not state, has "
        f"{alone.resistance_ohm:.1f} {'+' if alone.reactance_ohm >= 0 else '-'} "
        f"j{abs(alone.reactance_ohm):.1f} Ω and {alone.gain_db:.2f} dBi, "
        f"{alone.realised_gain_db:.2f} dBi from 50 Ω. {READINGS[kind]}",
    )
