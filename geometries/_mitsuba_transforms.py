"""The transforms of a Mitsuba scene: translate, rotate, scale, matrix, lookat, in their order."""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from lxml.etree import _Element as Element

from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]
Attributes = Callable[[Element, str], str | None]
"""Returns an attribute of an element with its ``$variables`` filled in, or None."""

_AXES = ("x", "y", "z")


def numbers_of(text: str, *, where: str) -> list[float]:
    """Return the finite numbers of a text, separated by spaces or commas [-].

    Parameters
    ----------
    text : str
        For example ``1, 2, 3``.
    where : str
        File, line and element, for messages.

    Returns
    -------
    list of float
        The numbers, in the unit of the file [-].

    Raises
    ------
    GeometryError
        When a word is not a finite number.
    """
    try:
        found = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        found = [math.nan]
    if not all(math.isfinite(number) for number in found):
        msg = f"{where} gives {text!r}, but finite numbers are needed there."
        raise GeometryError(msg)
    return found


def vector_of(
    element: Element,
    attribute: Attributes,
    *,
    where: str,
    default: float,
) -> FloatArray:
    """Return the vector of ``value="x y z"`` (one number for all three) or of x, y and z [-].

    Parameters
    ----------
    element : lxml element
        E.g. ``<translate x="1"/>``.
    attribute : callable
        Reads an attribute.
    where : str
        File, line and element, for messages.
    default : float
        What a coordinate is that is not given [-].

    Returns
    -------
    (3,) float64
        In the unit of the file [-].

    Raises
    ------
    GeometryError
        When there are not one or three finite numbers.
    """
    value = attribute(element, "value")
    if value is None:
        given = [attribute(element, axis) for axis in _AXES]
        parts = [[default] if g is None else numbers_of(g, where=where) for g in given]
        if all(len(part) == 1 for part in parts):
            return np.array([part[0] for part in parts])
    else:
        found = numbers_of(value, where=where)
        if len(found) in (1, 3):
            return np.array(found * (3 // len(found)))
    msg = f"{where} must give one or three numbers."
    raise GeometryError(msg)


def transform_matrix(
    element: Element | None,
    attribute: Attributes,
    *,
    where: str,
) -> FloatArray:
    """Return the matrix of a ``<transform>``; what stands first in it is done first [-].

    Parameters
    ----------
    element : lxml element or None
        The transform; None leaves everything in its place.
    attribute : callable
        Reads an attribute.
    where : str
        File and shape, for messages.

    Returns
    -------
    (4, 4) float64
        Affine [-], lengths in the unit of the file.

    Raises
    ------
    GeometryError
        When a step is unknown or not numbers, or the whole is singular or not affine.

    References
    ----------
    .. [1] W. Jakob et al., Mitsuba 3 documentation, "Scene XML file format", transformations.
    """
    total = np.eye(4)
    for step in () if element is None else element:
        kind = str(step.tag)
        at = f"<{kind}> in {where}, line {step.sourceline},"
        if kind not in _STEPS:
            msg = f"{at} is no transformation; known are {', '.join(_STEPS)}."
            raise GeometryError(msg)
        total = _STEPS[kind](step, attribute, at) @ total
    if not np.array_equal(total[3], (0.0, 0.0, 0.0, 1.0)):
        msg = f"the to_world matrix of {where} is a perspective one; give (0, 0, 0, 1) as last row."
        raise GeometryError(msg)
    scale = float(np.abs(total[:3, :3]).max())
    if scale == 0.0 or abs(np.linalg.det(total[:3, :3] / scale)) < 1e-12:
        msg = f"the to_world matrix of {where} is singular: it makes the shape flat; correct it."
        raise GeometryError(msg)
    return total


def _translate(step: Element, attribute: Attributes, where: str) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, 3] = vector_of(step, attribute, where=where, default=0.0)
    return matrix


def _scale(step: Element, attribute: Attributes, where: str) -> FloatArray:
    return np.diag([*vector_of(step, attribute, where=where, default=1.0), 1.0])


def _rotate(step: Element, attribute: Attributes, where: str) -> FloatArray:
    axis = vector_of(step, attribute, where=where, default=0.0)
    angle = numbers_of(attribute(step, "angle") or "", where=where)
    length = float(np.linalg.norm(axis))
    if length == 0.0 or len(angle) != 1:
        msg = f"{where} needs an axis other than zero and one angle in degrees."
        raise GeometryError(msg)
    x, y, z = axis / length
    quarters = angle[0] / 90.0
    if quarters == round(quarters):  # right angles stay exact
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    else:
        cos, sin = math.cos(math.radians(angle[0])), math.sin(math.radians(angle[0]))
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    unit = np.array([x, y, z])
    matrix = np.eye(4)
    matrix[:3, :3] = cos * np.eye(3) + sin * cross + (1.0 - cos) * np.outer(unit, unit)
    return matrix


def _matrix(step: Element, attribute: Attributes, where: str) -> FloatArray:
    found = numbers_of(attribute(step, "value") or "", where=where)
    if len(found) == 9:
        matrix = np.eye(4)
        matrix[:3, :3] = np.reshape(found, (3, 3))
        return matrix
    if len(found) != 16:
        msg = f"{where} has {len(found)} numbers, but a matrix has 16 (or 9), row by row."
        raise GeometryError(msg)
    return np.reshape(found, (4, 4)).astype(np.float64)


def _lookat(step: Element, attribute: Attributes, where: str) -> FloatArray:
    given = [numbers_of(attribute(step, n) or "", where=where) for n in ("origin", "target")]
    above = numbers_of(attribute(step, "up") or "0 0 1", where=where)
    if any(len(vector) != 3 for vector in (*given, above)):
        msg = f"{where} needs origin, target and up of three numbers each."
        raise GeometryError(msg)
    origin, target, up = (np.array(vector) for vector in (*given, above))
    ahead = target - origin
    left = np.cross(up, ahead)
    if np.linalg.norm(left) <= 1e-12 * np.linalg.norm(up) * np.linalg.norm(ahead):
        msg = f"{where} looks along its own up, or nowhere; give another target or up."
        raise GeometryError(msg)
    ahead, left = ahead / np.linalg.norm(ahead), left / np.linalg.norm(left)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack((left, np.cross(ahead, left), ahead, origin))
    return matrix


_STEPS = {
    "translate": _translate,
    "scale": _scale,
    "rotate": _rotate,
    "matrix": _matrix,
    "lookat": _lookat,
}
