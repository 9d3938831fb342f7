"""A reader drawn to scale as a small SVG picture: from above and from the side, with dimensions."""

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from octant.geometries.reader_body import ground_plane_outline_m
from octant.reader_design.study_file.reader import Reader

FloatArray = npt.NDArray[np.float64]

SIZE = 200.0
"""Width of the larger of both views [pixels of the picture]."""
_MARGIN = 52.0
_NARROW = "\u202f"


def reader_drawing(design: Reader, frequency_hz: float) -> str:
    """Return the reader from above and from the side, one below the other, as SVG.

    Parameters
    ----------
    design, frequency_hz : The reader; the carrier, at which its antennas are resonant [Hz].
    """
    body = design.body()
    rim = ground_plane_outline_m(
        design.ground_plane_m, shape=design.ground_plane_shape, antennas=design.antennas
    )
    width_m, _ = design.size_m(frequency_hz)
    half_m = max(0.5 * width_m, float(np.abs(rim).max()))
    views = _Views(scale=SIZE / (2.0 * half_m), half_m=half_m)
    length_m = design.element(frequency_hz).length_m or 0.0
    foot_m = _foot_m(design)
    plate_m = float(body.plate_outline_m[:, 1].max()) if body.has_plates else 0.0
    top_m = max(foot_m + length_m, plate_m)
    above = [*views.top(design, rim, body.plate_azimuths_rad, body.plate_outer_radius_m)]
    side = [*views.side(design, length_m, top_m)]
    width = SIZE + 2.0 * _MARGIN + 34.0
    height = views.side_y(top_m) + 46.0
    return (
        f'<svg viewBox="0 0 {width:.0f} {height:.0f}" role="img" '
        f'aria-label="{_described(design, length_m)}">{"".join((*above, *side))}</svg>'
    )


def reader_words(design: Reader, frequency_hz: float) -> str:
    """Return what the drawing shows, in one sentence with its lengths [cm].

    Parameters
    ----------
    design, frequency_hz : As for `reader_drawing` [Hz].
    """
    return _described(design, design.element(frequency_hz).length_m or 0.0)


def _described(design: Reader, length_m: float) -> str:
    plates = (
        f"plates {_cm(design.plate_height_m)} high between them"
        if design.plate_height_m > 0.0
        else "no plates"
    )
    return (
        f"The reader to scale, from above and from the side: {design.antennas} "
        f"{design.antenna}s of {_cm(length_m)} at {_cm(design.antenna_radius_m)} from the axis, "
        f"{plates}, on a {design.ground_plane_shape} ground plane of "
        f"{_cm(design.ground_plane_m)}; antenna 3 looks to the front of the robot."
    )


def _foot_m(design: Reader) -> float:
    joined = design.antenna == "monopole" and design.monopole_plane_m == 0.0
    return 0.0 if joined else design.gap_m


def _cm(length_m: float) -> str:
    text = f"{100.0 * length_m:.1f}".removesuffix(".0")
    return f"{text}{_NARROW}cm"


