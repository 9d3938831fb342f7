"""What missions have learnt, from file to file; bad files in one sentence."""

from dataclasses import fields

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.navigation.navigators.learned import Learned
from octant.reader_design.mapping.learned_file import learned_text, read_learned

LEARNED = Learned(
    tags=("0xFFF9", "b"),
    offset_m=np.array([[0.05, -0.04, 0.03], [0.0, 1e-17, -0.1]]),
    offset_sd_m=np.full((2, 3), 0.005),
    level_db=np.array([1.5, -0.25]),
    level_sd_db=np.array([0.3, 0.4]),
    gain_db=np.arange(8) / 7.0,
    gain_sd_db=np.full(8, 0.3),
    missions=2,
)


def test_what_is_written_is_read_back_to_the_bit(tmp_path):
    file = tmp_path / "learned.toml"
    file.write_text(learned_text(LEARNED), "utf-8")
    found = read_learned(file)
    for field in fields(Learned):
        assert np.array_equal(getattr(found, field.name), getattr(LEARNED, field.name)), field.name


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("missions = 2", "missions = 0", "missions"),
        ("missions = 2", "missions = 2\nmission = 1", "mission"),
        ("level_sd_db = 0.4", "level_sd_db = -0.4", "level_sd_db"),
        ("level_sd_db = 0.4", "", "level_sd_db"),
    ],
)
def test_a_damaged_file_is_named_with_what_is_wrong(tmp_path, old, new, match):
    file, text = tmp_path / "learned.toml", learned_text(LEARNED)
    assert old in text
    file.write_text(text.replace(old, new), "utf-8")
    with pytest.raises(ConfigError, match=rf"learned\.toml: .*{match}"):
        read_learned(file)
