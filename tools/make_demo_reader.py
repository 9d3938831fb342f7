"""Write the pattern of the demonstration's reader, solved by full wave, for the package.

The reader of the built-in office on a round ground plane, so that all eight antennas are alike and
one file does: antenna 1 along +x, all others terminated, at 2.45 GHz, every 5 degrees.

    python tools/make_demo_reader.py [FILE.csv]
"""

import sys
from pathlib import Path

import numpy as np

from octant.em.antennas.from_files import pattern_tables
from octant.reader_design.setting.design import response_at
from octant.reader_design.study_file.reader import Reader

FREQUENCY_HZ = 2.45e9
STEP_DEG = 5.0
DIGITS = 5
HEADER = "kind,theta_deg,phi_deg,f_theta_re,f_theta_im,f_phi_re,f_phi_im"
TARGET = Path(__file__).parents[1] / "reader_design" / "study_file" / "demo_reader.csv"


def main() -> None:
    """Write the file named on the command line, or that of the package."""
    response = response_at(Reader(ground_plane_shape="round"), FREQUENCY_HZ)
    table = pattern_tables(response, step_deg=STEP_DEG)[0]
    lines = [HEADER]
    for i, theta in enumerate(np.degrees(table.theta_rad)):
        for j, phi in enumerate(np.degrees(table.phi_rad)):
            f_t, f_p = table.field[:, i, j]
            parts = (f_t.real, f_t.imag, f_p.real, f_p.imag)
            values = ",".join(f"{x:.{DIGITS}f}" for x in parts)
            lines.append(f"{table.kind},{theta:g},{phi:g},{values}")
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else TARGET
    target.write_text("\n".join(lines) + "\n", "utf-8")


if __name__ == "__main__":
    main()
