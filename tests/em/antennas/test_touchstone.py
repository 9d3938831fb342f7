"""Touchstone: the layout of the specification, and back, and what scikit-rf reads."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.em.antennas.pattern_files.touchstone import read_touchstone, write_touchstone
from octant.geometries.errors import PatternFileError, PhysicsWarning


def matrices(n, count=3, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, n, n, 2)) @ np.array([0.3, 0.3j])


@given(n=st.integers(1, 9), form=st.sampled_from(["RI", "MA", "DB"]), seed=st.integers(0, 99))
def test_s_matrices_come_back(n, form, seed, tmp_path):
    path = tmp_path / f"a.s{n}p"
    f, s = np.array([2.402e9, 2.44e9, 2.48e9]), matrices(n, seed=seed)
    write_touchstone(path, f, s, reference_ohm=75.0, form=form)
    back = read_touchstone(path)
    np.testing.assert_array_equal(back.frequencies_hz, f)
    assert back.reference_ohm == 75.0
    if form == "RI":
        np.testing.assert_array_equal(back.s_matrices, s)
    np.testing.assert_allclose(back.s_matrices, s, rtol=1e-13)


def test_eight_ports_take_two_lines_a_row_of_four_pairs(tmp_path):
    s = np.arange(64).reshape(1, 8, 8) + 0.5j
    write_touchstone(tmp_path / "a.s8p", [2.4e9], s)
    lines = (tmp_path / "a.s8p").read_text().splitlines()
    assert lines[1] == "# Hz S RI R 50.0"
    body = [[float(x) for x in line.split()] for line in lines[2:]]
    assert [len(line) for line in body] == [9, *[8] * 15]
    assert body[0] == [2.4e9, 0, 0.5, 1, 0.5, 2, 0.5, 3, 0.5]
    assert body[3] == [12, 0.5, 13, 0.5, 14, 0.5, 15, 0.5]  # S(2, 5..8)


def test_a_two_port_runs_down_its_columns(write, tmp_path):
    path = write("a.s2p", "! amplifier\n# MHz S MA R 50\n100 .11 0 .21 0 .12 0 .22 180 ! end\n")
    got = read_touchstone(path)
    np.testing.assert_allclose(got.s_matrices, [[[0.11, 0.12], [0.21, -0.22]]], atol=1e-15)
    assert got.frequencies_hz[0] == 1e8
    write_touchstone(tmp_path / "b.s2p", got.frequencies_hz, got.s_matrices)
    row = (tmp_path / "b.s2p").read_text().splitlines()[2].split()
    assert [float(x) for x in row[1::2]] == pytest.approx([0.11, 0.21, 0.12, -0.22])


def test_a_three_port_runs_along_its_rows_and_defaults_are_ghz_ma_50(write):
    path = write("a.s3p", "#\n1 11 0 12 0 13 0\n21 0 22 0 23 0\n31 0 32 0 33 0\n")
    got = read_touchstone(path)
    np.testing.assert_array_equal(
        got.s_matrices[0].real, np.array([[11, 12, 13], [21, 22, 23], [31, 32, 33]])
    )
    assert (got.frequencies_hz[0], got.reference_ohm) == (1e9, 50.0)


def test_decibels_are_twenty_times_the_logarithm(write):
    got = read_touchstone(write("a.s1p", "# GHZ S DB R 50\n1 -20 90\n"))
    np.testing.assert_allclose(got.s_matrices[0, 0, 0], 0.1j, atol=1e-15)


def test_noise_of_a_two_port_is_left_out(write):
    text = "# GHz S RI R 50\n1 1 0 2 0 3 0 4 0\n2 1 0 2 0 3 0 4 0\n1 1.2 .3 40 .5\n2 1.3 .3 40 .5\n"
    assert len(read_touchstone(write("a.s2p", text)).frequencies_hz) == 2


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.s1p", "1 0 0\n", "line 1: the option line"),
        ("a.s1p", "# GHz Z RI R 50\n1 0 0\n", "line 1: option 'Z'"),
        ("a.s1p", "# GHz S RI R\n1 0 0\n", "line 1: '' is not a finite number"),
        ("a.s1p", "# GHz S RI R 0\n1 0 0\n", "line 1: reference 0 ohm"),
        (
            "a.s1p",
            "# GHz S RI R 50\n[Number of Ports] 1\n1 0 0\n",
            "line 2: a keyword of version 2",
        ),
        ("a.s1p", "# GHz S RI R 50\n", "line 1: no frequency"),
        ("a.s1p", "# GHz S RI R 50\n1 0 0\n1 0 0\n", "line 3: frequency 1 does not ascend"),
        ("a.s1p", "# GHz S RI R 50\n-1 0 0\n", "line 2: frequency -1 is below 0"),
        ("a.s1p", "# GHz S RI R 50\n1 0 0 0\n", "line 2: 4 numbers where .* has 3"),
        ("a.s2p", "# GHz S RI R 50\n1 0 0 0\n", "line 2: the file ends after 4 of 9"),
        ("a.s1p", "# GHz S RI R 50\n1 nan 0\n", "line 2: 'nan'"),
        ("a.s1p", "# GHz S DB R 50\n1 5000 0\n", "line 2: an S-parameter beyond"),
    ],
)
def test_malformed_files_are_refused_at_the_line(name, text, says, write):
    with pytest.raises(PatternFileError, match=says):
        read_touchstone(write(name, text))


def test_the_suffix_must_tell_the_ports(write, tmp_path):
    for name in ("a.txt", "a.s0p", "a.sp"):
        with pytest.raises(PatternFileError, match=r"\.sNp"):
            read_touchstone(write(name, "# Hz S RI R 50\n1 0 0\n"))
    with pytest.raises(PatternFileError, match=r"\.s2p"):
        write_touchstone(tmp_path / "a.s4p", [1e9], matrices(2, 1))


@pytest.mark.parametrize(
    ("f", "s", "more"),
    [
        ([1e9], np.zeros((2, 2, 2)), {}),
        ([1e9], np.zeros((1, 2, 3)), {}),
        ([2e9, 1e9], np.zeros((2, 2, 2)), {}),
        ([1e9], np.full((1, 2, 2), np.nan), {}),
        ([1e9], np.zeros((1, 2, 2)), {"reference_ohm": 0.0}),
        ([1e9], np.zeros((1, 2, 2)), {"form": "XY"}),
        ([], np.zeros((0, 2, 2)), {}),
    ],
)
def test_what_is_no_s_matrix_is_not_written(f, s, more, tmp_path):
    with pytest.raises(PatternFileError):
        write_touchstone(tmp_path / "a.s2p", f, s, **more)
    assert list(tmp_path.iterdir()) == []


HFSS = """! Touchstone file exported from HFSS 2019.2.0
!Data is not renormalized
# GHZ S MA R 50.000000
"""


def hfss_text(impedances, *, a_line=4):
    """HFSS's comments after each frequency, wrapped as it does from five ports on."""
    n = len(impedances[0])
    text = HFSS
    for k, row in enumerate(impedances):
        lines = [" ".join(["0.1 180"] * n) for _ in range(n)]
        lines = [" ".join(lines)] if n <= 2 else lines
        text += f"{k + 1}.0 " + "\n".join(lines) + "\n! Gamma " + "0 10 " * n + "\n"
        pairs = [f"{z.real:<17g}{z.imag:<17g}" for z in row]
        parts = ["".join(pairs[i : i + a_line]) for i in range(0, n, a_line)]
        text += "! Port Impedance" + "\n!               ".join(parts) + "\n"
    return text


