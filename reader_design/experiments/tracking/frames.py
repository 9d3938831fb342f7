"""RSS that the tags measure, in codes and one tag after another, thesis 4.6.2: ``frames``."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from octant.navigation.sensing.tag_frames import ID_BITS, Polling, RssCodes
from octant.navigation.tracking import shapes
from octant.reader_design.experiments.tracking.chapters import (
    EKF,
    driven,
    neighbouring_setup,
    thesis_filter,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FloatArray,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    Row,
    middle_and_90,
    rows_of,
)
from octant.reader_design.experiments.tracking.settings import LEMNISCATE_START, Settings
from octant.reader_design.experiments.tracking.task_figure import COLOURS
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EXACT, XBEE, WIDE = "not rounded", "whole dB, as the XBee", "codes over all readings"
SIGMAS = 4.0
"""How many deviations of the noise `WIDE` codes reach beyond the readings free of noise [-]."""
COLUMNS = (
    "codes",
    "bits",
    "step_db",
    "floor_dbm",
    "full_scale_dbm",
    "bit_rate_hz",
    "frame_bits",
    "round_s",
    "average_m_median",
    "average_m_90",
)
"""Columns of frames.csv [dB], [dBm], [Hz], [s], [m]; without a rate every tag answers in every
period."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each kind of code, and for each bit rate.

    Parameters
    ----------
    settings : The study.
    """
    rates = settings.track.frame_bit_rates_hz
    return [
        *(Part(chapter="frames", task=codes) for codes in (EXACT, XBEE, WIDE)),
        *(Part(chapter="frames", task=WIDE, sigma=rate) for rate in rates),
    ]


def codes_of(settings: Settings, kind: str) -> RssCodes | None:
    """Return the codes of a part, with the study's number of bits, else 8; None: exact [dBm].

    Parameters
    ----------
    settings, kind : The study, and `EXACT`, `XBEE` or `WIDE`.
    """
    track = settings.track
    bits = track.tag_bits or RssCodes().bits
    if kind == EXACT:
        return None
    if kind == XBEE:
        return RssCodes(
            bits=bits, floor_dbm=track.tag_floor_dbm, full_scale_dbm=track.tag_full_scale_dbm
        )
    clean = settings.mesh.rss_dbm(shapes.lemniscate().motion(np.linspace(0.0, 60.0, 241))[0])
    noise = settings.noise
    return RssCodes(
        bits=bits,
        floor_dbm=float(clean.min()) + noise.mean_db - SIGMAS * noise.sigma_db,
        full_scale_dbm=float(clean.max()) + noise.mean_db + SIGMAS * noise.sigma_db,
    )


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return the lemniscate driven with the codes and the bit rate of a part.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    track, codes = settings.track, codes_of(settings, part.task)
    rate_hz = part.sigma or None
    changes: dict[str, float | None] = {"tag_bits": None, "tag_bit_rate_hz": rate_hz}
    if codes is not None:
        changes |= {
            "tag_bits": codes.bits,
            "tag_floor_dbm": codes.floor_dbm,
            "tag_full_scale_dbm": codes.full_scale_dbm,
        }
    changed = replace(settings, track=msgspec.structs.replace(track, **changes))
    bits = track.tag_bits or RssCodes().bits
    round_s = None
    if rate_hz is not None:
        round_s = Polling(
            tags=len(settings.mesh.tags_m),
            bit_rate_hz=rate_hz,
            turnaround_s=track.tag_turnaround_s,
            code_bits=bits,
        ).round_s
    setup = neighbouring_setup(changed, shapes.lemniscate(), LEMNISCATE_START)
    outcome = driven(
        changed,
        setup,
        EKF,
        setup.control,
        thesis_filter(changed),
        chapter="frames",
        task=part.task if rate_hz is None else f"{part.task}, {rate_hz:g} bit/s",
    )
    levels = (None, None, None, None)
    if codes is not None:
        levels = (codes.bits, codes.step_db, codes.floor_dbm, codes.full_scale_dbm)  # type: ignore[assignment]
    row = (
        part.task,
        *levels,
        rate_hz,
        ID_BITS + bits,
        round_s,
        *middle_and_90(outcome.measures()["average_m"]),
    )
    return PartRecord(outcomes=(outcome,), rows=(row,))


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del records
    codes, wide = codes_of(settings, XBEE), codes_of(settings, WIDE)
    if codes is None or wide is None:
        return ()
    return (
        (
            "The tags of thesis 4.6.2 measure the RSS of the reader's question and answer with "
            f"{ID_BITS} bits of identity and {codes.bits} of RSS. Codes from "
            f"{codes.floor_dbm:g} to {codes.full_scale_dbm:g} dBm do not hold the readings of "
            f"this study, which lie between {wide.floor_dbm:.0f} and {wide.full_scale_dbm:.0f} "
            "dBm: what is cut there pulls the filter away where the law and the noise are the "
            "exaggerated ones of 6.5.1. "
            f"Codes over all readings, {wide.step_db:.2g} dB wide, cost nothing. A slow channel "
            "costs accuracy once a round of all tags lasts several periods."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    caption = f"The lemniscate among {len(settings.mesh.tags_m)} tags, by code and bit rate."
    return (
        ChapterTable(file="frames.csv", caption=caption, header=COLUMNS, rows=rows_of(records)),
    )


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield the error by code and by the time of a round [m], [s].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    rows = rows_of(records)
    still = [row for row in rows if row[5] is None]
    slow = [row for row in rows if row[5] is not None]
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=10.4, height_in=3.8, title="RSS measured by the tags", columns=2
        )
        _bars(axes[0], still)
        numbers = np.array([[row[7], row[8], row[9]] for row in slow], float).reshape(-1, 3)
        axes[1].semilogx(numbers[:, 0], numbers[:, 1], "o-", color=COLOURS[0], label="median")
        axes[1].semilogx(numbers[:, 0], numbers[:, 2], "_", color=COLOURS[0], label="90 %")
        axes[1].axvline(settings.track.period_s, color="#999999", label="period of the control")
        axes[1].set_xlabel("round of all tags [s]")
        axes[1].set_ylabel("average error [m]")
        axes[1].set_title("by the time of a round")
        axes[1].legend()
    yield NamedFigure(
        file="frames.png",
        section="frames",
        title="Codes and rounds (thesis 4.6.2)",
        caption="Left, the average error by the code of the tags; right, by how long a round of "
        "all tags takes.",
        figure=figure,
    )


def _bars(ax: "Axes", rows: Sequence[Row]) -> None:
    names = [str(row[0]) for row in rows]
    numbers: FloatArray = np.array([row[8:10] for row in rows], float)
    ax.barh(names, numbers[:, 0], color=COLOURS[: len(names)], alpha=0.75)
    ax.plot(numbers[:, 1], names, "|", color="#222222", markersize=14)
    ax.invert_yaxis()
    ax.set_xlabel("average error [m]")
    ax.set_title("by code: median (bar), 90 % (line)")


CHAPTER = FurtherChapter(
    heading="RSS measured by the tags (4.6.2)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
