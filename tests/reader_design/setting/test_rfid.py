"""Tags that the reader wakes: what regions let it send, how far that reaches, who competes."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.power.backscatter import BackscatterLink
from octant.geometries.errors import ConfigError, PhysicsWarning
from octant.navigation.sensing.inventory import round_s
from octant.reader_design.setting.inventory import study_inventory
from octant.reader_design.setting.read_range import read_range
from octant.reader_design.setting.rfid import (
    isotropic_responses,
    peak_gain,
    sent_by,
    sent_power,
)
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study, to_toml
from octant.reader_design.study_file.rfid import Rfid

C = 299_792_458.0
STUDY = """
[radio]
frequency_hz = {frequency_hz}
[room]
free_space = true
[[tag]]
id = "far"
position_m = [0.0, 0.0, {z_m}]
kind = "{kind}"
sensitivity_dbm = -18.0
{tag}
[[tag]]
id = "active"
position_m = [1.0, 0.0, {z_m}]
antenna = "dipole"
[reader]
response = "isolated"
ground_plane_m = 0.5
antenna_radius_m = 0.2
height_m = 0.5
[rfid]
{rfid}
"""
ETSI = 'region = "etsi"'
LOSSES = "mismatch_loss_db = 1.0\npolarisation_loss_db = 0.5"
TILTED = 'separate"\ntransmitter_antenna = "patch"\ntransmitter_axis = [0.5, -1.0, 0.8]\n#'
FCC = 'region = "fcc"'


def written(rfid=ETSI, frequency_hz=868e6, kind="passive", tag="", z_m=2.0):
    if "antenna" not in tag:
        tag = f'antenna = "dipole"\n{tag}'
    return STUDY.format(rfid=rfid, frequency_hz=frequency_hz, kind=kind, tag=tag, z_m=z_m)


def parsed(*arguments, **options):
    text = written(*arguments, **options)
    return parse_study(text, source="s.toml", directory=Path.cwd())


def isotropic(study):
    setting = build_setting(study)
    return setting.with_responses(isotropic_responses(study.radio.frequencies_hz))


@pytest.mark.parametrize(
    ("rfid", "frequency_hz", "eirp_w"),
    [
        (ETSI, 868e6, 2.0 * 1.6406),
        (ETSI, 915e6, 4.0 * 1.6406),
        (FCC, 915e6, 4.0),
        (FCC, 2.45e9, 4.0),
        (ETSI, 2.45e9, 0.5),
        ('power_w = 1.0\npower_as = "erp"', 868e6, 1.6406),
        ("power_w = 0.7", 433e6, 0.7),
    ],
)
def test_the_range_in_the_open_is_that_of_the_link_budget(rfid, frequency_hz, eirp_w):
    study = parsed(rfid, frequency_hz, z_m=0.6, tag=LOSSES)
    setting = isotropic(study)
    found = read_range(setting, setting.tags[0])
    arrives_w = eirp_w * 1.6409 * 10.0**-0.15  # dipole level with the reader, 1.5 dB of losses
    budget_m = C / frequency_hz / (4.0 * math.pi) * math.sqrt(arrives_w / 10.0**-4.8)
    assert found.slant_m == pytest.approx(budget_m, rel=3e-3)
    assert found.closed_form_m == pytest.approx(found.slant_m, rel=1e-9)
    assert found.peak_m == pytest.approx(budget_m, rel=1e-3)
    assert found.limit == "wake-up"


@pytest.mark.parametrize(
    ("transmitter", "tag"),
    [
        ("each", ""),
        ("strongest", ""),
        pytest.param("separate", "", marks=pytest.mark.slow),
        ("each", 'antenna = "patch"\naxis = [1.0, 0.3, -0.4]'),
        (TILTED, 'antenna = "patch"\naxis = [1.0, 0.3, -0.4]\nazimuth_deg = 50.0'),
    ],
)
def test_solver_and_friis_agree_on_the_range_of_a_reader(transmitter, tag):
    rfid = f'{ETSI}\nreader_sensitivity_dbm = -120.0\ntransmitter = "{transmitter}"'
    setting = build_setting(parsed(rfid, tag=tag))
    found = read_range(setting, setting.tags[0])
    assert found.slant_m == pytest.approx(found.closed_form_m, rel=1e-6)
    assert 5.0 < found.slant_m <= found.peak_m * 1.01
    assert math.hypot(found.floor_m, 1.5) == pytest.approx(found.slant_m)


def test_a_deaf_reader_ends_the_range_of_a_semi_passive_tag():
    study = parsed(
        f"{ETSI}\nreader_sensitivity_dbm = -70.0", kind="semi_passive", z_m=0.6, tag=LOSSES
    )
    setting = isotropic(study)
    found = read_range(setting, setting.tags[0])
    step_m = C / 868e6 / (4.0 * math.pi)
    ratio = 2.0 * 1.6406 * 1.6409**2 * 10.0**-0.7 / 10.0**-10.0
    assert found.limit == "decoding"
    assert found.slant_m == pytest.approx(step_m * ratio**0.25, rel=1e-3)


def test_semi_passive_tags_are_more_sensitive_unless_the_study_says_otherwise():
    budgets = {}
    for kind in ("passive", "semi_passive"):
        text = written(kind=kind).replace("sensitivity_dbm = -18.0", "")
        setting = build_setting(parse_study(text, source="s", directory=Path.cwd()))
        budgets[kind] = setting.link(setting.tags[0]).budget.wakes_w
    assert budgets["passive"] == pytest.approx(10.0**-4.8)
    assert budgets["semi_passive"] == pytest.approx(10.0**-6.1)


def test_without_a_power_the_reader_sends_what_its_region_allows():
    assert sent_power(Rfid(region="etsi"), 868e6, 2.0).conducted_w == pytest.approx(
        1.6406, rel=1e-4
    )
    assert sent_power(Rfid(region="fcc"), 915e6, 2.0).conducted_w == 1.0  # conducted limit
    assert sent_power(Rfid(region="fcc"), 915e6, 8.0).conducted_w == 0.5  # EIRP limit
    assert sent_power(Rfid(power_w=9.0), 915e6, 8.0).eirp_w == 72.0  # no region


def test_more_than_the_limit_is_refused_and_more_conducted_power_warned_of():
    loud = Rfid(region="etsi", power_w=2.0)
    with pytest.raises(ConfigError, match=r"4 W of EIRP, but EN 302 208 allows 3\.281 W"):
        sent_power(loud, 868e6, 2.0)
    assert sent_power(loud, 868e6, 1.6).conducted_w == 2.0
    with pytest.warns(PhysicsWarning, match="takes 2 W into an antenna of 3.0 dBi"):
        sent = sent_power(Rfid(region="fcc", power_w=4.0, power_as="eirp"), 915e6, 2.0)
    assert sent.conducted_w == 2.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sent_by(Rfid(region="fcc", power_w=4.0, power_as="eirp"), isotropic_responses([915e6]))


def test_the_sent_power_counts_the_strongest_direction_of_all_antennas():
    setting = build_setting(parsed())
    gain = peak_gain(setting.responses[0].pattern)
    assert gain == pytest.approx(1.641, rel=1e-3)
    sent = sent_by(setting.study.rfid, setting.responses)
    assert sent.conducted_w * gain == pytest.approx(3.2812, rel=1e-4)
    patch = build_setting(
        parsed(f'{ETSI}\ntransmitter = "separate"\ntransmitter_antenna = "patch"')
    )
    assert sent_by(patch.study.rfid, patch.responses).conducted_w < 0.25 * sent.conducted_w


def test_only_tags_that_the_reader_wakes_have_backscatter_links():
    setting = build_setting(parsed())
    far, active = (setting.link(tag) for tag in setting.tags)
    assert isinstance(far, BackscatterLink)
    assert not isinstance(active, BackscatterLink)
    poses = np.array([[40.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    asleep, awake = far.rss_w(poses)
    assert (asleep == 0.0).all()
    assert awake.max() > 0.0
    known = setting.open_link(setting.tags[0]).rss_w(poses)
    assert (known[0] > 0.0).any()
    np.testing.assert_array_equal(known[1], awake)


def test_an_antenna_in_the_room_wakes_tags_wherever_the_robot_is():
    text = f'{ETSI}\ntransmitter = "separate"\ntransmitter_position_m = [3.0, 0.0, 2.1]'
    setting = build_setting(parsed(text))
    found = setting.link(setting.tags[0]).answers([[5.0, 1.0, 0.0], [9.0, -3.0, 2.0]])
    slant, cosine = math.hypot(3.0, 0.1), 0.1 / math.hypot(3.0, 0.1)
    dipole = make_antenna("dipole", 868e6).far_field(math.acos(cosine), 0.0)[0]
    gain = abs(dipole) ** 4 * (C / 868e6 / (4.0 * math.pi * slant)) ** 2
    sent_w = sent_by(setting.study.rfid, setting.responses).conducted_w
    np.testing.assert_allclose(found.chip_w, sent_w * gain, rtol=1e-9)
    assert read_range(setting, setting.tags[0]) is None


def test_antennas_have_the_time_of_an_inventory_or_the_sensors():
    setting = build_setting(parsed(f"{ETSI}\nother_tags = 3"))
    found = study_inventory(setting, {}, key="mission.sample_time_s", period_s=1.0)
    assert list(found.crowd) == ["far"]
    assert found.dwell_s == round_s(setting.study.rfid.air_interface(), 4)
    assert 0.5 < float(found.rates.of(1)) < 1.0
    with pytest.raises(ConfigError, match=r"4 tags takes .* s on each of 8 antennas"):
        study_inventory(setting, {}, key="mission.sample_time_s", period_s=0.1)
    free = build_setting(parsed(f'{ETSI}\nprotocol = "none"'))
    assert study_inventory(free, {}, key="mission.sample_time_s", period_s=0.01) is None


REFUSALS = {
    "no table": ("", "tag[0].kind is 'passive', but the study has no table [rfid]"),
    "no power": ("[rfid]", "rfid.power_w is missing"),
    "band": (
        '[rfid]\nregion = "fcc"',
        "sends at 868 MHz, but rfid.region 'fcc' allows RFID at 902",
    ),
    "eirp": (
        '[rfid]\nregion = "etsi"\npower_w = 4.0\npower_as = "eirp"',
        "makes 4 W of EIRP, but EN 302 208 allows 3.281 W from 865 to 868 MHz",
    ),
    "erp": ('[rfid]\nregion = "etsi"\npower_w = 2.1\npower_as = "erp"', "3.445 W of EIRP"),
    "separate": ("[rfid]\npower_w = 1.0\ntransmitter_height_m = 0.3", 'transmitter = "separate"'),
    "antenna": (
        '[rfid]\npower_w = 1.0\ntransmitter = "separate"\ntransmitter_antenna = "dipol"',
        "did you mean 'dipole'",
    ),
    "link frequency": ("[rfid]\npower_w = 1.0\nblf_hz = 640e3\ntari_s = 25e-6", "rfid.blf_hz"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_what_does_not_fit_is_refused(name):
    table, words = REFUSALS[name]
    text = written(rfid="@").replace("[rfid]\n@", table)
    with pytest.raises(ConfigError) as refusal:
        parse_study(text, source="s", directory=Path.cwd())
    assert words in str(refusal.value)


def test_active_tags_take_neither_the_table_nor_its_keys():
    with pytest.raises(
        ConfigError, match=r"tag\[0\].sensitivity_dbm is -18, but the tag is active"
    ):
        parsed(kind="active")
    text = written(kind="active")
    with pytest.raises(ConfigError, match=r"table \[rfid\], but all its tags are active"):
        parse_study(text.replace("sensitivity_dbm = -18.0", ""), source="s", directory=Path.cwd())


def test_the_table_is_written_and_read_back():
    study = parsed(f'{ETSI}\ntransmitter = "separate"\nother_tags = 7\nmiller = 2')
    assert parse_study(to_toml(study), source="s", directory=Path.cwd()) == study
