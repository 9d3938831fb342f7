"""Files of many makers' dialects: read to 0.01 dB of what they say, or refused in a sentence.

All of them are written here, after the formats' published descriptions, from one vector field.
"""

import json
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pattern_texts import ETA, F_HZ, C

from octant.em.antennas.from_files import antenna_from_pattern_file
from octant.em.antennas.pattern_files.reading import read_pattern
from octant.geometries.errors import PatternFileError, PhysicsWarning

GAIN_DBI = 7.5
V = np.array([0.2, 0.3, 1.0])


def field(theta_deg, phi_deg):
    """F_theta and F_phi of a smooth vector field on the sphere, strongest near +x."""
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    along_theta = V[0] * ct * cp + V[1] * ct * sp - V[2] * st
    along_phi = -V[0] * sp + V[1] * cp
    x = st * cp
    shape = (0.55 + 0.45 * x) ** 2 * np.exp(1.3j * x + 0.4j * ct)
    return shape * along_theta, shape * along_phi


_GRID = np.meshgrid(np.arange(0.0, 181.0, 5.0), np.arange(0.0, 360.0, 5.0), indexing="ij")
_SCALE = np.sqrt(10 ** (GAIN_DBI / 10) / sum(np.abs(f) ** 2 for f in field(*_GRID)).max())


def scaled(theta_deg, phi_deg):
    """The same with its greatest gain on the grid of 5 degrees at GAIN_DBI."""
    return tuple(f * _SCALE for f in field(theta_deg, phi_deg))


def db(power):
    return 10 * np.log10(np.maximum(power, 1e-30))


def total_db(theta_deg, phi_deg):
    return db(sum(np.abs(f) ** 2 for f in scaled(theta_deg, phi_deg)))


