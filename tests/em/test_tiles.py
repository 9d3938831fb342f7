"""Places in an order in which neighbours stand together."""

import numpy as np

from octant.em.tiles import near_each_other, put_back


def test_places_in_order_stand_in_squares_and_go_back():
    x, y = np.meshgrid(np.linspace(0.0, 5.0, 60), np.linspace(0.0, 3.0, 70), indexing="ij")
    places = np.column_stack((x.ravel(), y.ravel(), np.full(x.size, 0.3)))
    order = near_each_other(places)
    assert np.array_equal(put_back(order, places[order]), places)
    tiles = [np.ptp(places[order][k : k + 128], axis=0).max() for k in range(0, x.size, 128)]
    # 128 of them fill a square of 0.68 m; a few strips end and begin anew within 128.
    assert np.median(tiles) < 0.9
