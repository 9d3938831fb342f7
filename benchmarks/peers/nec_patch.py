"""A patch on air over an infinite plane by nec2++ on wire grids: tests/reference/nec/patch.json.

Run it outside of this project, in an environment of its own with PyNEC 2.3.4 (GPL-3.0)::

    python nec_patch.py > patch.json

Wires have the radius whose surface is that of both sides of the sheet's cell, cell / (2 pi); the
probe stands for a strip of width / 15 at the middle of one edge. The resistance hangs on how the
probe is cut; times the mean gain, which is radiated over accepted power, it does not.
"""

import json
import math

import numpy as np
import PyNEC

LENGTH_M, WIDTH_M, HEIGHT_M = 0.46, 0.5, 0.03
PROBE_M = 0.5 / 15 / 4
AT_1_M_MHZ = 299.792458
SHARES = np.linspace(0.90, 0.99, 19)
STEP_DEG = 2.0


def grid(rows, columns):
    """Return a fed wire grid, and how many wires it has."""
    along, across = LENGTH_M / rows, WIDTH_M / columns
    x = np.linspace(-0.5 * LENGTH_M, 0.5 * LENGTH_M, rows + 1)
    y = np.linspace(-0.5 * WIDTH_M, 0.5 * WIDTH_M, columns + 1)
    wires = [
        (x[i], b, HEIGHT_M, x[i + 1], b, HEIGHT_M, across / (2 * math.pi))
        for b in y
        for i in range(rows)
    ]
    wires += [
        (a, y[j], HEIGHT_M, a, y[j + 1], HEIGHT_M, along / (2 * math.pi))
        for a in x
        for j in range(columns)
    ]
    wires.append((x[0], 0.0, 0.0, x[0], 0.0, HEIGHT_M, PROBE_M))
    context = PyNEC.nec_context()
    geometry = context.get_geometry()
    for tag, (*ends, radius) in enumerate(wires, start=1):
        geometry.wire(tag, 1, *map(float, ends), float(radius), 1.0, 1.0)
    context.geometry_complete(1)
    context.gn_card(1, 0, 0, 0, 0, 0, 0, 0)
    context.ex_card(0, len(wires), 1, 0, 1.0, 0, 0, 0, 0, 0)
    return context, len(wires)


def impedance(rows, columns, share):
    """Return input impedance [ohm], mean gain over the sphere [-] and gain towards zenith [-]."""
    context, _ = grid(rows, columns)
    context.fr_card(0, 1, float(share * AT_1_M_MHZ), 0)
    count = round(90.0 / STEP_DEG) + 1
    context.rp_card(0, count, 72, 0, 5, 0, 0, 0.0, 0.0, STEP_DEG, 5.0, 0, 0)
    z = complex(context.get_input_parameters(0).get_impedance()[0])
    gain = 10.0 ** (np.array(context.get_radiation_pattern(0).get_gain()).reshape(count, 72) / 10.0)
    weight = np.sin(np.radians(np.arange(count) * STEP_DEG))
    weight[-1] *= 0.5
    mean = float((gain.mean(axis=1) * weight).sum() * math.radians(STEP_DEG) / 2.0)
    return z, mean, float(gain[0].mean())


def resonance(rows, columns):
    """Return the share of the frequency with the greatest resistance, by a parabola [-]."""
    z = np.array([impedance(rows, columns, share)[0].real for share in SHARES])
    near = slice(int(z.argmax()) - 1, int(z.argmax()) + 2)
    fit = np.polyfit(SHARES[near], z[near], 2)
    return float(-0.5 * fit[1] / fit[0])


if __name__ == "__main__":
    found = []
    for rows, columns in ((10, 10), (14, 16), (20, 22)):
        place = resonance(rows, columns)
        z, mean, zenith = impedance(rows, columns, place)
        found.append(
            {
                "rows": rows,
                "columns": columns,
                "resonance_share": round(place, 5),
                "resistance_ohm": round(z.real, 2),
                "mean_gain": round(mean, 4),
                "zenith_dbi": round(10.0 * math.log10(zenith / mean), 3),
            }
        )
    print(json.dumps(found, indent=1))
