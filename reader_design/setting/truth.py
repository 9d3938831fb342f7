"""The world of a study's missions where it is not what the study says: table ``[truth]``."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.medium.radio_scene import RadioScene
from octant.geometries.errors import ConfigError, GeometryError
from octant.navigation.missions.starts import Carried, RandomStarts
from octant.navigation.robot.floor import RobotSpace
from octant.navigation.sensing.erring import ErringLink
from octant.navigation.sensing.sensor import PowerLink
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.schema import Layout, Study, Tag
from octant.reader_design.study_file.truth import Truth

FloatArray = npt.NDArray[np.float64]

_DRAWS = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """A drawn world.

    Parameters
    ----------
    setting : The true room, tags and robot [m].
    level_db : Level of every tag over what the study says [dB].
    gain_db : (n,) float64 — Gain of every antenna over that [dB].
    kidnapped_at_s : When the robot is carried elsewhere [s]; None: never.
    noise_db : Noise of each reading [dB]; None: as the study's mission has it.
    """

    setting: Setting
    level_db: Mapping[str, float]
    gain_db: FloatArray
    kidnapped_at_s: float | None
    noise_db: float | None = None

    def erring(self, links: Mapping[str, PowerLink]) -> dict[str, PowerLink]:
        """Return links with the true levels and gains.

        Parameters
        ----------
        links : Of the true room, by tag.
        """
        return {
            name: ErringLink(
                link=link, factor=10.0 ** ((self.level_db[name] + self.gain_db) / 10.0)
            )
            for name, link in links.items()
        }

    def carried(self, space: RobotSpace) -> Carried | None:
        """Return when the robot is carried and where to; None: never.

        Parameters
        ----------
        space : Where it can stand.
        """
        if self.kidnapped_at_s is None:
            return None
        low, high = space.scene.bounds_m[:, :2]
        return Carried(
            at_s=self.kidnapped_at_s, to=RandomStarts(low_m=low, high_m=high, fits=space)
        )


def true_world(setting: Setting, rng: np.random.Generator) -> World:
    """Return the world of a study's table ``[truth]``.

    Tags are drawn again where one would hang outside the room or in an object.

    Parameters
    ----------
    setting : The room that navigators are told [m].
    rng : Source of all that is drawn.
    """
    truth = setting.study.truth or Truth()
    problem: Exception | None = None
    for _ in range(_DRAWS):
        study = _true_study(setting.study, truth, rng)
        layout = setting.layout
        if layout is not None:
            layout = msgspec.structs.replace(layout, objects=layout.objects + truth.objects)
        try:
            found = _built(study, layout, setting, truth)
        except (ConfigError, GeometryError) as exc:
            if truth.tag_sd_m == 0.0:
                msg = f"[truth]: {exc}"
                raise ConfigError(msg) from exc
            problem = exc
            continue
        return World(
            setting=found,
            level_db={t.id: float(rng.normal(0.0, truth.tag_level_sd_db)) for t in study.tags},
            gain_db=rng.normal(0.0, truth.antenna_gain_sd_db, found.responses[0].antennas),
            kidnapped_at_s=truth.kidnapped_at_s,
            noise_db=truth.noise_db,
        )
    msg = (
        f"truth.tag_sd_m is {truth.tag_sd_m:g} m, but in {_DRAWS} draws a tag was always misplaced "
        f"({problem}); choose less."
    )
    raise ConfigError(msg)


def _true_study(study: Study, truth: Truth, rng: np.random.Generator) -> Study:
    solver = msgspec.structs.replace(
        study.solver,
        max_reflections=_first(truth.max_reflections, study.solver.max_reflections),
        diffraction=_first(truth.diffraction, study.solver.diffraction),
    )
    reader = msgspec.structs.replace(
        study.reader, height_m=study.reader.height_m + truth.reader_height_error_m
    )
    robot = msgspec.structs.replace(
        study.robot,
        wheel_slip=_first(truth.wheel_slip, study.robot.wheel_slip),
        wheel_scale=_first(truth.wheel_scale, study.robot.wheel_scale),
    )
    mission = study.mission
    if mission is not None:
        mission = msgspec.structs.replace(
            mission,
            wheel_slip=_first(truth.wheel_slip, mission.wheel_slip),
            wheel_scale=_first(truth.wheel_scale, mission.wheel_scale),
        )
    room = msgspec.structs.replace(study.room, objects=study.room.objects + truth.objects)
    return msgspec.structs.replace(
        study,
        solver=solver,
        reader=reader,
        robot=robot,
        mission=mission,
        room=room,
        tags=tuple(_true_tag(tag, truth, rng) for tag in study.tags),
    )


def _true_tag(tag: Tag, truth: Truth, rng: np.random.Generator) -> Tag:
    x, y, z = (float(c) for c in tag.position_m + truth.tag_sd_m * rng.standard_normal(3))
    side, lean = rng.uniform(0.0, 2.0 * math.pi), float(rng.standard_normal())
    axis = tag.axis
    if truth.tag_tilt_sd_deg is not None:
        angle = math.radians(truth.tag_tilt_sd_deg) * lean
        axis = _leaning(tag, angle, side)
    return msgspec.structs.replace(tag, position_m=(x, y, z), axis=axis)


def _leaning(tag: Tag, angle_rad: float, side_rad: float) -> tuple[float, float, float]:
    """Return the axis of a tag, leant by an angle to a side [-]."""
    axis = np.array(tag.axis or (0.0, 0.0, -1.0))
    axis /= np.linalg.norm(axis)
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    across /= np.linalg.norm(across)
    towards = math.cos(side_rad) * across + math.sin(side_rad) * np.cross(axis, across)
    x, y, z = math.cos(angle_rad) * axis + math.sin(angle_rad) * towards
    return float(x), float(y), float(z)


def _first(given: float | None, otherwise: float | None) -> float | None:
    return otherwise if given is None else given


def _built(study: Study, layout: Layout | None, told: Setting, truth: Truth) -> Setting:
    found = build_setting(study, layout, sampling=told.sampling)
    if truth.permittivity_factor != 1.0:
        radios = tuple(_scaled(radio, truth.permittivity_factor) for radio in found.radios)
        found = replace(found, radios=radios)
    return found.with_responses(told.responses)


def _scaled(radio: RadioScene, factor: float) -> RadioScene:
    eps = radio.layer_permittivity
    return replace(radio, layer_permittivity=factor * eps.real + 1j * eps.imag)
