import numpy as np
from numba import njit

from octant.em.antennas._phase_kernels import angle_of, sine_cosine


@njit
def fill(phase, sine, cosine):
    for i in range(len(phase)):
        sine[i], cosine[i] = sine_cosine(phase[i])


@njit
def fill_angles(y, x, angle):
    for i in range(len(x)):
        angle[i] = angle_of(y[i], x[i])


def test_angles_equal_the_librarys_to_rounding_all_around():
    around = np.linspace(-np.pi, np.pi, 100_001)
    ways = np.array([0.0, 1.0, 0.0, -1.0, 0.0, 1e-300, -1e-17, np.sqrt(2.0) - 1.0])
    y = np.concatenate((ways, np.sin(around), np.roll(ways, 1)))
    x = np.concatenate((np.roll(ways, 1), np.cos(around), ways))
    angle = np.empty_like(x)
    fill_angles(y, x, angle)
    assert np.abs(angle - np.arctan2(y, x)).max() < 5e-16
    fill_angles(np.zeros(1), np.zeros(1), angle[:1])
    assert angle[0] == 0.0


def test_sine_and_cosine_equal_the_librarys_to_rounding_over_every_phase_of_a_path():
    quarters = 0.5 * np.pi * np.arange(200_000)
    phase = np.concatenate(
        [
            np.linspace(-10.0, 10.0, 100_001),
            np.random.default_rng(1).uniform(0.0, 1e6, 200_000),
            quarters,
            np.nextafter(quarters, np.inf),
            quarters + 0.25 * np.pi,
        ]
    )
    sine, cosine = np.empty_like(phase), np.empty_like(phase)
    fill(phase, sine, cosine)
    assert np.abs(sine - np.sin(phase)).max() < 2.3e-16
    assert np.abs(cosine - np.cos(phase)).max() < 2.3e-16


def test_no_phase_is_none_and_nan_stays_nan():
    sine, cosine = np.empty(2), np.empty(2)
    fill(np.array([0.0, np.nan]), sine, cosine)
    assert (sine[0], cosine[0]) == (0.0, 1.0)
    assert np.isnan([sine[1], cosine[1]]).all()
