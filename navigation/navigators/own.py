"""A navigator of the user's own: a class with ``step``, and what lets missions drive with it."""

import inspect
import math
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import ConfigError
from octant.navigation.navigators.interface import Decision, Mode, Odometry
from octant.navigation.navigators.loading import (
    class_place,
    is_file,
    load_class,
    source_files,
)
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.pattern_match import PowerTable

FloatArray = npt.NDArray[np.float64]

_MOST_RATE = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """What a navigator is told before a run: its task, its reader, its robot; no tag's place.

    Parameters
    ----------
    tag_ids : Names of the tags, in the order in which they are to be reached.
    heading_rad : Heading at the mission's start [rad].
    azimuths_rad : (n,) float64 — Azimuth of each antenna against the robot's front [rad], to the
        left positive.
    period_s : From one reading to the next [s].
    cruise_step_m : Distance driven straight ahead in one period [m].
    arrival_radius_m : How near the tag's point on the floor it should find that it is there [m].
    robot : Wheels, axle and limits.
    tables : What the reader receives around each tag in the open, in their order [W].
    """

    tag_ids: tuple[str, ...]
    heading_rad: float
    azimuths_rad: FloatArray
    period_s: float
    cruise_step_m: float
    arrival_radius_m: float
    robot: DifferentialDrive
    tables: tuple[PowerTable, ...] = ()

    def __post_init__(self) -> None:
        azimuths = frozen_array(self.azimuths_rad, name="azimuths_rad", shape=(None,))
        object.__setattr__(self, "azimuths_rad", azimuths)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """One reading of the tag that is to be reached.

    Parameters
    ----------
    rss_w : (n,) float64 — RSS of each antenna; 0 where nothing was received [W].
    tag_id, target : Name of the tag, and its place in the order.
    first : Whether it is the first reading of this tag.
    rng : Source of random numbers, the same again in the same run.

    Examples
    --------
    >>> import numpy as np, octant
    >>> reading = octant.Reading(
    ...     rss_w=np.array([1e-9, 0.0]), tag_id="A", target=0, first=True,
    ...     rng=np.random.default_rng(1),
    ... )
    >>> reading.rss_dbm
    array([-60., -inf])
    """

    rss_w: FloatArray
    tag_id: str
    target: int
    first: bool
    rng: np.random.Generator

    @property
    def rss_dbm(self) -> FloatArray:
        """RSS of each antenna; minus infinity where nothing was received [dBm]."""
        with np.errstate(divide="ignore"):
            return np.asarray(10.0 * np.log10(self.rss_w) + 30.0)

    def bearing_rad(self, azimuths_rad: npt.ArrayLike) -> float:
        """Return the direction of the vector sum of all antennas against the front [rad].

        Parameters
        ----------
        azimuths_rad : (n,) array_like — Of `Told` [rad].
        """
        total = complex(self.rss_w @ np.exp(1j * np.asarray(azimuths_rad, dtype=np.float64)))
        return math.atan2(total.imag, total.real)


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """What the robot does until the next reading; more than its wheels can is cut.

    Parameters
    ----------
    speed_m_per_s, turn_rate_rad_per_s : Forward speed [m/s]; turn, to the left positive [rad/s].
    reached : The robot is at the tag; it stops, and the next tag is read.
    mode : ``rotation``, ``navigation``, ``search``, ``evade`` or ``stopped``, for the record; None:
        rotation on the spot, else navigation.
    place_m : (2,) sequence of float — Where the tag is believed, ahead and to the left [m], for the
        record; None: nowhere.

    Examples
    --------
    >>> import octant
    >>> octant.Command(speed_m_per_s=0.09, turn_rate_rad_per_s=0.2).reached
    False
    """

    speed_m_per_s: float = 0.0
    turn_rate_rad_per_s: float = 0.0
    reached: bool = False
    mode: Mode | None = None
    place_m: npt.ArrayLike | None = None