class _Views:
    """Both views in the picture's pixels, x to the right and y down."""

    def __init__(self, *, scale: float, half_m: float) -> None:
        self.scale = scale
        self.centre = (_MARGIN + 0.5 * SIZE, 34.0 + half_m * scale)
        self.half = half_m * scale

    def side_y(self, top_m: float) -> float:
        """Return where the ground plane lies in the side view."""
        return self.centre[1] + self.half + 62.0 + top_m * self.scale

    def at(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Return a place in the view from above."""
        return self.centre[0] + x_m * self.scale, self.centre[1] - y_m * self.scale

    def top(
        self, design: Reader, rim_m: FloatArray, plates_rad: FloatArray, reach_m: float
    ) -> Iterator[str]:
        """Yield the reader from above, its front up."""
        if design.ground_plane_shape == "round":
            yield _circle(self.centre, 0.5 * design.ground_plane_m * self.scale, "body")
        else:
            corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in (self.at(*c) for c in rim_m))
            yield f'<polygon class="body" points="{corners}"/>'
        for azimuth in plates_rad:
            end = self.at(reach_m * math.cos(azimuth), reach_m * math.sin(azimuth))
            yield _line(self.centre, end, "edge")
        yield _circle(self.centre, design.antenna_radius_m * self.scale, "dim", dash="3 3")
        r_a = design.antenna_radius_m
        for i in range(design.antennas):
            azimuth = 2.0 * math.pi * i / design.antennas
            unit = math.cos(azimuth), math.sin(azimuth)
            yield _circle(self.at(r_a * unit[0], r_a * unit[1]), 4.2, "dot")
            inner = r_a - 13.0 / self.scale
            x, y = self.at(inner * unit[0], inner * unit[1])
            yield _text((x, y + 3.4), str(i + 1))
        x, y = self.centre[0], self.centre[1] - self.half
        yield f'<path class="front" d="M{x:.1f} {y - 5:.1f}v-16m-4 6l4 -6l4 6"/>'
        yield _text((x + 9.0, y - 12.0), "front", anchor="start")
        low = self.centre[1] + self.half + 17.0
        half = 0.5 * design.ground_plane_m * self.scale
        across = {"square": "", "round": "Ø ", "octagon": "across "}[design.ground_plane_shape]
        yield from _dimension(
            (self.centre[0] - half, low),
            (self.centre[0] + half, low),
            f"{across}{_cm(design.ground_plane_m)}",
        )
        place = self.at(r_a, 0.0)
        right = self.centre[0] + self.half + 8.0
        yield _line((place[0] + 5.0, place[1]), (right, place[1]), "dim")
        yield _text((right + 3.0, place[1] - 3.0), "r_a", anchor="start", symbol=True)
        yield _text((right + 3.0, place[1] + 9.0), _cm(r_a), anchor="start", kind="number")

    def side(self, design: Reader, length_m: float, top_m: float) -> Iterator[str]:
        """Yield the section through antenna 1, with the plates turned into it."""
        x, y = self.centre[0], self.side_y(top_m)
        body, scale = design.body(), self.scale
        reach, rim = body.plate_outer_radius_m * scale, body.plate_height_m * scale
        if body.has_plates:
            outline = scale * body.plate_outline_m
            both = np.concatenate((outline[-2::-1] * (-1.0, 1.0), outline[1:]))
            edge = "".join(f"L{x + r:.1f} {y - h:.1f}" for r, h in both)
            yield (
                f'<path class="sheetmetal" d="M{x - reach:.1f} {y:.1f}v{-rim:.1f}{edge}V{y:.1f}Z"/>'
            )
        half = 0.5 * design.ground_plane_m * scale
        yield _line((x - half, y), (x + half, y), "front")
        foot, length = _foot_m(design) * scale, length_m * scale
        own = 0.5 * body.fitted_monopole_plane_m * scale if design.antenna == "monopole" else 0.0
        for side in (-1.0, 1.0):
            place = x + side * design.antenna_radius_m * scale
            yield _line((place, y - foot), (place, y - foot - length), "wire")
            if own:
                yield _line((place - own, y - foot), (place + own, y - foot), "edge")
        right = x + self.half + 12.0
        yield from _dimension((right, y - foot - length), (right, y - foot), _cm(length_m))
        if body.has_plates:
            left = x - self.half - 12.0
            yield from _dimension((left, y - rim), (left, y), _cm(body.plate_height_m), side=-1.0)
            yield _text((left - 6.0, y - 0.5 * rim - 10.0), "h_p", anchor="end", symbol=True)
        yield _text((x, y + 26.0), f"gap {_cm(_foot_m(design))} under the antennas")


def _circle(place: tuple[float, float], radius: float, kind: str, *, dash: str = "") -> str:
    x, y = place
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}"{dashes}/>'


def _line(start: tuple[float, float], end: tuple[float, float], kind: str) -> str:
    (xa, ya), (xb, yb) = start, end
    return f'<line class="{kind}" x1="{xa:.1f}" y1="{ya:.1f}" x2="{xb:.1f}" y2="{yb:.1f}"/>'


def _text(
    place: tuple[float, float],
    text: str,
    *,
    anchor: str = "middle",
    kind: str = "",
    symbol: bool = False,
) -> str:
    x, y = place
    inner = text
    if symbol:
        letter, index = text.split("_")
        inner = (
            f'<tspan font-style="italic">{letter}</tspan>'
            f'<tspan dy="2.5" font-size="7">{index}</tspan>'
        )
    style = f' class="{kind}"' if kind else ""
    return f'<text{style} x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{inner}</text>'


def _dimension(
    start: tuple[float, float], end: tuple[float, float], text: str, *, side: float = 1.0
) -> Iterator[str]:
    """Yield a dimension line with ticks and its length, beside a vertical or below a level one."""
    (xa, ya), (xb, yb) = start, end
    yield _line(start, end, "dim")
    level = abs(ya - yb) < 1e-6
    for x, y in (start, end):
        dx, dy = (0.0, 4.0) if level else (4.0, 0.0)
        yield _line((x - dx, y - dy), (x + dx, y + dy), "dim")
    if level:
        yield _text((0.5 * (xa + xb), ya + 12.0), text, kind="number")
    else:
        anchor = "start" if side > 0.0 else "end"
        yield _text((xa + 6.0 * side, 0.5 * (ya + yb) + 3.0), text, anchor=anchor, kind="number")
