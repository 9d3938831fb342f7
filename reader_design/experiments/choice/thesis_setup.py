"""The set-up of thesis section 5.3, computed as the thesis describes it: its drive, its antennas.

A tag sends 1 W at 2.4 GHz from a vertical dipole 3 m above the reader's plane; the reader stands
under it and then ever farther away, antenna 1 towards it (Figs. 5.7, 5.9, 5.11, pages 69-72).
Nothing reflects. The thesis leaves gap, wire and feed open; those of the study's reader count.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.received_power import reader_link
from octant.em.reader.fullwave.single import dipole_mesh, monopole_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.scene import free_space_scene
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.design import reader_responses
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.samples import facing_poses, free_points_m, sample_rss_w
from octant.reader_design.setting.setting import DIRECT_ONLY
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Radio

FloatArray = npt.NDArray[np.float64]

FREQUENCY_HZ = 2.4e9
POWER_W = 1.0
TAG_ABOVE_M = 3.0
"""Height of the tag above the reader's plane [m]: (5, 0, 3) m over a reader on z = 0."""
FARTHEST_M = 5.0
"""Way from under the tag to the origin of that workspace [m]."""
STEP_M = 0.05
START_M = math.hypot(2.0, 0.5)
"""Distance along the floor from the start of the mission of 5.4 to its first tag [m]."""
START_RAD = math.atan2(0.5, 2.0)
"""Azimuth of that tag in the reader frame there, 14° [rad]: the robot heads 90°."""
SAME_CARRIER = 0.02
"""Relative difference of the carrier from 2.4 GHz up to which a study is one of the thesis' [-]."""
GROUND_PLANE_M = 0.20
DIPOLE_M, MONOPOLE_M, MONOPOLE_PLANE_M = 0.0625, 0.0312, 0.04


@dataclass(frozen=True, slots=True, kw_only=True)
class ThesisDrive:
    """What a reader receives in the thesis' set-up.

    Attributes
    ----------
    travel_m : (t,) float64 — Horizontal distances to the tag [m].
    rss_w : (t, n) float64 — RSS there, antenna 1 towards the tag [W].
    start_rss_w : (n,) float64 — RSS at the start of the mission of 5.4 [W].
    """

    travel_m: FloatArray
    rss_w: FloatArray
    start_rss_w: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class LoneAntenna:
    """One antenna by itself: its impedance and its gain along the horizon.

    Attributes
    ----------
    resistance_ohm, reactance_ohm : Input impedance [ohm].
    gain_db, realised_gain_db : Over isotropic; less what 50 ohm lose by mismatch [dB].
    """

    resistance_ohm: float
    reactance_ohm: float
    gain_db: float
    realised_gain_db: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ThesisSetup:
    """All that is computed in the thesis' set-up.

    Attributes
    ----------
    drives : By the key of the cell.
    antennas : ``dipole`` and ``monopole``, as far as drives have them.
    """

    drives: dict[str, ThesisDrive]
    antennas: dict[str, LoneAntenna]


def is_the_thesis(reader: Reader) -> bool:
    """Return whether a reader is one of those of thesis 5.3 but for r_a and h_p.

    Eight dipoles or monopoles on a square ground plane of 20 cm, plates of one height to the rim.

    Parameters
    ----------
    reader : A design [m].
    """
    plain = reader.plate_height_axis_m in {None, reader.plate_height_m}
    plain &= not reader.plate_profile_m
    plain &= reader.plate_outer_radius_m in {None, 0.5 * reader.ground_plane_m}
    return (
        plain
        and reader.antenna_kind in {"dipole", "monopole"}
        and reader.antennas == 8
        and reader.ground_plane_shape == "square"
        and math.isclose(reader.ground_plane_m, GROUND_PLANE_M)
    )


