"""What a reader's ports do, as tables of a page: impedances, S-matrix, where the power goes."""

import numpy as np

from octant.em.reader.fullwave.loads import LoadedReader
from octant.em.reader.matching import vswr
from octant.reader_design.showing.pages import ReportTable


def port_tables(ports: LoadedReader) -> tuple[ReportTable, ReportTable]:
    """Return the balance of power at each port, and the S-matrix ([ohm], [%], [dB]).

    Parameters
    ----------
    ports : The reader with its loads.
    """
    s_matrix = ports.s_matrix
    level = 20.0 * np.log10(np.maximum(np.abs(s_matrix), 1e-10))
    seen = ports.input_impedance_ohm
    loss_db = -10.0 * np.log10(np.maximum(ports.reflected_share, 1e-20))
    ratio = vswr(np.minimum(ports.reflected_share, (1.0 - 1e-9) ** 2))
    loads = "their loads behind reader.feed"
    if ports.feeds is None:
        loads = f"their loads of {ports.load_ohm[0].real:g} ohm"
    balance = ReportTable(
        caption=f"Each port at {ports.frequency_hz / 1e9:g} GHz, all others in {loads}: "
        "where the available power goes.",
        header=(
            "antenna",
            "impedance [ohm]",
            "return loss [dB]",
            "VSWR",
            "reflected [%]",
            "into other loads [%]" if ports.feeds is None else "into feed and other loads [%]",
            "radiated [%]",
        ),
        rows=tuple(
            (
                str(i + 1),
                _complex(seen[i]),
                f"{loss_db[i]:.1f}",
                f"{ratio[i]:.2f}",
                f"{100.0 * ports.reflected_share[i]:.1f}",
                f"{100.0 * ports.coupled_share[i]:.1f}",
                f"{100.0 * ports.radiated_share[i]:.1f}",
            )
            for i in range(ports.ports)
        ),
    )
    matrix = ReportTable(
        caption="S-matrix, magnitudes in dB: reflection on the diagonal, coupling beside it.",
        header=("received by", *(f"driven: {k + 1}" for k in range(ports.ports))),
        rows=tuple(
            (f"antenna {i + 1}", *(f"{value:.1f}" for value in row)) for i, row in enumerate(level)
        ),
    )
    return balance, matrix


def _complex(value: complex) -> str:
    sign = "+" if value.imag >= 0.0 else "−"
    return f"{value.real:.1f} {sign} j{abs(value.imag):.1f}"
