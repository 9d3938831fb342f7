"""A measured reader beside the computed one: ports from Touchstone, patterns from files."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.from_files import reader_from_pattern_files
from octant.em.decibels import decibels
from octant.em.reader.comparison import ResponseDifference, compare_responses
from octant.em.reader.fullwave.loads import LoadedReader
from octant.em.reader.fullwave.port_files import network_of_file
from octant.geometries.errors import ConfigError
from octant.reader_design.face.reader import ELEVATIONS_DEG, SolvedReader
from octant.reader_design.face.reader_figures import gain_dbi
from octant.reader_design.showing.pages import ReportTable
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PORTS = re.compile(r"\.(s\d+p|ts)", re.IGNORECASE)
SHOWN_DEG = 15.0
"""Elevation at which the figure shows gains [deg]."""
_STYLES = (("measured", "computed"), ("-", "--"))
LEAST_DBI = -30.0
"""Gain below which the figure shows none [dBi]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredReader:
    """What was measured of a reader, and what was computed of it.

    Parameters
    ----------
    computed, response : Computed ports at the antennas with real loads, None where the model has
        none; computed patterns.
    measured : Ports by the measured network; None where no Touchstone file was given.
    patterns : Measured patterns; None where no pattern files were given.
    """

    computed: LoadedReader | None
    response: ReaderResponse
    measured: LoadedReader | None
    patterns: ReaderResponse | None

    @property
    def difference(self) -> ResponseDifference | None:
        """How far the computed patterns are from the measured ones; None without these."""
        if self.patterns is None:
            return None
        theta = np.radians(90.0 - np.asarray(ELEVATIONS_DEG, dtype=np.float64))
        return compare_responses(self.patterns, self.response, theta.tolist())

    def lines(self) -> Iterator[str]:
        """Yield what the comparison says, in sentences."""
        if self.computed is not None and self.measured is not None:
            found, given = self.computed.s_matrix, self.measured.s_matrix
            off = np.abs(found - given)
            own = float(np.diagonal(off).max())
            coupled = float((off - np.diag(np.diagonal(off))).max())
            z, z_given = self.computed.input_impedance_ohm, self.measured.input_impedance_ohm
            worst = int(np.argmax(np.abs(z - z_given) / np.abs(z_given)))
            share = abs(z[worst] - z_given[worst]) / abs(z_given[worst])
            yield (
                f"Measured ports beside computed ones: reflections differ by up to {own:.3f}, "
                f"coupling by up to {coupled:.3f}, impedances by up to {100.0 * share:.3g} % "
                f"(antenna {worst + 1}: {_ohm(z_given[worst])} measured, {_ohm(z[worst])} "
                "computed)."
            )
        difference = self.difference
        if difference is not None:
            yield (
                "Measured patterns beside computed ones, above the ground plane: computed gains "
                f"{difference.offset_db:+.1f} dB in the mean of strong directions, "
                f"{difference.strong_rms_db:.1f} dB rms about it, {difference.weak_rms_db:.1f} dB "
                "rms 10 to 20 dB below the maximum; another strongest antenna at "
                f"{100.0 * difference.other_antenna_share:.0f} % of azimuths."
            )

    def tables(self) -> tuple[ReportTable, ...]:
        """Return the comparison port by port ([ohm], [dB], [dBi])."""
        rows = []
        for i in range(self.response.antennas):
            row = [str(i + 1)]
            if self.computed is not None and self.measured is not None:
                sides = (self.measured, self.computed)
                row += [_ohm(side.input_impedance_ohm[i]) for side in sides]
                row += [f"{float(decibels(side.reflected_share[i])):.1f}" for side in sides]
            if self.patterns is not None:
                row += [f"{_peak_dbi(one, i):.1f}" for one in (self.patterns, self.response)]
            rows.append(tuple(row))
        header = ["antenna"]
        if self.measured is not None:
            header += ["measured [ohm]", "computed [ohm]", "measured S11 [dB]", "computed S11 [dB]"]
        if self.patterns is not None:
            header += ["measured gain [dBi]", "computed gain [dBi]"]
        return (
            ReportTable(
                caption="What was measured beside what was computed: impedance and reflection of "
                "each port, greatest realised gain.",
                header=tuple(header),
                rows=tuple(rows),
            ),
        )

    def figure(self) -> "Figure | None":
        """Return the gains over the azimuth, measured and computed; None without patterns."""
        if self.patterns is None:
            return None
        phi = np.linspace(0.0, 2.0 * math.pi, 361)
        theta = math.radians(90.0 - SHOWN_DEG)
        both = [gain_dbi(one.far_field(theta, phi)) for one in (self.patterns, self.response)]
        count = len(both[0])
        columns = min(count, 4)
        rows = math.ceil(count / columns)
        with figure_style():
            figure, axes = new_figure(
                rows=rows,
                columns=columns,
                width_in=2.4 * columns + 1.2,
                height_in=1.9 * rows + 0.6,
                title=f"Gain at {SHOWN_DEG:g}° of elevation, measured and computed",
            )
            for i, ax in enumerate(axes.ravel()):
                if i >= count:
                    ax.set_axis_off()
                    continue
                for gain, name, dashes in zip(both, *_STYLES, strict=True):
                    level = np.maximum(gain[i], LEAST_DBI)
                    ax.plot(np.degrees(phi), level, dashes, label=name)
                ax.set_title(f"antenna {i + 1}", fontsize=9)
                ax.set_xlim(0.0, 360.0)
                ax.set_xticks((0, 90, 180, 270, 360))
                if i % columns == 0:
                    ax.set_ylabel("gain [dBi]")
                if i >= count - columns:
                    ax.set_xlabel("azimuth [°]")
            figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside right center")
        return figure


