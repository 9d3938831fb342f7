"""XML of foreign scenes: parsed without entities, DTD and network; numbers with sentences."""

import math
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt
from lxml import etree
from lxml.etree import _Element as Element

from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]
URL = re.compile(r"^(https?|ftp|data|s?ftp)\s*:", re.IGNORECASE)
"""Names of files that are addresses on a network, or data."""


def xml_root(path: Path, *, what: str, roots: tuple[str, ...]) -> Element:
    """Return the root of an XML file; refuse damaged ones, those with a DOCTYPE and other roots.

    Parameters
    ----------
    path : The file.
    what : What it should be, for messages, such as "an SDF world".
    roots : Names that its root may have, namespaces apart.
    """
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True,
        remove_pis=True,
    )  # fmt: skip
    try:
        tree = etree.parse(str(path), parser)
    except (etree.XMLSyntaxError, OSError) as exc:
        reason = str(exc).splitlines()[0].rstrip(".")
        msg = f"{path} cannot be read as {what} ({reason}); check the file."
        raise GeometryError(msg) from exc
    root = tree.getroot()
    name = etree.QName(root).localname
    if tree.docinfo.doctype or name not in roots:
        wrong = "declares a DOCTYPE" if tree.docinfo.doctype else f"starts with <{name}>"
        msg = f"{path} {wrong}, but {what} is a plain <{roots[0]}> file; export it again."
        raise GeometryError(msg)
    return root


def finite_numbers(text: str | None, count: int, *, where: str, default: str = "") -> FloatArray:
    """Return so many finite numbers of a text that are split at spaces.

    Parameters
    ----------
    text, default : The text, and what stands for none or an empty one.
    count : How many there must be [-].
    where : What gives them, for messages.
    """
    given = (text or "").strip() or default
    try:
        found = [float(word) for word in given.split()]
    except ValueError:
        found = []
    if len(found) != count or not all(math.isfinite(number) for number in found):
        msg = f"{where} is {given[:60]!r}, but {count} finite number(s) are needed there."
        raise GeometryError(msg)
    return np.array(found)


def pose_matrix(
    translation: npt.ArrayLike, rpy_rad: npt.ArrayLike, *, quaternion: npt.ArrayLike | None = None
) -> FloatArray:
    """Return the (4, 4) matrix [-] of a pose: turned about x, then y, then z, all fixed, and moved.

    Parameters
    ----------
    translation : (3,) array_like — [m].
    rpy_rad : (3,) array_like — Roll, pitch and yaw [rad]; right angles stay exact.
    quaternion : (4,) array_like or None — x, y, z, w in place of them [-].
    """
    from scipy.spatial.transform import Rotation

    matrix = np.eye(4)
    if quaternion is not None:
        turn = Rotation.from_quat(np.asarray(quaternion)).as_matrix()
    else:
        turn = Rotation.from_euler("xyz", np.asarray(rpy_rad)).as_matrix()
    exact = np.round(turn)
    near = np.abs(turn - exact) < 1e-5  # files write pi as 3.14159
    matrix[:3, :3] = exact if near.all() else turn
    matrix[:3, 3] = translation
    return matrix