class Navigator(ABC):
    """The base of a navigator of one's own, which is made anew for each run.

    ``step`` is called once a period with a reading of the current tag and with the robot's own
    motion since the one before, and says what the robot does. What it remembers it keeps in
    ``self``. ``self.told`` holds what it is told before the run. A study names it as
    ``navigator = "my_file.py:MyClass"`` (beside the study file), ``"package.module:MyClass"``, or
    by its name in the entry-point group ``octant.navigators``; `Mission` takes the class itself.
    A class without this base will do if it has ``step``, and ``reset`` if it wants to be told.

    Examples
    --------
    >>> import octant
    >>> class Ahead(octant.Navigator):
    ...     def step(self, reading, odometry):
    ...         return octant.Command(speed_m_per_s=self.told.cruise_step_m / self.told.period_s)
    """

    told: Told

    def reset(self, told: Told) -> None:
        """Begin a run.

        Parameters
        ----------
        told : Kept as ``self.told``.
        """
        self.told = told

    @abstractmethod
    def step(self, reading: Reading, odometry: Odometry) -> Command:
        """Return what the robot does until the next reading.

        Parameters
        ----------
        reading, odometry : RSS of the current tag; the robot's motion since the last reading.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class NavigatorPlace:
    """A class of the user's own and where it stands.

    Parameters
    ----------
    where, class_name : File ending in .py by absolute path, or module; the class in it.
    files : Source files of the class and of those it is derived from: their content tells whether
        a run that is kept is this class's.
    """

    where: str
    class_name: str
    files: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The class as a person would name it."""
        where = Path(self.where).name if is_file(self.where) else self.where
        return f"{where}:{self.class_name}"


def find_navigator(text: str) -> NavigatorPlace:
    """Return where a navigator of the user's own stands; refuse one that missions cannot use.

    Parameters
    ----------
    text : ``FILE.py:Class``, ``package.module:Class``, or the name of an entry point.
    """
    where, name = class_place(text)
    place = NavigatorPlace(where=where, class_name=name)
    kind = load_class(where, name)
    check_navigator_class(kind, place.name)
    return replace(place, files=source_files(kind))


def place_of(kind: type) -> NavigatorPlace:
    """Return where a class that is given itself stands; refuse one that missions cannot use.

    Parameters
    ----------
    kind : The class.
    """
    name = getattr(kind, "__qualname__", type(kind).__name__)
    place = NavigatorPlace(where=getattr(kind, "__module__", "python"), class_name=name)
    check_navigator_class(kind, place.name)
    return replace(place, files=source_files(kind))


