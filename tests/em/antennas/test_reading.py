"""One half-wave dipole in six formats, and what each format alone can say."""

import re
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pattern_texts import DIPOLE_DBI, F_HZ, TEXTS, dipole_e, ffe_text, ffs_text, msi_text, nec_text

from octant.em.antennas.pattern_files.common import PatternTable, mean_over_sphere
from octant.em.antennas.pattern_files.reading import read_pattern
from octant.geometries.errors import PatternFileError, PhysicsWarning

SUFFIX = {"nec": "out"}


def quiet(path, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return read_pattern(path, **options)


@pytest.mark.parametrize("form", TEXTS)
def test_a_half_wave_dipole_has_2_15_dbi_in_theta_in_every_format(form, write):
    (table,) = quiet(write(f"dipole.{SUFFIX.get(form, form)}", TEXTS[form]()))
    assert 10 * np.log10(table.gain.max()) == pytest.approx(DIPOLE_DBI, abs=2e-3)
    row = np.argmin(np.abs(table.theta_rad - np.pi / 2))
    np.testing.assert_allclose(10 * np.log10(table.gain[row]), DIPOLE_DBI, atol=2e-3)
    assert np.abs(table.field[1]).max() < 1e-9
    assert table.gain[0].max() < 1e-6
    assert table.theta_rad[[0, -1]] == pytest.approx([0.0, np.pi])
    assert table.phi_rad[0] == 0.0
    assert table.phi_rad[-1] < 2 * np.pi - 1e-6
    if form != "csv":
        assert table.frequency_hz == pytest.approx(F_HZ, rel=1e-9)
    assert table.phase_known == (form != "msi")
    # radiates what it takes in
    share = mean_over_sphere(table.theta_rad, table.phi_rad, table.gain)
    assert share == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("form", ["ffe", "ffd", "ffs", "nec", "csv"])
def test_the_dipole_leads_by_a_quarter_turn_in_every_format_with_phase(form, write):
    (table,) = quiet(write(f"dipole.{SUFFIX.get(form, form)}", TEXTS[form]()))
    row = np.argmin(np.abs(table.theta_rad - np.pi / 2))
    assert np.angle(table.field[0, row, 3]) == pytest.approx(np.pi / 2, abs=1e-4)


@pytest.mark.parametrize("form", TEXTS)
def test_content_tells_the_format_where_the_suffix_does_not(form, write):
    (table,) = quiet(write("dipole.txt", TEXTS[form]()))
    (named,) = quiet(write("dipole.dat", TEXTS[form]()), format=form)
    np.testing.assert_array_equal(table.field, named.field)


@pytest.mark.parametrize(
    ("result", "kind"),
    [("Directivity", "directivity"), ("Gain", "gain"), ("Realised Gain", "realised_gain")],
)
def test_ffe_says_which_gain_it_holds(result, kind, write):
    (table,) = read_pattern(write("d.ffe", ffe_text(result=result)))
    assert table.kind == kind
    assert table.name == "FarField1"


def test_ffe_level_follows_the_gain_column_not_the_power_of_the_run(write):
    weak, strong = (read_pattern(write(f"{p}.ffe", ffe_text(power_w=p)))[0] for p in (1e-6, 40.0))
    np.testing.assert_allclose(weak.field, strong.field, atol=1e-6)


def test_ffe_without_gain_columns_needs_the_incident_power(write):
    text = "\n".join(
        re.sub(r'"Gain\(.*', "", line)
        if '"' in line
        else " ".join(line.split()[:6])
        if line.startswith("  ")
        else line
        for line in ffe_text(power_w=0.5).splitlines()
    )
    path = write("d.ffe", text)
    with pytest.raises(PatternFileError, match="incident_power_w"):
        read_pattern(path)
    (table,) = read_pattern(path, incident_power_w=0.5)
    assert 10 * np.log10(table.gain.max()) == pytest.approx(DIPOLE_DBI, abs=2e-3)
    assert table.kind == "realised_gain"


def test_ffe_whose_field_and_gain_disagree_is_refused_at_the_line(write):
    lines = ffe_text().splitlines()
    row = next(i for i, x in enumerate(lines) if x.split()[:1] == ["9.00000000E+01"])
    lines[row] = lines[row].replace(lines[row].split()[3], "1.9E-01")
    with pytest.raises(PatternFileError, match=rf"line {row + 1}: field and gain disagree"):
        read_pattern(write("d.ffe", "\n".join(lines)))


def test_ffe_with_gain_alone_is_loudly_without_phase(write):
    lines = [
        re.sub(r"^(\s+\S+\s+\S+)(\s+\S+){4}", r"\1 0 0 0 0", x) if x.startswith("  ") else x
        for x in ffe_text().splitlines()
    ]
    with pytest.warns(PhysicsWarning, match="holds no phase"):
        (table,) = read_pattern(write("d.ffe", "\n".join(lines)))
    assert not table.phase_known
    assert 10 * np.log10(table.gain.max()) == pytest.approx(DIPOLE_DBI, abs=2e-3)


def test_ffe_with_the_total_alone_is_taken_as_theta(write):
    lines = [
        " ".join([*x.split()[:2], *["0"] * 6, x.split()[8]]) if x.startswith("  ") else x
        for x in ffe_text().splitlines()
    ]
    with pytest.warns(PhysicsWarning, match="polarisation|no phase"):
        (table,) = read_pattern(write("d.ffe", "\n".join(lines)))
    assert 10 * np.log10(table.gain.max()) == pytest.approx(DIPOLE_DBI, abs=2e-3)
    assert np.abs(table.field[1]).max() == 0.0


def test_ffe_keeps_all_frequencies_and_the_origin(write):
    second = ffe_text().split("#Request Name", 1)[1].replace("2.40000000E+09", "2.48E+09")
    second = second.replace("#Result", "#Origin: (0.1, 0, 0.05)\n#Result", 1)
    tables = read_pattern(write("d.ffe", ffe_text() + "\n#Request Name" + second))
    assert [t.frequency_hz for t in tables] == [2.4e9, 2.48e9]
    np.testing.assert_array_equal(tables[1].origin_m, [0.1, 0.0, 0.05])
    np.testing.assert_array_equal(tables[0].field, tables[1].field)


def test_ffd_level_is_set_by_the_incident_power(write):
    path = write("d.ffd", TEXTS["ffd"](0.25))
    (table,) = read_pattern(path, incident_power_w=0.25)
    assert 10 * np.log10(table.gain.max()) == pytest.approx(DIPOLE_DBI, abs=2e-3)
    (low,) = read_pattern(path)
    assert low.gain.max() == pytest.approx(table.gain.max() / 4)


def test_ffd_without_frequency_lines_has_no_frequency(write):
    text = "\n".join(x for x in TEXTS["ffd"]().splitlines() if not x.startswith("Freq"))
    (table,) = read_pattern(write("d.ffd", text))
    assert table.frequency_hz is None


def test_ffd_runs_phi_fastest(write):
    text = "0 180 3\n0 270 4\n" + "\n".join(f"{i} 0 0 {i}" for i in range(12))
    (table,) = read_pattern(write("d.ffd", text))
    np.testing.assert_allclose(
        table.field[0].real / table.field[0, 1, 0].real * 4.0, np.arange(12.0).reshape(3, 4)
    )


@pytest.mark.parametrize(
    ("powers", "loss_db"),
    [
        ((0.5, 0.5, 0.5), 0.0),
        ((0.5, 0.6, 1.0), 10 * np.log10(2.0)),  # realised: against what was stimulated
        ((-1.0, -1.0, -1.0), 0.0),  # unknown: the field's own power
        ((1.0, -0.9, -0.5), 0.0),  # efficiencies against a radiated power of 1 W
    ],
)
def test_ffs_level_follows_the_stimulated_power(powers, loss_db, write):
    path = write("d.ffs", ffs_text(power_w=1.0 if powers[0] == 1.0 else 0.5, powers=powers))
    (table,) = read_pattern(path)
    expected = DIPOLE_DBI - (loss_db if powers[0] != 1.0 else 10 * np.log10(2.0))
    assert 10 * np.log10(table.gain.max()) == pytest.approx(expected, abs=2e-3)


def test_ffs_of_effective_values_is_warned_of(write):
    # rms instead of peak fields integrate to half the power that the header tells
    path = write("d.ffs", ffs_text(power_w=0.25, powers=(0.5, 0.5, 0.5)))
    with pytest.warns(PhysicsWarning, match=r"integrates to 0\.5 times"):
        read_pattern(path)


def test_ffs_phase_origin_is_the_position(write):
    text = ffs_text().replace("0.0e+00 0.0e+00 0.0e+00", "0.1 -0.2 0.3", 1)
    (table,) = read_pattern(write("d.ffs", text))
    np.testing.assert_array_equal(table.origin_m, [0.1, -0.2, 0.3])


def test_nec_range_is_taken_out_again(write):
    (plain,) = read_pattern(write("a.out", nec_text()))
    (ranged,) = read_pattern(write("b.out", nec_text(range_m=1000.0)))
    np.testing.assert_allclose(ranged.field, plain.field, atol=2e-4)


def test_nec_tells_the_impedance_and_its_gain_is_not_realised(write):
    (table,) = read_pattern(write("a.out", nec_text(zin=(240.0, -50.0))))
    assert table.impedance_ohm == 240.0 - 50.0j
    assert table.kind == "gain"


def test_nec_runs_at_one_frequency_keep_their_own_power_and_impedance(write):
    second = nec_text(power_w=0.5, zin=(10.0, 118.0)).split("METERS", 1)[1]
    one, two = read_pattern(write("a.out", nec_text() + second))
    assert (one.impedance_ohm, two.impedance_ohm) == (73.1 + 42.5j, 10.0 + 118.0j)
    assert one.frequency_hz == two.frequency_hz == F_HZ
    np.testing.assert_allclose(one.field, two.field, atol=1e-5)


@pytest.mark.parametrize(
    "echo",
    [
        "  DATA CARD No:   7 FR  0     1     0      0  2.4E+03 0.0E+00  0.0 0.0 0.0 0.0",
        "***** DATA CARD NO.  3  XQ   0     0     0     0  0.00000E+00",
        "AVERAGE POWER GAIN=  1.00023E+00   SOLID ANGLE USED IN AVERAGING=( 4.0000)*PI STERADIANS.",
        "",
    ],
)
def test_nec_table_ends_at_any_line_that_is_no_row_of_numbers(echo, write):
    (plain,) = read_pattern(write("a.out", nec_text()))
    text = nec_text().rstrip().removesuffix("RUN TIME =      0.010").rstrip() + f"\n{echo}\n"
    one, two = read_pattern(write("b.out", text + nec_text(power_w=0.5)))
    for table in (one, two):
        np.testing.assert_allclose(table.field, plain.field, rtol=1e-5, atol=1e-7)


def test_nec_rows_after_a_line_in_between_are_refused_at_that_line(write):
    lines = nec_text().splitlines()
    lines.insert(100, "x" + lines[100])
    with pytest.raises(PatternFileError, match=r"bad\.out, line 101: .* rows follow it"):
        read_pattern(write("bad.out", "\n".join(lines)))


def test_nec_without_power_budget_goes_by_the_gain_column(write):
    (table,) = read_pattern(write("a.out", nec_text(budget=False)))
    assert 10 * np.log10(table.gain.max()) == pytest.approx(DIPOLE_DBI, abs=5e-3)


def test_nec_power_of_another_run_is_refused(write):
    text = re.sub(r"(INPUT POWER   =)  \S+", r"\1  1.000000E-03", nec_text())
    with pytest.raises(PatternFileError, match="field and gain disagree"):
        read_pattern(write("a.out", text))


@pytest.mark.parametrize(("gain", "dbi"), [("10", 12.15), ("10 dBd", 12.15), ("10.0dBi", 10.0)])
def test_msi_gain_is_over_a_dipole_unless_it_says_otherwise(gain, dbi, write):
    (table,) = quiet(write("a.msi", msi_text(gain=gain)))
    assert 10 * np.log10(table.gain.max()) == pytest.approx(dbi, abs=2e-3)


def test_msi_is_loud_about_phase_and_cuts(write):
    with pytest.warns(PhysicsWarning) as caught:
        read_pattern(write("a.msi", msi_text()))
    text = " ".join(str(w.message) for w in caught)
    assert "holds no phase" in text
    assert "two cuts" in text


def test_msi_horizontal_runs_clockwise_and_vertical_downwards(write):
    lines = msi_text().splitlines()
    at = lines.index("HORIZONTAL 360")
    for a in range(360):
        lines[at + 1 + a] = f"{a} {0.0 if a == 30 else 10.0}"  # 30 degrees to the right
    at = lines.index("VERTICAL 360")
    for a in range(360):
        lines[at + 1 + a] = f"{a} {5.0 if a == 60 else 10.0}"  # 60 degrees down in front
    (table,) = quiet(write("a.pln", "\n".join(lines)))
    horizon = table.gain[90]
    assert np.degrees(table.phi_rad[np.argmax(horizon)]) == pytest.approx(330.0)
    front = table.gain[:, 0]
    assert np.degrees(table.theta_rad[np.argmax(front)]) == pytest.approx(150.0)


def sector(tilt_deg, *, behind_db=30.0):
    """A sector antenna's losses [dB], the horizontal cut through its tilted beam, 3GPP's form."""

    def loss(angle_deg, width_deg, most_db):
        off_deg = (angle_deg + 180.0) % 360.0 - 180.0
        return np.minimum(12.0 * (off_deg / width_deg) ** 2, most_db)

    angle = np.arange(360.0)
    return loss(angle, 65.0, behind_db), loss(angle - tilt_deg, 10.0, 30.0)


def sector_text(horizontal_db, vertical_db):
    lines = ["NAME sector", "FREQUENCY 2400", "GAIN 15 dBi", "POLARIZATION VERTICAL"]
    for name, cut in (("HORIZONTAL", horizontal_db), ("VERTICAL", vertical_db)):
        lines += [f"{name} 360", *(f"{a} {x:.4f}" for a, x in enumerate(cut))]
    return "\n".join(lines)


@pytest.mark.parametrize("behind_db", [30.0, 22.0])
@given(tilt_deg=st.integers(-20, 20).filter(bool))
def test_msi_vertical_cut_of_a_tilted_beam_comes_out(behind_db, tilt_deg, write):
    horizontal, vertical = sector(tilt_deg, behind_db=behind_db)
    with pytest.warns(PhysicsWarning) as caught:
        (table,) = read_pattern(write("a.msi", sector_text(horizontal, vertical)))
    said = "".join(str(w.message) for w in caught)
    assert f"disagree by {vertical[0]:.1f} dB in front and {30.0 - behind_db:.1f} dB behind" in said
    level = 10 * np.log10(table.gain)
    down = np.arange(-90, 91)  # depression in front; behind the cut goes on
    np.testing.assert_allclose(level[90 + down, 0], 15.0 - vertical[down], atol=1e-3)
    np.testing.assert_allclose(level[90 + down, 180], 15.0 - vertical[180 - down], atol=1e-3)


def test_msi_cuts_that_differ_behind_alone_keep_the_horizontal_one(write):
    horizontal, vertical = sector(0, behind_db=24.0)
    with pytest.warns(PhysicsWarning) as caught:
        (table,) = read_pattern(write("a.msi", sector_text(horizontal, vertical)))
    assert any("0.0 dB in front and 6.0 dB behind" in str(w.message) for w in caught)
    np.testing.assert_allclose(10 * np.log10(table.gain[90]), 15.0 - horizontal, atol=1e-3)


def test_msi_cuts_that_agree_both_come_out_and_say_nothing_of_it(write):
    horizontal, vertical = sector(0)
    with pytest.warns(PhysicsWarning) as caught:
        (table,) = read_pattern(write("a.msi", sector_text(horizontal, vertical)))
    assert not any("disagree" in str(w.message) for w in caught)
    level = 10 * np.log10(table.gain)
    np.testing.assert_allclose(level[90], 15.0 - horizontal, atol=1e-3)
    np.testing.assert_allclose(level[:, 0], 15.0 - vertical[np.arange(-90, 91)], atol=1e-3)


def test_msi_of_a_band_has_no_single_frequency_and_may_lack_the_name_keyword(write):
    text = msi_text().replace("FREQUENCY 2400", "FREQUENCY 2400-2500")
    (table,) = quiet(write("a.msi", text.replace("NAME half-wave dipole", "739686 panel")))
    assert table.frequency_hz is None
    assert table.name == "739686 panel"


def test_msi_polarisation_goes_to_its_component(write):
    (table,) = quiet(write("a.msi", msi_text(polarization="H")))
    assert np.abs(table.field[0]).max() == 0.0
    assert 10 * np.log10(table.gain.max()) == pytest.approx(2.15, abs=1e-6)


def test_a_csv_of_gains_is_loud_about_phase_and_polarisation(write):
    rows = [f"{t},{p},{-3.0}" for t in range(0, 181, 30) for p in range(0, 360, 30)]
    with pytest.warns(PhysicsWarning) as caught:
        (table,) = read_pattern(write("a.csv", "theta_deg,phi_deg,gain_db\n" + "\n".join(rows)))
    assert {"phase", "polarisation"} <= set(
        re.findall(r"phase|polarisation", str([str(w.message) for w in caught]))
    )
    np.testing.assert_allclose(table.field[0], 10 ** (-3 / 20))


def test_csv_cuts_of_a_body_of_revolution_come_out_exactly(write):
    elevation = np.arange(-180, 180, 5)
    level = -3.0 * np.sin(np.radians(elevation)) ** 2 - 1.0
    rows = ["cut,angle_deg,gain_db", *(f"horizontal,{a},-1.0" for a in range(0, 360, 5))]
    rows += [f"vertical,{a},{g:.9f}" for a, g in zip(elevation, level, strict=True)]
    (table,) = quiet(write("a.csv", "\n".join(rows)))
    expected = -3.0 * np.cos(table.theta_rad) ** 2 - 1.0
    at = np.arange(0, 181, 5)
    got = 10 * np.log10(table.gain)[at]
    np.testing.assert_allclose(got, np.broadcast_to(expected[at][:, None], got.shape), atol=1e-8)


def test_a_table_beyond_the_poles_is_the_same_table(write):
    # theta -180..180 with half of the azimuths, as many solvers sweep, against 0..180 with all
    def rows(thetas, phis):
        head = "theta_deg,phi_deg,f_theta_re,f_theta_im,f_phi_re,f_phi_im"
        return "\n".join(
            [
                head,
                *(  # the far field of a short dipole along x: theta_hat and phi_hat parts of -x
                    f"{t},{p},{-np.cos(np.radians(t)) * np.cos(np.radians(p)):.15f},0,"
                    f"{np.sin(np.radians(p)):.15f},0"
                    for p in phis
                    for t in thetas
                ),
            ]
        )

    (whole,) = read_pattern(write("a.csv", rows(range(0, 181, 15), range(0, 361, 30))))
    (swept,) = read_pattern(write("b.csv", rows(range(-180, 181, 15), range(0, 180, 30))))
    np.testing.assert_allclose(swept.phi_rad, whole.phi_rad, atol=1e-9)
    np.testing.assert_allclose(swept.field, whole.field, atol=1e-9)


def test_a_table_is_frozen_and_checks_its_shape():
    good = PatternTable(
        frequency_hz=1e9, theta_rad=[0, 1], phi_rad=[0, 1], field=np.ones((2, 2, 2)), kind="gain"
    )
    with pytest.raises(ValueError, match="read-only"):
        good.field[0, 0, 0] = 2.0
    for change in (
        {"field": np.ones((2, 3, 2))},
        {"theta_rad": [1, 0]},
        {"phi_rad": [0, 7]},
        {"kind": "loss"},
        {"frequency_hz": -1.0},
        {"field": np.full((2, 2, 2), np.nan)},
    ):
        values = {"frequency_hz": 1e9, "theta_rad": [0, 1], "phi_rad": [0, 1]}
        values |= {"field": np.ones((2, 2, 2)), "kind": "gain"} | change
        with pytest.raises(PatternFileError):
            PatternTable(**values)


def test_the_sphere_mean_of_a_dipole_is_one_on_coarse_grids():
    theta, phi = np.linspace(0, np.pi, 13), np.arange(8) * np.pi / 4
    e = np.abs(dipole_e(np.degrees(theta), 0.0)) ** 2 * 2 * np.pi / 376.730313668
    mean = mean_over_sphere(theta, phi, np.repeat(e[:, None], 8, axis=1))
    assert mean == pytest.approx(1.0, abs=1e-6)