def thesis_setup(
    cells: Sequence[Cell], radio: Radio, folder: Path, progress: Progress
) -> ThesisSetup:
    """Return what the thesis' designs among scored cells receive in its set-up, read or computed.

    Parameters
    ----------
    cells, radio : Designs with scores or without; a carrier other than 2.4 GHz has none.
    folder, progress : Where it is kept; shows failures.
    """
    if abs(radio.frequency_hz / FREQUENCY_HZ - 1.0) > SAME_CARRIER:
        return ThesisSetup(drives={}, antennas={})
    mine = [cell for cell in cells if cell.free is not None and is_the_thesis(cell.design)]
    quiet = replace(progress, bars=False)
    found = map_cases(
        thesis_drive,
        [cell.design for cell in mine],
        context=None,
        folder=folder,
        codec=RecordCodec(ThesisDrive),
        progress=quiet,
        label="drives",
    )
    kinds = {cell.design.antenna: cell.design for cell in mine}
    alone = map_cases(
        lone_antenna,
        list(kinds.values()),
        context=None,
        folder=folder,
        codec=RecordCodec(LoneAntenna),
        progress=quiet,
        label="antennas",
    )
    pairs = zip(mine, found, strict=True)
    return ThesisSetup(
        drives={cell.key: kept.record for cell, kept in pairs if kept.record is not None},
        antennas={
            kind: kept.record
            for kind, kept in zip(kinds, alone, strict=True)
            if kept.record is not None
        },
    )


def thesis_drive(_context: None, reader: Reader) -> ThesisDrive:
    """Return a reader's RSS on the thesis' drive and at the start of its mission [W].

    Parameters
    ----------
    reader : The design; its height does not matter, the tag hangs 3 m above its plane.
    """
    link = reader_link(
        [radio_scene(free_space_scene(), FREQUENCY_HZ)],
        tag_position_m=np.array((0.0, 0.0, TAG_ABOVE_M)),
        tag_antenna=(make_antenna("dipole", FREQUENCY_HZ),),
        tag_power_w=POWER_W,
        response=reader_responses(reader, Radio(frequency_hz=FREQUENCY_HZ)),
        reader_height_m=0.0,
        solver=DIRECT_ONLY,
    )
    travel = np.linspace(0.0, FARTHEST_M, 1 + round(FARTHEST_M / STEP_M))
    under = (0.0, 0.0)
    start = facing_poses(free_points_m([START_M]), under, [START_RAD])
    return ThesisDrive(
        travel_m=travel,
        rss_w=sample_rss_w(link, free_points_m(travel), under, [0.0])[:, 0],
        start_rss_w=link.rss_w(start[0])[0],
    )


def lone_antenna(_context: None, reader: Reader) -> LoneAntenna:
    """Return impedance [ohm] and gain [dB] of a thesis antenna alone, by the full-wave solver.

    Parameters
    ----------
    reader : Its kind, and the wire and feed that the thesis leaves open, are the reader's [m].
    """
    if reader.antenna == "dipole":
        mesh = dipole_mesh(
            frequency_hz=FREQUENCY_HZ,
            length_m=DIPOLE_M,
            wire_radius_m=reader.wire_radius_m,
            feed_gap_m=reader.feed_gap_m,
        )
    else:
        mesh = monopole_mesh(
            frequency_hz=FREQUENCY_HZ,
            length_m=MONOPOLE_M,
            plane_m=MONOPOLE_PLANE_M,
            wire_radius_m=reader.wire_radius_m,
            feed_gap_m=reader.feed_gap_m,
        )
    solved = solve_reader(mesh)
    impedance = solved.input_impedance_ohm[0]
    realised = float((np.abs(solved.far_field(0.5 * math.pi, 0.0)[0]) ** 2).sum())
    return LoneAntenna(
        resistance_ohm=float(impedance.real),
        reactance_ohm=float(impedance.imag),
        gain_db=10.0 * math.log10(realised / float(solved.radiated_share[0])),
        realised_gain_db=10.0 * math.log10(realised),
    )
