"""Image fields against the exact tracer, in a room, over channels, and where they must refuse."""

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.image_fields import trace_image_field
from octant.em.power.received_power import antenna_power
from octant.em.search.candidates import Candidates, SolverSettings
from octant.em.search.images import search_images
from octant.geometries.errors import GeometryError, MaterialRangeError
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

CARRIER_HZ = 2.4e9
TAGS = [(1.0, 0.5, 2.9), (-1.5, -1.0, 2.9)]
AXIS = np.linspace(-2.0, 2.0, 21)
DIPOLE = make_antenna("dipole", CARRIER_HZ)
PROBE = make_antenna("isotropic_theta", CARRIER_HZ)


@pytest.fixture(scope="module")
def scene():
    return build_scene(box_room((7.0, 6.0, 3.0), origin_m=(-3.5, -3.0, 0.0), material="concrete"))


def field_of(scene, *, channels_hz=(CARRIER_HZ,), tags=TAGS, axis=AXIS, order=2):
    return trace_image_field(
        radio_scene(scene, CARRIER_HZ),
        [(tag, DIPOLE) for tag in tags],
        receiver=PROBE,
        x_m=axis,
        y_m=axis,
        z_m=0.3,
        solver=SolverSettings(max_reflections=order),
        channels_hz=channels_hz,
        power_w=0.5,
    )


def exact_w(scene, tag, places, frequency_hz=CARRIER_HZ, order=2):
    return antenna_power(
        radio_scene(scene, frequency_hz),
        Candidates(images=search_images(scene, tag, order)),
        np.column_stack([places, np.full(len(places), 0.3)]),
        transmitter=make_antenna("dipole", frequency_hz, length_m=DIPOLE.length_m),
        receiver=make_antenna("isotropic_theta", frequency_hz),
        power_w=0.5,
    )


def test_on_the_grid_the_field_is_the_tracers(scene):
    x, y = np.meshgrid(AXIS, AXIS, indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel()])
    field = field_of(scene)
    power, mean = field.coherent_w(places), field.local_mean_w(places)
    for number, tag in enumerate(TAGS):
        exact = exact_w(scene, tag, places)
        assert power[:, number] == pytest.approx(exact.coherent_w, rel=1e-7)
        assert mean[:, number] == pytest.approx(exact.local_mean_w, rel=1e-9)
    # One image for each path of an empty room, however the walls are ordered: 1 + 6 + 18.
    assert np.diff(field.first_image).tolist() == [25, 25]


def test_between_the_grid_points_fades_are_resolved(scene):
    places = np.random.default_rng(1).uniform(-1.9, 1.9, (400, 2))
    power = field_of(scene).coherent_w(places)
    for number, tag in enumerate(TAGS):
        exact = exact_w(scene, tag, places).coherent_w
        off_db = np.abs(10.0 * np.log10(power[:, number] / exact))
        assert np.quantile(off_db, 0.5) < 0.02
        assert np.quantile(off_db, 0.97) < 0.3
        assert np.std(10.0 * np.log10(exact)) > 2.0  # there are fades to resolve


def test_channels_average_the_power_of_each(scene):
    places = np.random.default_rng(2).uniform(-1.9, 1.9, (100, 2))
    comb = np.linspace(2.402e9, 2.48e9, 5)
    power = field_of(scene, channels_hz=comb).coherent_w(places)[:, 0]
    exact = np.mean([exact_w(scene, TAGS[0], places, f).coherent_w for f in comb], axis=0)
    assert np.quantile(np.abs(10.0 * np.log10(power / exact)), 0.9) < 0.4


def test_many_places_are_the_same_bits_as_few(scene):
    places = np.random.default_rng(3).uniform(-1.9, 1.9, (700, 2))
    field = field_of(scene)
    whole = field.coherent_w(places)
    assert (whole[:5] == field.coherent_w(places[:5])).all()
    assert (whole[690:] == field.coherent_w(places[690:])).all()


def test_what_cannot_be_answered_is_refused(scene):
    with pytest.raises(GeometryError, match="outside the traced rectangle"):
        field_of(scene).coherent_w(np.array([[2.5, 0.0]]))
    with pytest.raises(GeometryError, match="two or more along"):
        field_of(scene, axis=np.array([0.0]))
    with pytest.raises(MaterialRangeError, match="evenly"):
        field_of(scene, channels_hz=[2.40e9, 2.41e9, 2.43e9])
    with pytest.raises(MaterialRangeError, match="5 %"):
        field_of(scene, channels_hz=[2.0e9])