def read(path, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return read_pattern(path, **options)


def check_total(table):
    theta, phi = np.meshgrid(np.degrees(table.theta_rad), np.degrees(table.phi_rad), indexing="ij")
    assert table.theta_rad[[0, -1]] == pytest.approx([0.0, np.pi])
    wanted = total_db(theta, phi)
    strong = wanted > GAIN_DBI - 40.0
    assert np.abs(db(table.gain) - wanted)[strong].max() < 0.01


def check_field(table):
    check_total(table)
    theta, phi = np.meshgrid(np.degrees(table.theta_rad), np.degrees(table.phi_rad), indexing="ij")
    assert np.abs(table.field - np.stack(scaled(theta, phi))).max() < 2e-3


# --- NGMN BASTA ------------------------------------------------------------------------------

SYSTEMS = {
    "SPCS_Polar": (lambda t, p: (t, p), (0.0, 5.0, 180.0), (0.0, 5.0, 355.0)),
    "SPCS_Ericsson": (lambda t, p: (t, p), (0.0, 5.0, 180.0), (-180.0, 5.0, 175.0)),
    "SPCS_CCW": (lambda t, p: (t + 90.0, p), (-90.0, 5.0, 90.0), (0.0, 5.0, 355.0)),
    "SPCS_CW": (lambda t, p: (t + 90.0, -p), (-90.0, 5.0, 90.0), (0.0, 5.0, 355.0)),
    "SPCS_Geo": (lambda t, p: (180.0 - t, -p), (0.0, 5.0, 180.0), (0.0, 5.0, 355.0)),
}
ROW = ["MagAttenuationTP", "MagAttenuationCo", "MagAttenuationCr", "PhaseCo", "PhaseCr"]


def ngmn(system="SPCS_Polar", columns=ROW[:1], by_row=False, turn_deg=0.0, **changes):
    to_polar, theta, phi = SYSTEMS[system]
    axes = [a + s * np.arange(round((b - a) / s) + 1) for a, s, b in (theta, phi)]
    t, p = (x.ravel() for x in np.meshgrid(*axes, indexing="ij"))
    f_theta, f_phi = scaled(*to_polar(t, p))
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    co, cross = c * f_theta + s * f_phi, c * f_phi - s * f_theta
    values = {
        "Theta": t,
        "Phi": p,
        ROW[0]: GAIN_DBI - db(np.abs(f_theta) ** 2 + np.abs(f_phi) ** 2),
        ROW[1]: GAIN_DBI - db(np.abs(co) ** 2),
        ROW[2]: GAIN_DBI - db(np.abs(cross) ** 2),
        ROW[3]: np.degrees(np.angle(co)),
        ROW[4]: np.degrees(np.angle(cross)),
    }
    names = ["Theta", "Phi", *columns] if by_row else list(columns)
    rows = np.round(np.column_stack([values[name] for name in names]), 5)
    if by_row:
        rows = np.random.default_rng(1).permutation(rows)
    content = {
        "BASTA_AA_WP_version": "3.0",
        "Antenna_Model": "by hand",
        "Coordinate_System": system,
        "Frequency": {"value": 2.4, "unit": "GHz"},
        "Gain": {"value": GAIN_DBI, "unit": "dBi"},
        "Nominal_Polarization": "V",
        "Data_Set_Row_Structure": names,
        "Data_Set": rows.tolist(),
    }
    if not by_row:
        content |= {"Theta_Sampling": list(theta), "Phi_Sampling": list(phi)}
    return {k: v for k, v in (content | changes).items() if v is not None}


@pytest.mark.parametrize("system", SYSTEMS)
def test_ngmn_on_a_regular_grid_in_every_system_of_coordinates(system, write):
    (table,) = read(write("a.json", json.dumps(ngmn(system))))
    check_total(table)
    assert (table.frequency_hz, table.kind, table.phase_known) == (2.4e9, "gain", False)


@pytest.mark.parametrize("turn_deg", [0.0, 45.0, -45.0, 90.0])
def test_ngmn_with_phases_of_both_polarisations_gives_the_field(turn_deg, write):
    named = {0.0: "V", 45.0: "+45", -45.0: "-45", 90.0: "H"}[turn_deg]
    content = ngmn(columns=ROW, turn_deg=turn_deg, Nominal_Polarization=named)
    (table,) = read(write("a.json", json.dumps(content)))
    check_field(table)
    assert table.phase_known


def test_ngmn_row_by_row_in_any_order_and_in_dbd(write):
    content = ngmn(columns=ROW[1:3], by_row=True, Gain={"value": GAIN_DBI - 2.15, "unit": "dBd"})
    (table,) = read(write("a.txt", json.dumps(content)))
    check_total(table)
    assert np.abs(table.field[0, 18, 0]) == pytest.approx(abs(scaled(90.0, 0.0)[0]), rel=1e-3)


def test_ngmn_files_of_several_patterns(write):
    second = ngmn(Frequency={"value": 2450, "unit": "MHz"})
    tables = read(write("a.json", json.dumps([ngmn(), second])))
    assert [table.frequency_hz for table in tables] == [2.4e9, 2.45e9]
    check_total(tables[1])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"Coordinate_System": "SPCS_Other"}, "SPCS_OTHER"),
        ({"Theta_Sampling": [0.0, 5.0, 175.0]}, "rows are missing"),
        ({"Theta_Sampling": None}, "Theta_Sampling is None"),
        ({"Phi_Sampling": [0.0, -5.0, 355.0]}, "makes no axis"),
        ({"Gain": 7.5}, "Gain is 7.5"),
        ({"Gain": {"value": 7.5, "unit": "W"}}, "dBi or dBd"),
        ({"Data_Set": [[1.0]]}, "correct the one that is wrong"),
        ({"Data_Set": [["a"]] * 2664}, "no table of numbers"),
        ({"Data_Set": None}, "no Data_Set"),
        ({"Data_Set_Row_Structure": ["Mag"]}, "MagAttenuationTP"),
        ({"Frequency": {"value": -1, "unit": "GHz"}}, "no frequency"),
    ],
)
def test_ngmn_files_with_something_wrong_are_refused(changes, said, write):
    with pytest.raises(PatternFileError, match=said):
        read(write("bad.json", json.dumps(ngmn(**changes))))


def test_ngmn_files_that_are_cut_off_are_refused(write):
    text = json.dumps(ngmn())
    for share in (0.1, 0.5, 0.999):
        with pytest.raises(PatternFileError, match="no JSON"):
            read(write("bad.json", text[: int(share * len(text))]))
    rows = ngmn(by_row=True)
    del rows["Data_Set"][100]
    with pytest.raises(PatternFileError, match="is missing"):
        read(write("bad.json", json.dumps(rows)))
    rows["Data_Set"].append(rows["Data_Set"][0])
    with pytest.raises(PatternFileError, match="given twice"):
        read(write("bad.json", json.dumps(rows)))


