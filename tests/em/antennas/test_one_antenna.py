"""One antenna's field without the others' is what all of them give together."""

import numpy as np

from octant.em.antennas.embedded import ReaderResponse, one_antenna_fields


def noise_response(rng, *, rows, frequency_hz):
    shape = (3, 2, rows, 12)
    return ReaderResponse(
        model="test",
        frequency_hz=frequency_hz,
        azimuths_rad=2.0 * np.pi / 3.0 * np.arange(3),
        phase_centres_m=rng.normal(0.0, 0.1, (3, 3)),
        pattern=rng.normal(size=shape) + 1j * rng.normal(size=shape),
    )


def test_one_antenna_alone_has_the_fields_that_it_has_among_all_bit_for_bit():
    rng = np.random.default_rng(1)
    theta, phi = rng.uniform(0.6, 2.5, 50), rng.uniform(0.0, 2.0 * np.pi, 50)
    same_grid = [noise_response(rng, rows=9, frequency_hz=f) for f in (2.40e9, 2.48e9)]
    other_grid = noise_response(rng, rows=11, frequency_hz=2.44e9)
    for responses in (tuple(same_grid), (*same_grid, other_grid)):
        for number in range(3):
            found = one_antenna_fields(responses, number, theta, phi)
            wanted = np.stack([one.far_field(theta, phi)[number] for one in responses])
            np.testing.assert_array_equal(found, wanted)
