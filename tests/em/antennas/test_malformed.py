"""Whatever is wrong with a file: one sentence that names file and line, never another error."""

import re
import warnings

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pattern_texts import TEXTS, ffs_text

from octant.em.antennas.pattern_files.reading import read_pattern
from octant.em.antennas.pattern_files.touchstone import read_touchstone
from octant.geometries.errors import PatternFileError, PhysicsWarning

SUFFIX = {"nec": "out"}
WHOLE = {form: make() for form, make in TEXTS.items()}
S8P = "# GHz S RI R 50\n" + "\n".join(
    " ".join((["2.4"] if i == 0 else []) + [f"{i}.{j} 0.5" for j in range(8)][:4])
    + "\n"
    + " ".join(f"{i}.{j} 0.25" for j in range(4))
    for i in range(8)
)


def read(form, path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return read_touchstone(path) if form == "s8p" else read_pattern(path, format=form)


def edited(form, line, change):
    lines = WHOLE[form].splitlines()
    lines[line] = change(lines[line])
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("form", TEXTS)
def test_an_extra_column_is_refused_at_its_line(form, write):
    lines = WHOLE[form].splitlines()
    at = len(lines) - 8 if form == "nec" else len(lines) - 3
    comma = "," if form == "csv" else " "
    path = write("bad.txt", edited(form, at, lambda x: x + comma + "1.0"))
    with pytest.raises(PatternFileError, match=rf"bad\.txt, line {at + 1}: \d+ columns"):
        read(form, path)


@pytest.mark.parametrize("word", ["nan", "inf", "1e999", "abc", "1_0", "--1"])
@pytest.mark.parametrize("form", TEXTS)
def test_what_is_no_finite_number_is_refused_at_its_line(form, word, write):
    lines = WHOLE[form].splitlines()
    at = len(lines) - 8 if form == "nec" else len(lines) - 3
    comma = "," if form == "csv" else None

    def change(line):
        cells = line.split(comma)
        cells[1] = word
        return (comma or " ").join(cells)

    with pytest.raises(PatternFileError, match=rf"bad\.txt, line {at + 1}: .*not a finite number"):
        read(form, write("bad.txt", edited(form, at, change)))


@pytest.mark.parametrize("form", [*TEXTS, "s8p"])
@pytest.mark.parametrize(
    "content", ["", "\n \n", b"\x00\x01\x02\xff" * 50, b"\x89PNG\r\n\x1a\n\x00\x00", "hello\n"]
)
def test_empty_files_and_garbage_are_refused(form, content, write):
    with pytest.raises(PatternFileError, match=r"bad\.s8p, line \d+: "):
        read(form, write("bad.s8p", content))


@pytest.mark.parametrize("form", [None, *TEXTS])
def test_a_file_that_is_not_there_is_named(form, tmp_path):
    with pytest.raises(PatternFileError, match=r"none\.txt cannot be read"):
        read_pattern(tmp_path / "none.txt", format=form)


@pytest.mark.parametrize("form", ["ffe", "ffs", "nec", "csv"])
def test_two_rows_in_the_wrong_order_are_refused(form, write):
    lines = WHOLE[form].splitlines()
    at = 60
    lines[at], lines[at + 1] = lines[at + 1], lines[at]
    with pytest.raises(PatternFileError, match=r"line \d+: direction .* breaks the order"):
        read(form, write("bad.txt", "\n".join(lines)))


@pytest.mark.parametrize("form", ["ffe", "ffd", "ffs", "nec", "csv"])
def test_a_missing_row_is_refused(form, write):
    lines = WHOLE[form].splitlines()
    del lines[60]
    with pytest.raises(PatternFileError, match=r"bad\.txt, line \d+: "):
        read(form, write("bad.txt", "\n".join(lines)))


def test_a_missing_ring_is_refused_as_irregular(write):
    lines = [x for x in WHOLE["csv"].splitlines() if not x.startswith("45.0,")]
    with pytest.raises(PatternFileError, match="sorted and regular"):
        read("csv", write("bad.csv", "\n".join(lines)))


@pytest.mark.parametrize(
    ("form", "pattern"),
    [
        ("ffe", "#Frequency.*"),
        ("ffe", "#No. of Theta.*"),
        ("ffe", "#No. of Phi.*"),
        ("ffd", "0 360 37"),
        ("ffs", "// #Frequencies\n1"),
        ("ffs", "// Radiated.*"),
        ("ffs", "// >> Total.*"),
        ("ffs", "// >> Phi.*"),
        ("nec", ".*FREQUENCY : .*"),
        ("msi", "GAIN.*"),
        ("msi", "HORIZONTAL 360"),
        ("msi", "VERTICAL 360"),
        ("csv", "theta_deg.*"),
        ("s8p", "# GHz.*"),
    ],
)
def test_a_missing_header_line_is_refused(form, pattern, write):
    whole = S8P if form == "s8p" else WHOLE[form]
    text, count = re.subn(pattern, "", whole, count=1)
    assert count == 1
    with pytest.raises(PatternFileError, match=r"line \d+: "):
        read(form, write("bad.s8p", text))


@pytest.mark.parametrize(
    ("form", "old", "new", "says"),
    [
        ("ffe", "Spherical", "Cartesian", "only Spherical"),
        ("ffe", "Theta Samples: 37", "Theta Samples: 36", "announces 36"),
        ("ffe", "Samples: 37", "Samples: 1e99", "not a finite"),
        ("ffe", "#Result", "#U-Vector: (0, 1, 0)\n#Result", "turns the axes"),
        ("ffe", "Type: Gain", "Type: RCS", "not an antenna pattern"),
        ("ffd", "0 180 37", "0 180 99999999999", "not a number of samples"),
        ("ffd", "0 180 37", "180 0 37", "do not make an axis"),
        ("ffd", "Frequencies 1", "Frequencies 2", "announced"),
        ("ffd", "0 180 37", "0 180 36", r"a 'Frequency' line or the end of the file must follow"),
        ("ffs", "Farfield\n", "Multipoles\n", "only Farfield"),
        ("ffs", "1.0e+00 0.0e+00 0.0e+00", "0.0 1.0 0.0", "turned"),
        ("ffs", "37 37", "36 37", "announced"),
        ("ffs", "5.000000e-01", "0.0", "announced|above 0 W|needed|numbers"),
        ("nec", "POWER BUDGET", "PLANE WAVE EXCITATION", "plane wave"),
        ("msi", "VERTICAL 360", "VERTICAL 361", "ends 1 angles before"),
        ("msi", "5.0 0.0", "5.0 -3.0", "attenuation"),
        ("msi", "7.0 0.0", "3.0 0.0", "ascend once around"),
        ("csv", "f_phi_im", "f_phi_imag", "unknown"),
        ("csv", ",realised_gain", ",loss", "kind"),
        ("csv", "0.0,0.0,", '0.0,"0.0,', "is not CSV"),
    ],
)
def test_a_wrong_entry_is_refused_in_words(form, old, new, says, write):
    assert old in WHOLE[form]
    count = -1 if form == "ffs" and old.startswith("5.0") else 1
    path = write("bad.txt", WHOLE[form].replace(old, new, count))
    with pytest.raises(PatternFileError, match=rf"bad\.txt, line \d+: .*({says})"):
        read(form, path)


def test_a_direction_given_twice_differently_is_refused(write):
    lines = WHOLE["csv"].splitlines()
    at = next(i for i, x in enumerate(lines) if x.startswith("90.0,360.0"))
    lines[at] = "90.0,360.0,5,0,0,0,realised_gain"
    with pytest.raises(PatternFileError, match="given twice with different values"):
        read("csv", write("bad.csv", "\n".join(lines)))


def test_the_message_is_one_sentence_and_names_the_file(write):
    with pytest.raises(PatternFileError) as caught:
        read("ffs", write("bad.ffs", ffs_text()[:2000]))
    text = str(caught.value)
    assert "\n" not in text
    assert text.endswith(".")
    assert re.search(r"bad\.ffs, line \d+: ", text)


def test_an_unknown_format_name_lists_the_known_ones(write):
    with pytest.raises(PatternFileError, match="ffe, ffd, ffs, cst, nec, msi, ngmn, csv"):
        read_pattern(write("a.ffe", WHOLE["ffe"]), format="grd")


# a cut after this share of the text leaves at least one whole direction out
COUNTED = ("ffe", "ffd", "ffs", "msi", "s8p")


@pytest.mark.parametrize("form", COUNTED)
@given(share=st.floats(0.0, 0.99))
def test_a_truncated_file_with_counts_is_always_refused(form, share, write):
    text = S8P if form == "s8p" else WHOLE[form]
    with pytest.raises(PatternFileError):
        read(form, write("cut.s8p", text[: int(share * len(text))]))


@pytest.mark.parametrize("form", [*TEXTS, "s8p"])
@given(
    at=st.floats(0.0, 1.0),
    drop=st.integers(0, 300),
    junk=st.text(alphabet="0123456789.eE+-, \n\t#/!*\"'abN\x00é", max_size=20),
)
def test_a_damaged_file_is_read_or_refused_but_nothing_else(form, at, drop, junk, write):
    text = S8P if form == "s8p" else WHOLE[form]
    begin = int(at * len(text))
    try:
        read(form, write("damaged.s8p", text[:begin] + junk + text[begin + drop :]))
    except PatternFileError as error:
        named = re.search(r"damaged\.s8p, line \d+: ", str(error))
    else:
        named = True
    assert named


@given(content=st.binary(max_size=400), form=st.sampled_from([None, *TEXTS, "s8p"]))
def test_any_bytes_are_refused_by_name(content, form, write):
    with pytest.raises(PatternFileError, match=r"bytes\.s8p"):
        read(form, write("bytes.s8p", content))