# --- CST text --------------------------------------------------------------------------------


def cst(
    what="Dir.", unit="dBi   ", theta=(0.0, 180.0), phi=(0.0, 355.0), step=5.0, parts="Theta Phi"
):
    first, second = parts.split()
    head = (
        f"Theta [deg.]  Phi   [deg.]  Abs({what:4})[{unit}]   Abs({first})[{unit}]  "
        f"Phase({first})[deg.]  Abs({second:5})[{unit}]  Phase({second:5})[deg.]  "
        "Ax.Ratio[dB    ]    "
    )
    lines = [head, "-" * 100]
    for p in np.arange(phi[0], phi[1] + 1.0, step):
        for t in np.arange(theta[0], theta[1] + 1.0, step):
            f = scaled(t, p)
            power = [abs(f[0]) ** 2 + abs(f[1]) ** 2, abs(f[0]) ** 2, abs(f[1]) ** 2]
            a, b, c = (float(db(x)) for x in power) if unit.strip() else power
            angle = [np.degrees(np.angle(x)) % 360.0 for x in f]
            lines.append(
                f"{t:8.3f} {p:8.3f}  {a:14.6e} {b:14.6e} {angle[0]:10.3f} {c:14.6e} "
                f"{angle[1]:10.3f} {40.0:12.3e}"
            )
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("what", "unit", "kind"),
    [
        ("Dir.", "dBi   ", "directivity"),
        ("Gain", "dBi", "gain"),
        ("Grlz", "dB", "realised_gain"),
        ("RlzdGain", "      ", "realised_gain"),
        ("Gain(IEEE)", "", "gain"),
    ],
)
def test_cst_text_in_every_unit(what, unit, kind, write):
    (table,) = read(write("farfield (f=2.4) [1].txt", cst(what, unit)))
    check_field(table)
    assert (table.kind, table.phase_known, table.frequency_hz) == (kind, True, None)


@pytest.mark.parametrize(
    ("theta", "phi"), [((-180.0, 180.0), (0.0, 175.0)), ((-180.0, 175.0), (-90.0, 90.0))]
)
def test_cst_text_over_a_doubled_sphere(theta, phi, write):
    (table,) = read(write("a.txt", cst(theta=theta, phi=phi)))
    check_field(table)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"what": "E", "unit": "V/m"}, "far-field source"),
        ({"parts": "Left Right"}, "not Ludwig or circular"),
        ({"unit": "dBW"}, "dBi or linear"),
    ],
)
def test_cst_text_that_does_not_tell_the_gain_is_refused(changes, said, write):
    with pytest.raises(PatternFileError, match=said):
        read(write("bad.txt", cst(**changes)))


def test_cst_text_whose_parts_do_not_add_up_or_that_is_cut_off_is_refused(write):
    lines = cst().splitlines()
    cells = lines[700].split()
    cells[2] = "9.0"
    broken = "\n".join([*lines[:700], " ".join(cells), *lines[701:]])
    with pytest.raises(PatternFileError, match=r"line 701: .*dB off the total"):
        read(write("bad.txt", broken))
    with pytest.raises(PatternFileError, match="columns"):
        read(write("bad.txt", "\n".join(lines[:700]) + "\n 1.0 2.0"))
    with pytest.raises(PatternFileError, match="ends after"):
        read(write("bad.txt", "\n".join(lines[:700])))


# --- HFSS .ffd -------------------------------------------------------------------------------


def ffd(theta, phi, step=5.0, flip=1.0):
    axes = [np.arange(a, b + 1.0, step) for a, b in (theta, phi)]
    lines = [f"{a[0]:g} {a[-1]:g} {len(a)}" for a in axes] + ["Frequencies 1", f"Frequency {F_HZ}"]
    for t in axes[0]:
        for p in axes[1]:
            f = np.array(scaled(t, p)) * np.sqrt(ETA / (2 * np.pi)) * (flip if t < 0.0 else 1.0)
            lines.append(" ".join(f"{x:.9e}" for x in (f[0].real, f[0].imag, f[1].real, f[1].imag)))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("theta", "phi"),
    [
        ((-180.0, 180.0), (0.0, 175.0)),
        ((-180.0, 180.0), (0.0, 180.0)),
        ((-180.0, 180.0), (0.0, 360.0)),
        ((0.0, 180.0), (-180.0, 180.0)),
        ((-90.0, 90.0), (0.0, 360.0)),
    ],
)
def test_ffd_over_a_doubled_sphere(theta, phi, write):
    (table,) = read(write("a.ffd", ffd(theta, phi)))
    if theta[1] < 180.0:  # half a sphere, each direction twice
        assert table.theta_rad[-1] == pytest.approx(np.pi / 2)
        return
    check_field(table)
    assert table.kind == "realised_gain"


