"""Exact Mamdani inference with trapezoidal terms: min implication, max aggregation, centroid."""

import numpy as np
import numpy.typing as npt

from octant.geometries.kernels import kernel

_Floats = npt.NDArray[np.float64]


@kernel
def _sort(values: _Floats, count: int) -> None:
    """Sort the first few values in place; a dozen of them, so by insertion."""
    for i in range(1, count):
        value = values[i]
        j = i - 1
        while j >= 0 and values[j] > value:
            values[j + 1] = values[j]
            j -= 1
        values[j + 1] = value


@kernel
def _membership(x: float, a: float, b: float, c: float, d: float) -> float:
    if not a <= x <= d:  # true for NaN as well
        return 0.0
    if x < b:
        return (x - a) / (b - a)
    if x <= c:
        return 1.0
    return (d - x) / (d - c)


@kernel
def _clipped_lines(
    u: float,
    corners: _Floats,
    weight: _Floats,
    fired: npt.NDArray[np.int64],
    firing: int,
    line: _Floats,
) -> int:
    """Write offset and slope of the lines on which the clipped terms run at u; return how many."""
    lines = 0
    for f in range(firing):
        r = fired[f]
        w = weight[r]
        a, b, c, d = corners[r, 0], corners[r, 1], corners[r, 2], corners[r, 3]
        if u <= a or u >= d:
            continue
        if u < a + w * (b - a):
            line[lines, 0] = -a / (b - a)
            line[lines, 1] = 1.0 / (b - a)
        elif u <= d - w * (d - c):
            line[lines, 0] = w
            line[lines, 1] = 0.0
        else:
            line[lines, 0] = d / (d - c)
            line[lines, 1] = -1.0 / (d - c)
        lines += 1
    return lines


@kernel
def _envelope_moments(
    low: float, high: float, lines: int, line: _Floats, cuts: _Floats
) -> tuple[float, float]:
    """Return the area below the highest of the lines over [low, high], and its first moment."""
    cuts[0] = low
    count = 1
    for i in range(lines):
        for j in range(i + 1, lines):
            if line[i, 1] != line[j, 1]:
                u = (line[j, 0] - line[i, 0]) / (line[i, 1] - line[j, 1])
                if low < u < high:
                    cuts[count] = u
                    count += 1
    cuts[count] = high
    count += 1
    if count > 3:
        _sort(cuts, count)
    area = 0.0
    moment = 0.0
    for s in range(count - 1):
        p = cuts[s]
        q = cuts[s + 1]
        middle = 0.5 * (p + q)
        best = 0
        for i in range(1, lines):
            if line[i, 0] + line[i, 1] * middle > line[best, 0] + line[best, 1] * middle:
                best = i
        yp = line[best, 0] + line[best, 1] * p
        yq = line[best, 0] + line[best, 1] * q
        area += 0.5 * (q - p) * (yp + yq)
        moment += (q - p) / 6.0 * (yp * (2.0 * p + q) + yq * (p + 2.0 * q))
    return area, moment


@kernel
def mamdani_centroids(
    x: _Floats, low: float, high: float, input_corners: _Floats, output_corners: _Floats
) -> _Floats:
    """Return the centroid of every output for every input, (m, k), integrated without a grid.

    x is (m,), moved into [low, high] first; input_corners (r, 4) holds the condition of each rule,
    output_corners (k, r, 4) its conclusion for each output. NaN where no rule fires, and for NaN.
    The aggregated set is, between the sorted corners of all clipped trapezoids, the upper envelope
    of at most r lines: its breakpoints are their crossings.
    """
    samples = x.shape[0]
    rules = input_corners.shape[0]
    outputs = output_corners.shape[0]
    result = np.empty((samples, outputs))
    weight = np.empty(rules)
    fired = np.empty(rules, dtype=np.int64)
    breaks = np.empty(4 * rules)
    line = np.empty((rules, 2))
    cuts = np.empty(2 + (rules * (rules - 1)) // 2)
    for m in range(samples):
        value = x[m]
        if value < low:
            value = low
        elif value > high:
            value = high
        firing = 0
        for r in range(rules):
            w = _membership(
                value,
                input_corners[r, 0],
                input_corners[r, 1],
                input_corners[r, 2],
                input_corners[r, 3],
            )
            if w > 0.0:
                weight[r] = w
                fired[firing] = r
                firing += 1
        for k in range(outputs):
            corners = output_corners[k]
            count = 0
            for f in range(firing):
                r = fired[f]
                w = weight[r]
                breaks[count] = corners[r, 0]
                breaks[count + 1] = corners[r, 0] + w * (corners[r, 1] - corners[r, 0])
                breaks[count + 2] = corners[r, 3] - w * (corners[r, 3] - corners[r, 2])
                breaks[count + 3] = corners[r, 3]
                count += 4
            _sort(breaks, count)
            area = 0.0
            moment = 0.0
            for s in range(count - 1):
                left = breaks[s]
                right = breaks[s + 1]
                if right > left:
                    lines = _clipped_lines(
                        0.5 * (left + right), corners, weight, fired, firing, line
                    )
                    if lines > 0:
                        part, part_moment = _envelope_moments(left, right, lines, line, cuts)
                        area += part
                        moment += part_moment
            result[m, k] = moment / area if area > 0.0 else np.nan
    return result


@kernel
def mamdani_centroid(
    x: float, low: float, high: float, input_corners: _Floats, output_corners: _Floats
) -> _Floats:
    """Return the centroid of every output (k,) for one input; otherwise as mamdani_centroids."""
    one = np.empty(1)
    one[0] = x
    crisp: _Floats = mamdani_centroids(one, low, high, input_corners, output_corners)[0]
    return crisp