@pytest.mark.parametrize(
    "impedances",
    [
        [[30.0 + 0j, 75.0 + 0j]],
        [[30.0 + 1j, 75.0 + 0j], [31.0 - 2j, 76.0 + 0j]],
        [[50.0 + 5j * k for k in range(6)]] * 3,
    ],
)
def test_port_impedances_of_hfss_are_read_from_its_comments(impedances, write):
    ports = len(impedances[0])
    read = read_touchstone(write(f"a.s{ports}p", hfss_text(impedances)))
    np.testing.assert_array_equal(read.reference_ohm, impedances)


def test_equal_real_port_impedances_are_one_reference(write):
    read = read_touchstone(write("a.s2p", hfss_text([[75.0 + 0j, 75.0 + 0j]])))
    assert read.reference_ohm == 75.0


@pytest.mark.parametrize(
    "text",
    [
        HFSS + "1.0 0.1 180\n",
        HFSS + "1.0 0.1 180\n! Port Impedance30\n",
        hfss_text([[30.0 + 0j], [40.0 + 0j]]) + "3.0 0.1 180\n",
    ],
)
def test_port_impedances_that_are_not_told_are_warned_of(text, write):
    with pytest.warns(PhysicsWarning, match="reference is in doubt"):
        read = read_touchstone(write("a.s1p", text))
    assert read.reference_ohm == 50.0