def test_ffd_whose_two_halves_contradict_each_other_is_refused(write):
    with pytest.raises(PatternFileError, match="twice with different values"):
        read(write("bad.ffd", ffd((-180.0, 180.0), (0.0, 360.0), flip=-1.0)))


# --- NEC -------------------------------------------------------------------------------------

POWER_W = 0.01


def nec(*sections, f_mhz=2400.0, title="RADIATION PATTERNS"):
    """A 4nec2 listing of one run, with sections of theta and phi axes."""
    lines = [
        "                    - - - - - - FREQUENCY - - - - - -",
        f"                     FREQUENCY= {f_mhz:.4E} MHZ",
        f"                     WAVELENGTH= {C / f_mhz / 1e6:.4E} METERS",
        "",
        "                        - - - ANTENNA INPUT PARAMETERS - - -",
        "",
        "  TAG   SEG.    VOLTAGE (VOLTS)         CURRENT (AMPS)         IMPEDANCE (OHMS)",
        "  NO.   NO.    REAL        IMAG.       REAL        IMAG.       REAL        IMAG.",
        " 1 5 1.0E+00 0.0E+00 1.0E-02-5.0E-03 7.31E+01 4.25E+01 1.0E-02-5.0E-03 6.8E-03",
        "",
        "                               - - - POWER BUDGET - - -",
        f"                               INPUT POWER   = {POWER_W:.6E} WATTS",
        f"                               RADIATED POWER= {POWER_W:.6E} WATTS",
        "",
    ]
    for theta, phi in sections:
        lines += [
            f"                              - - - {title} - - -",
            "",
            "  - - ANGLES - -           - POWER GAINS -       - - - POLARIZATION - - -",
            "  THETA     PHI        VERT.   HOR.    TOTAL      AXIAL     TILT   SENSE  MAGNITUDE",
            " DEGREES  DEGREES       DB      DB      DB        RATIO     DEG.           VOLTS/M",
        ]
        for p in phi:
            for t in theta:
                f = scaled(t, p)
                e = [x * np.sqrt(ETA * POWER_W / (2 * np.pi)) for x in f]
                parts = [max(float(db(abs(x) ** 2)), -999.99) for x in f]
                total = max(float(total_db(t, p)), -999.99)
                lines.append(
                    f" {t:7.2f} {p:8.2f} {parts[0]:8.2f} {parts[1]:8.2f} {total:8.2f} 0.1 0.0 "
                    f"RIGHT {abs(e[0]):.6E} {np.degrees(np.angle(e[0])):.4f} {abs(e[1]):.6E} "
                    f"{np.degrees(np.angle(e[1])):.4f}"
                )
        lines += ["", ""]
    return "\n".join(lines)


FULL, AROUND = np.arange(0.0, 181.0, 5.0), np.arange(0.0, 361.0, 10.0)


def test_nec_sections_that_are_two_halves_of_a_sphere_become_one(write):
    text = nec((np.arange(0.0, 91.0, 5.0), AROUND), (np.arange(90.0, 181.0, 5.0), AROUND))
    (table,) = read(write("a.out", text))
    check_field(table)
    text = nec((np.arange(95.0, 181.0, 5.0), AROUND), (np.arange(0.0, 91.0, 5.0), AROUND))
    (table,) = read(write("a.out", text))
    check_field(table)
    assert table.impedance_ohm == pytest.approx(73.1 + 42.5j)


def test_nec_sections_that_repeat_or_only_cut_leave_the_sphere(write):
    (table,) = read(write("a.out", nec((FULL, AROUND), (FULL, AROUND))))
    check_field(table)
    path = write("a.out", nec((FULL, AROUND), (FULL, [0.0, 90.0])))
    assert len(read(path)) == 2
    with pytest.warns(PhysicsWarning, match="of 2 patterns the one over the full sphere"):
        antenna = antenna_from_pattern_file(path, frequency_hz=2.4e9)
    assert antenna.kind == "pattern"