@dataclass(slots=True)
class OwnMemory:
    """A navigator of the user's own in the middle of a run.

    Parameters
    ----------
    navigator, target, first : The object; the current tag; whether it has not been read yet.
    """

    navigator: Any
    target: int
    first: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnNavigator:
    """Drives a mission with a class of the user's own, a new object for each run.

    Parameters
    ----------
    place : Where the class is found; its files count in what is kept.
    told : What it is told.
    kind : The class, where it is given itself; None: it is loaded from its place.
    """

    place: NavigatorPlace
    told: Told
    kind: type | None = None

    def begin(self, target: int, before: OwnMemory | None, *, heading_rad: float) -> OwnMemory:
        """Return what is remembered for the first reading of a leg."""
        if before is not None:
            return replace(before, target=target, first=True)
        kind = self.kind or load_class(self.place.where, self.place.class_name)
        navigator = self._called("__init__", kind)
        if hasattr(navigator, "reset"):
            told = replace(self.told, heading_rad=heading_rad)
            self._called("reset", navigator.reset, told)
        return OwnMemory(navigator=navigator, target=target)

    def decide(
        self,
        memory: OwnMemory,
        rss_w: FloatArray,
        odometry: Odometry,
        rng: np.random.Generator,
    ) -> Decision[OwnMemory]:
        """Return the command for the coming period, or that the tag is reached."""
        reading = Reading(
            rss_w=rss_w,
            tag_id=self.told.tag_ids[memory.target],
            target=memory.target,
            first=memory.first,
            rng=rng,
        )
        command = self._called("step", memory.navigator.step, reading, odometry)
        rates, mode = self._rates(command)
        return Decision(
            rates=rates,
            memory=replace(memory, first=False),
            reached=bool(command.reached),
            mode=mode,
            place_m=command.place_m,
        )

    def _rates(self, command: object) -> tuple[FloatArray, Mode]:
        """Return wheel rates [rad/s] and mode of a command; refuse what is none."""
        if not isinstance(command, Command):
            msg = (
                f"the navigator {self.place.name} returned {command!r:.60} from step, but an "
                "octant.Command is needed, such as Command(speed_m_per_s=0.09)."
            )
            raise ConfigError(msg)
        speed, turn = command.speed_m_per_s, command.turn_rate_rad_per_s
        try:
            sound = abs(float(speed)) < _MOST_RATE and abs(float(turn)) < _MOST_RATE
        except (TypeError, ValueError):
            sound = False
        if not sound:
            msg = (
                f"the navigator {self.place.name} commands {speed!r} m/s and {turn!r} rad/s, but "
                "finite numbers are needed."
            )
            raise ConfigError(msg)
        if command.reached:
            return np.zeros(2), "stopped"
        robot = self.told.robot
        wanted = robot.wheel_rates(speed_m_per_s=float(speed), turn_rate_rad_per_s=float(turn))
        mode: Mode = "rotation" if speed == 0.0 and turn != 0.0 else "navigation"
        return robot.saturate(wanted), command.mode or mode

    def _called(self, method: str, function: Callable[..., Any], *given: object) -> Any:  # noqa: ANN401
        """Return what the user's code returns; its exceptions become one sentence with the line."""
        try:
            return function(*given)
        except Exception as exc:
            raise failed_sentence(self.place.name, method, self.place.files, exc) from exc


def failed_sentence(name: str, method: str, files: tuple[str, ...], exc: Exception) -> ConfigError:
    """Return the error that says where a navigator of the user's own failed.

    Parameters
    ----------
    name, method, files, exc : Of the class; what was called; its source files; what it raised.
    """
    frames = traceback.extract_tb(exc.__traceback__)
    own = [frame for frame in frames if frame.filename in files]
    where = (own or frames)[-1]
    what = f"{type(exc).__name__}: {exc}".rstrip(": .").replace("\n", " ")
    msg = (
        f"the navigator {name} failed in {method} ({Path(where.filename).name}, line "
        f"{where.lineno}): {what}; correct it there."
    )
    return ConfigError(msg)


def check_navigator_class(kind: object, name: str) -> None:
    """Refuse what missions cannot drive with: no class, no ``step``, other arguments.

    Parameters
    ----------
    kind, name : What was found, and its name in messages.
    """
    how = "write class Mine(octant.Navigator) with def step(self, reading, odometry)"
    if not inspect.isclass(kind):
        msg = f"the navigator {name} is {kind!r:.40}, but a class is needed: {how}."
        raise ConfigError(msg)
    step = getattr(kind, "step", None)
    if not callable(step) or step is Navigator.step:
        msg = f"the navigator {name} has no step of its own; {how}."
        raise ConfigError(msg)
    calls: list[tuple[str, Callable[..., Any], tuple[None, ...]]] = [
        ("", kind, ()),
        ("step", step, (None, None, None)),
    ]
    if hasattr(kind, "reset"):
        calls.append(("reset", kind.reset, (None, None)))
    for method, function, given in calls:
        try:
            signature = inspect.signature(function)
            signature.bind(*given)
        except ValueError:  # as of a class written in C
            continue
        except TypeError as exc:
            wanted = {"": "no argument", "step": "(self, reading, odometry)"}.get(
                method, "(self, told)"
            )
            msg = (
                f"the navigator {name}{'.' if method else ''}{method} takes {signature}, but it "
                f"is called with {wanted}; {how}."
            )
            raise ConfigError(msg) from exc