def measured_reader(solved: SolvedReader, files: Sequence[Path]) -> MeasuredReader:
    """Return what files say of a reader beside what was computed, at its first frequency.

    Parameters
    ----------
    solved : The computed reader.
    files : One Touchstone file with a port for each antenna, at the antennas; or pattern files, one
        for each antenna in their order, in the reader's frame; or both.
    """
    ports = [file for file in files if _PORTS.fullmatch(file.suffix)]
    patterns = [file for file in files if file not in ports]
    design, response = solved.design, solved.responses[0]
    if len(ports) > 1:
        msg = f"--measured names {len(ports)} Touchstone files, but ports are in one; give one."
        raise ConfigError(msg)
    if patterns and len(patterns) != response.antennas:
        msg = (
            f"--measured names {len(patterns)} pattern files, but the reader has "
            f"{response.antennas} antennas; give one for each, in their order."
        )
        raise ConfigError(msg)
    if ports and not solved.results:
        msg = (
            f"--measured names {ports[0]}, but the model {response.model!r} has no ports; give "
            "pattern files, or --model fullwave."
        )
        raise ConfigError(msg)
    computed = measured = None
    if solved.results:
        result = solved.results[0]
        loads = np.full(result.ports, design.load_ohm, dtype=np.complex128)
        computed = LoadedReader(unloaded=result.unloaded, load_ohm=loads)
        if ports:
            network = network_of_file(ports[0], result.frequency_hz, ports=result.ports)
            measured = replace(computed, unloaded=replace(result.unloaded, admittance_s=network))
    return MeasuredReader(
        computed=computed,
        response=response,
        measured=measured,
        patterns=_patterns(patterns, solved) if patterns else None,
    )


def _patterns(files: Sequence[Path], solved: SolvedReader) -> ReaderResponse:
    response = solved.responses[0]
    return reader_from_pattern_files(
        files,
        azimuths_rad=response.azimuths_rad,
        frequency_hz=response.frequency_hz,
        phase_centres_m=response.phase_centres_m,
        load_ohm=solved.design.load_ohm,
    )


def _ohm(value: complex) -> str:
    return f"{value.real:.1f}{value.imag:+.1f}j ohm"


def _peak_dbi(response: ReaderResponse, antenna: int) -> float:
    gain: npt.NDArray[np.float64] = (np.abs(response.pattern[antenna]) ** 2).sum(axis=0)
    return float(decibels(gain.max()))