def test_nec_sections_with_a_gap_between_them_stay_two_and_are_refused_as_an_antenna(write):
    text = nec((np.arange(0.0, 71.0, 5.0), AROUND), (np.arange(100.0, 181.0, 5.0), AROUND))
    path = write("a.out", text)
    assert len(read(path)) == 2
    with pytest.raises(PatternFileError, match="a second pattern at"):
        antenna_from_pattern_file(path, frequency_hz=2.4e9)


def test_nec_runs_at_two_frequencies_are_two_tables(write):
    text = nec((FULL, AROUND)) + "\n" + nec((FULL, AROUND), f_mhz=2450.0)
    tables = read(write("a.out", text))
    assert [table.frequency_hz for table in tables] == pytest.approx([2.4e9, 2.45e9])
    check_field(tables[1])


# --- MSI / Planet ----------------------------------------------------------------------------


def cuts(step, tilt_deg, on_horizon=False):
    """Losses [dB] of a sector antenna, clockwise and downwards, and its beam tilted downwards.

    They agree behind, and in front where the horizontal one runs along the horizon.
    """
    angle = np.arange(0.0, 360.0, step)
    around = (angle + 180.0) % 360.0 - 180.0
    down = (angle - tilt_deg + 180.0) % 360.0 - 180.0
    in_front = 12.0 * (tilt_deg / 9.0) ** 2 if on_horizon else 0.0
    horizontal = in_front + np.minimum(12.0 * (around / 65.0) ** 2, 25.0)
    most = 25.0 + in_front + 2.0 * (1.0 + np.cos(np.radians(angle)))
    return angle, horizontal, np.minimum(12.0 * (down / 9.0) ** 2, most)


def msi(
    gain="GAIN 15.5 dBi", step=1.0, tilt_deg=0.0, row="{:.2f} {:.4f}", sign=1.0, head=(), **options
):
    angle, horizontal, vertical = cuts(step, tilt_deg, options.get("on_horizon", False))
    count = "" if options.get("no_count") else f" {len(angle)}"
    colon = options.get("colon", "")
    lines = [
        f"NAME{colon} X-65-{tilt_deg:g}", f"MAKE{colon} by hand", f"FREQUENCY{colon} 2400",
        gain, f"POLARIZATION{colon} VERTICAL", *head,
    ]  # fmt: skip
    for name, loss in (("HORIZONTAL", horizontal), ("VERTICAL", vertical)):
        lines.append(name + count)
        lines += [row.format(a, sign * x) for a, x in zip(angle, loss, strict=True)]
    return "\n".join(lines) + "\n"