def version_2(s, form="RI", shape="Full", order="12_21", reference=None, width=3):
    """A file of version 2 by the specification, its lines cut anywhere."""
    count, n = s.shape[:2]
    lines = ["! by hand", "[Version] 2.0", "# GHz S " + form, f"[Number of Ports] {n}"]
    if n == 2:
        lines.append(f"[Two-Port Data Order] {order}")
    lines.append(f"[Number of Frequencies] {count}")
    if reference:
        lines += ["[Reference]", *(f"{value:g}" for value in reference)]
    if shape != "Full":
        lines.append(f"[Matrix Format] {shape}")
    lines += ["[Begin Information]", "anything [at all", "[End Information]", "[Network Data]"]
    for k in range(count):
        words = [f"{2.0 + 0.1 * k!r}"]
        for i in range(n):
            for j in range(n):
                if (shape == "Lower" and j > i) or (shape == "Upper" and j < i):
                    continue
                value = s[k, j, i] if n == 2 and order == "21_12" else s[k, i, j]
                pair = (value.real, value.imag)
                if form != "RI":
                    size = abs(value) if form == "MA" else 20 * np.log10(abs(value))
                    pair = (size, np.degrees(np.angle(value)))
                words += [repr(float(x)) for x in pair]
        lines += [" ".join(words[i : i + width]) for i in range(0, len(words), width)]
    return "\n".join([*lines, "[End]"]) + "\n"


@pytest.mark.parametrize("form", ["RI", "MA", "DB"])
@pytest.mark.parametrize("ports", [1, 2, 5])
@pytest.mark.parametrize("shape", ["Full", "Lower", "Upper"])
def test_version_2_reads_as_it_is_specified(ports, shape, form, write):
    s = matrices(ports)
    if shape != "Full":
        s = s + s.transpose(0, 2, 1)
    for order in ("12_21", "21_12"):
        back = read_touchstone(write("a.ts", version_2(s, form, shape, order)))
        np.testing.assert_allclose(back.s_matrices, s, rtol=1e-12)
        np.testing.assert_allclose(back.frequencies_hz, [2.0e9, 2.1e9, 2.2e9])
        assert back.reference_ohm == 50.0


def test_version_2_has_a_reference_for_each_port(write):
    text = version_2(matrices(3), reference=(50.0, 75.0, 10.0))
    back = read_touchstone(write("a.s3p", text))
    np.testing.assert_array_equal(back.reference_ohm, np.tile([50.0, 75.0, 10.0], (3, 1)))


def test_scikit_rf_reads_the_same_from_both_versions(write, tmp_path):
    network = pytest.importorskip("skrf").Network
    s = matrices(4)
    # scikit-rf takes the free text between its keywords for numbers
    text = re.sub(r"(?s)\[Begin.*End Information\]\n", "", version_2(s, "MA"))
    first = write("a.s4p", text)
    np.testing.assert_allclose(network(str(first)).s, read_touchstone(first).s_matrices, rtol=1e-12)
    write_touchstone(tmp_path / "b.s4p", [2.0e9, 2.1e9, 2.2e9], s, reference_ohm=75.0)
    second = network(str(tmp_path / "b.s4p"))
    np.testing.assert_array_equal(second.s, s)
    np.testing.assert_array_equal(second.f, [2.0e9, 2.1e9, 2.2e9])
    assert (second.z0 == 75.0).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[Version] 2.0", "[Version] 3.0"), "line 2: Touchstone version 3.0"),
        (("[Number of Ports] 2\n", ""), r"\[Number of Ports\] is missing"),
        (("[Two-Port Data Order] 12_21\n", ""), r"\[Two-Port Data Order\] is missing"),
        (("[Number of Frequencies] 3", "[Number of Frequencies] 4"), "3 frequencies where 4"),
        (("# GHz S RI", "# GHz Z RI"), "option 'Z' is not read"),
        (("[Network Data]", "[Mixed-Mode Order] D2,3\n[Network Data]"), "mixed modes"),
        (("[Network Data]", "[Reference] 50\n[Network Data]"), "line 9: .* stands|lacks"),
        (("[Network Data]", "[Reference] 50 -1\n[Network Data]"), "above 0"),
        (("[Network Data]\n", "[Anything]\n"), r"keyword \[anything\] is unknown"),
        (("[End]", "1 2 3\n[End]"), "ends after 3 of 9"),
    ],
)
def test_version_2_with_something_wrong_is_refused(change, said, write):
    with pytest.raises(PatternFileError, match=said):
        read_touchstone(write("bad.s2p", version_2(matrices(2)).replace(*change)))


def test_version_2_that_is_cut_off_is_refused(write):
    text = version_2(matrices(2))
    for share in (0.2, 0.5, 0.9):
        with pytest.raises(PatternFileError):
            read_touchstone(write("bad.s2p", text[: int(share * len(text))]))
