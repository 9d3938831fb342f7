"""The name of a cell: the hash of everything that its numbers depend on."""

import hashlib
from dataclasses import asdict

import numpy as np

from octant.em.antennas.kinds import Antenna
from octant.reader_design.setting.design import content_hash
from octant.reader_design.setting.setting import Setting

CELL_FORMAT = 4
"""Raised when the meaning of a cell changes, so that old files are computed again."""


def scene_fingerprint(setting: Setting) -> str:
    """Return a hash of everything in a room that the radio model sees, 64 hexadecimal digits.

    Parameters
    ----------
    setting : Room, materials at every frequency and tags.
    """
    bodies = []
    for body in setting.scene.bodies:
        digest = hashlib.sha256(np.ascontiguousarray(body.vertices_m).tobytes())
        digest.update(np.ascontiguousarray(body.faces).tobytes())
        bodies.append([body.material, digest.hexdigest()])
    tags = [
        [tag.id, tag.position_m.tolist(), *_antenna_inputs(a)]
        for tag in setting.tags
        for a in tag.antennas
    ]
    radios = [[r.frequency_hz, [asdict(m) for m in r.materials]] for r in setting.radios]
    return content_hash(
        {
            "bodies": bodies,
            "tags": tags,
            "radios": radios,
            "heights_m": [setting.reader_z_m, setting.map_z_m],
        }
    )


def _antenna_inputs(antenna: Antenna) -> list[object]:
    table = b"" if antenna.pattern is None else antenna.pattern.tobytes()
    turn = [antenna.axis.tolist(), antenna.azimuth_rad]
    size = [antenna.frequency_hz, antenna.length_m]
    return [antenna.kind, *size, *turn, hashlib.sha256(table).hexdigest()]