def check_msi(table, gain_dbi, step=1.0, tilt_deg=0.0, on_horizon=True):
    """The vertical cut comes out, in front and behind, and the greatest gain is the file's own."""
    angle, horizontal, vertical = cuts(step, tilt_deg, on_horizon)
    level = db(table.gain)
    assert level.max() == pytest.approx(gain_dbi, abs=0.01)
    theta = np.degrees(table.theta_rad)
    for column, elevation in ((0, theta - 90.0), (len(table.phi_rad) // 2, 270.0 - theta)):
        wanted = np.interp(elevation, angle, gain_dbi - vertical, period=360.0)
        assert np.abs(level[:, column] - wanted).max() < 0.01
    if on_horizon:
        row = int(np.argmin(np.abs(theta - 90.0)))
        along = np.interp(-np.degrees(table.phi_rad), angle, horizontal, period=360.0)
        assert np.abs(level[row] - gain_dbi + along).max() < 0.01


@pytest.mark.parametrize(
    ("options", "gain_dbi"),
    [
        ({}, 15.5),
        ({"gain": "GAIN 15.5dBi"}, 15.5),
        ({"gain": "GAIN  15.5 (dBi)"}, 15.5),
        ({"gain": "GAIN: 15.5 dBi", "colon": ":"}, 15.5),
        ({"gain": "GAIN 15,5 dBi"}, 15.5),
        ({"gain": "GAIN dBi 15.5"}, 15.5),
        ({"gain": "GAIN 13.35 dBd"}, 15.5),
        ({"gain": "GAIN 13.35"}, 15.5),
        ({"gain": "GAIN 13.35 DBD"}, 15.5),
        ({"row": "{:.1f}\t{:.4f}"}, 15.5),
        ({"row": "  {:.1f} ,  {:.4f}  "}, 15.5),
        ({"row": "{:.1f} {:.4f} ! measured"}, 15.5),
        ({"head": ("# a comment", "; another", "// and one more", "! 1.0 2.0")}, 15.5),
        ({"no_count": True}, 15.5),
        ({"sign": -1.0}, 15.5),
        ({"head": ("TILT MECHANICAL", "H_WIDTH 65.0", "COMMENT 12.5 m mast")}, 15.5),
    ],
)
def test_msi_dialects_are_read_to_the_files_own_gain(options, gain_dbi, write):
    (table,) = read(write("a.msi", msi(**options)))
    check_msi(table, gain_dbi)


@pytest.mark.parametrize("step", [0.5, 0.25, 0.2, 2.0, 5.0])
def test_msi_cuts_of_other_steps_keep_all_their_levels(step, write):
    (table,) = read(write("a.pln", msi(step=step)))
    check_msi(table, 15.5, step=step)


@pytest.mark.parametrize("tilt_deg", [2.0, 6.0, 10.0])
def test_msi_cuts_of_a_tilted_beam_keep_the_vertical_cut(tilt_deg, write):
    text = msi(tilt_deg=tilt_deg, head=("TILT ELECTRICAL", f"ELECTRICAL_TILT {tilt_deg:g}"))
    (table,) = read(write("a.msi", text))
    assert any("disagree by" in text for text in table.warnings)
    assert not [text for text in table.warnings if "upwards" in text]
    check_msi(table, 15.5, tilt_deg=tilt_deg, on_horizon=False)


def test_msi_cuts_along_the_horizon_of_a_tilted_beam_agree_in_front(write):
    (table,) = read(write("a.msi", msi(tilt_deg=4.0, on_horizon=True)))
    check_msi(table, 15.5, tilt_deg=4.0)


def test_msi_files_whose_tilt_and_vertical_cut_contradict_are_warned_of(write):
    (table,) = read(write("a.msi", msi(tilt_deg=-6.0, head=("ELECTRICAL_TILT 6",))))
    assert "6 deg above the horizon: is it given upwards" in " ".join(table.warnings)


def test_msi_files_whose_cuts_never_reach_their_gain_are_warned_of(write):
    lines = [
        f"{a} {float(b) + 0.3:.4f}" if a[0].isdigit() else f"{a} {b}"
        for a, b in (line.split(" ", 1) for line in msi().splitlines())
    ]
    (table,) = read(write("a.msi", "\n".join(lines)))
    assert "the cuts stay 0.30 dB below GAIN" in " ".join(table.warnings)
    assert db(table.gain).max() == pytest.approx(15.2, abs=0.01)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (msi(gain="GAIN 15.5 dB"), "not a finite number"),
        (msi(gain="GAIN high"), "not a finite number"),
        (msi(gain="GAIN 150 dBi"), "not a gain"),
        (msi(row="{:.1f} {:.4f}").replace(".", ","), "."),
        (msi(gain="MAKE 2"), "GAIN line is missing"),
        ("\n".join(msi().splitlines()[:600]), "ends"),
        (msi().replace("VERTICAL 360", "HORIZONTAL 360"), "given twice"),
    ],
)
def test_msi_files_with_something_wrong_are_refused(text, said, write):
    with pytest.raises(PatternFileError, match=said):
        read(write("bad.msi", text))


# --- damaged in any way ----------------------------------------------------------------------

WHOLE = {
    "cst": cst(step=30.0, phi=(0.0, 330.0)),
    "ngmn": json.dumps(ngmn(by_row=True, columns=ROW)),
    "msi": msi(step=5.0),
}


@given(
    form=st.sampled_from(list(WHOLE)),
    place=st.floats(0.0, 1.0),
    length=st.integers(0, 40),
    put=st.text('0123456789.-+eE ,[]{}":\n!#()abdINdBT', max_size=12),
)
def test_damaged_files_are_read_or_refused_and_nothing_else(form, place, length, put, write):
    text = WHOLE[form]
    at = int(place * len(text))
    path = write("bad.txt", text[:at] + put + text[at + length :])
    try:
        named, tables = True, read(path, format=form)
    except PatternFileError as error:
        named, tables = "bad.txt" in str(error), ()
    assert named
    for table in tables:
        assert np.isfinite(table.field).all()
