"""The name of a cell: the hash of everything that its numbers depend on."""

import hashlib
from dataclasses import asdict

import msgspec
import numpy as np

from octant.em.antennas.kinds import Antenna
from octant.reader_design.keeping.versions import versions
from octant.reader_design.setting.design import content_hash, response_inputs
from octant.reader_design.setting.evaluation import SweepContext, reference_tag
from octant.reader_design.setting.scene import StudyScene
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.sweep import SWEPT_TABLES

CELL_FORMAT = 4
"""Raised when the meaning of a cell changes, so that old files are computed again."""


def scene_fingerprint(built: StudyScene) -> str:
    """Return a hash of everything in a room that the radio model sees, 64 hexadecimal digits.

    Parameters
    ----------
    built : StudyScene
        Room, materials at every frequency and tags.

    Returns
    -------
    str
        Another one when a vertex, a material or a tag changes.
    """
    bodies = []
    for body in built.scene.bodies:
        digest = hashlib.sha256(np.ascontiguousarray(body.vertices_m).tobytes())
        digest.update(np.ascontiguousarray(body.faces).tobytes())
        bodies.append([body.material, digest.hexdigest()])
    tags = [
        [tag.id, tag.position_m.tolist(), *_antenna_inputs(a)]
        for tag in built.tags
        for a in tag.antennas
    ]
    radios = [[r.frequency_hz, [asdict(m) for m in r.materials]] for r in built.radios]
    return content_hash(
        {
            "bodies": bodies,
            "tags": tags,
            "radios": radios,
            "heights_m": [built.reader_z_m, built.map_z_m],
        }
    )


def _antenna_inputs(antenna: Antenna) -> list[object]:
    table = b"" if antenna.pattern is None else antenna.pattern.tobytes()
    turn = [antenna.axis.tolist(), antenna.azimuth_rad]
    size = [antenna.frequency_hz, antenna.length_m]
    return [antenna.kind, *size, *turn, hashlib.sha256(table).hexdigest()]


def cell_key(context: SweepContext, design: Reader, *, fingerprint: str) -> str:
    """Return the name of a cell: the hash of its full input, 64 hexadecimal digits.

    Parameters
    ----------
    context : SweepContext
        Study and sampling.
    design : Reader
        The design.
    fingerprint : str
        From :func:`scene_fingerprint`, computed once for all cells.

    Returns
    -------
    str
        The same on every machine with this version of Octant.
    """
    study = context.study
    tag = reference_tag(study, context.built).id if context.built.tags else ""
    return content_hash(
        {
            "format": CELL_FORMAT,
            "octant": versions()["octant_version"],
            "design": design.as_dict(),
            **response_inputs(study),
            "frequencies_hz": list(study.radio.frequencies_hz),
            "tag_power_w": study.radio.tag_power_w,
            "solver": msgspec.to_builtins(study.solver),
            "reference_tag": tag,
            "scene": fingerprint,
            "sampling": asdict(context.sampling),
            "scoring": msgspec.to_builtins(study.scoring),
            "seed": study.seed,
            "usable_dbm": context.usable_dbm,
        }
    )


def refused_key(study: Study) -> str:
    """Return the name of a cell whose study contradicts itself, so that nothing can be built.

    Parameters
    ----------
    study : Study
        The study, not checked.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    tables = msgspec.to_builtins(study)
    return content_hash(
        {
            "format": CELL_FORMAT,
            "octant": versions()["octant_version"],
            "refused": {name: tables[name] for name in SWEPT_TABLES},
        }
    )
