"""The study file as typed, frozen tables: one class per TOML table, every key with its unit.

Only shape and single-value rules stand here; what one key demands of another is in `checks`, what
only the finished room can tell (a tag outside it) in `octant.reader_design.setting.setting`.
"""

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from octant.reader_design.study_file.calibration import Calibration
from octant.reader_design.study_file.choice import Choice, Scoring
from octant.reader_design.study_file.dock import Dock
from octant.reader_design.study_file.log import Log
from octant.reader_design.study_file.mission import Mission
from octant.reader_design.study_file.optimise import Optimise
from octant.reader_design.study_file.quantities import (
    Angle,
    Deviation,
    Direction,
    Distance,
    FileName,
    Frequency,
    Level,
    Name,
    Point,
    Power,
    Seed,
    ShareLost,
    Step,
    Swept,
    Word,
)
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.rfid import Rfid
from octant.reader_design.study_file.robot import Robot
from octant.reader_design.study_file.room import Room, RoomObject, Table
from octant.reader_design.study_file.sensor import Sensor
from octant.reader_design.study_file.tolerance import Tolerance
from octant.reader_design.study_file.track import Track
from octant.reader_design.study_file.truth import Truth


class Radio(Table, frozen=True, kw_only=True):
    """Frequency and power: table ``[radio]``.

    Parameters
    ----------
    frequency_hz : Carrier frequency [Hz].
    channels_hz : Hopping frequencies [Hz]; where given, RSS is the mean power over them.
    tag_power_w : Power [W] that an active tag radiates.
    """

    frequency_hz: Frequency = 2.4e9
    channels_hz: Annotated[tuple[Frequency, ...], Meta(max_length=1000)] = ()
    tag_power_w: Power = 1.0

    @property
    def frequencies_hz(self) -> tuple[float, ...]:
        """Frequencies over which RSS is averaged in power [Hz]: the channels, or the carrier."""
        return self.channels_hz or (self.frequency_hz,)


class Tag(Table, frozen=True, kw_only=True):
    """One RFID tag: ``[[tag]]``.

    Parameters
    ----------
    id : Name that missions use.
    position_m : (3,) tuple of float — Place in the room's frame [m].
    antenna : ``dipole`` (half a wave), ``monopole`` (quarter wave), ``patch`` (half a wave square),
        ``conical_patch`` (a disc whose beam is a cone of vertical polarisation) or
        ``isotropic_theta``; or a pattern file over the full sphere (FEKO .ffe, HFSS .ffd, CST .ffs,
        NEC output, MSI/Planet, CSV).
    axis : (3,) tuple of float or None — Direction of the antenna's axis, of any length but zero:
        along the wire, where the patch faces, the file's z axis. None: up, patches down.
    azimuth_deg : Turn of a patch or a file about the axis [deg]; at 0 the patch's resonant side and
        the file's x axis point along +x, as far as that is across the axis.
    kind : ``active`` tags send by themselves; ``passive`` ones live on the reader's wave,
        ``semi_passive`` ones have a battery for the chip only: both answer by backscatter where the
        reader wakes them, see ``[rfid]``. The further keys are for these.
    sensitivity_dbm : Power at the chip [dBm] from which it works; None: -18 of a passive one, -31
        of a semi-passive one.
    mismatch_loss_db : Loss [dB] of the antenna's power on its way into the chip, 1 - |Γ|².
    modulation_loss_db : Loss [dB] of the modulation, |Γ1 - Γ2|²/4 of the chip's two states; 6 where
        it is matched in one and shorted in the other. The differential radar cross section is
        λ² G²/(4π) times it.
    backscatter_loss_db : Further loss [dB] of what the tag sends back.
    polarisation_loss_db : Loss [dB] each way besides what follows from both antennas' fields.
    """

    id: Name
    position_m: Point
    antenna: FileName = "conical_patch"
    axis: Direction | None = None
    azimuth_deg: Angle = 0.0
    kind: Literal["active", "semi_passive", "passive"] = "active"
    sensitivity_dbm: Level | None = None
    mismatch_loss_db: Deviation = 0.0
    modulation_loss_db: Deviation = 6.0
    backscatter_loss_db: Deviation = 0.0
    polarisation_loss_db: Deviation = 0.0


class Range(Table, frozen=True, kw_only=True):
    """Evenly spaced values of a swept parameter, ends included: ``{from = 0.05, to = 0.12, ...}``.

    Parameters
    ----------
    low, high : First and last value, in the parameter's unit: the keys ``from`` and ``to``. They
        may descend.
    count : Number of values; instead of ``step``.
    step : Distance of neighbouring values, in the parameter's unit, above 0; the last value is
        ``to`` only where a whole number of steps leads there.
    """

    low: Swept = msgspec.field(name="from")
    high: Swept = msgspec.field(name="to")
    count: Annotated[int, Meta(ge=2, le=10_000)] | None = None
    step: Step | None = None


Sweep = dict[Word, tuple[Any, ...] | Range]
"""The design space: table ``[sweep]``; every combination of its values is one study.

A name is a key of ``[reader]``, or the dotted path of any key of ``[radio]``, ``[room]``,
``[[tag]]``, ``[reader]``, ``[solver]`` and ``[rfid]`` in quotes: see
`octant.reader_design.study_file.sweep`.
"""


class Solver(Table, frozen=True, kw_only=True):
    """What the room's radio model includes: table ``[solver]``.

    Parameters
    ----------
    max_reflections : Highest number of bends of a path: reflections, and diffractions where there
        are any.
    diffraction : Whether edges diffract.
    max_diffractions : Diffractions of a path: 1, or 2 for those over both edges of one face, or
        two edges in sight of each other, as well.
    transmission : Whether sheets with a thickness let waves through.
    search : ``complete`` finds every path; ``rays`` launches rays, for meshes of very many
        triangles.
    rays : Rays launched by ``rays`` at first.
    ray_tolerance_db : By how much the mean power over the room may be too low, because rays have
        not found all paths: more rays are launched until, with 95 % confidence, it is not [dB].
    faces : ``flat`` counts triangles as one face where rounding of single-precision coordinates
        explains what keeps them from being flat; ``as_stored`` only where they are flat exactly.
    standoff_m : How far an antenna that lies on a surface is moved off it, along the normal [m].
    """

    max_reflections: Annotated[int, Meta(ge=0, le=12)] = 3
    diffraction: bool = False
    max_diffractions: Literal[1, 2] = 1
    transmission: bool = False
    search: Literal["complete", "rays"] = "complete"
    rays: Annotated[int, Meta(ge=8, le=100_000_000)] = 1_000_000
    ray_tolerance_db: ShareLost = 0.1
    faces: Literal["flat", "as_stored"] = "flat"
    standoff_m: Distance = 0.05


class Map(Table, frozen=True, kw_only=True):
    """The grid of radio maps: table ``[map]``.

    Parameters
    ----------
    spacing_m : Distance of neighbouring receivers [m].
    height_m : Height of the receivers above the floor [m]; None: the reader's ground plane.
    margin_m : How far a map of free space reaches beyond the tags and the start [m].
    """

    spacing_m: Distance = 0.1
    height_m: Distance | None = None
    margin_m: Distance = 1.0


class Layout(Table, frozen=True, kw_only=True):
    """A further room in which the chosen reader is evaluated: ``[[layout]]``.

    Parameters
    ----------
    name : Name in the results.
    room : The room; None: the study's own.
    values : Other values there of keys of ``[radio]``, ``[[tag]]``, ``[mission]``, ``[robot]``,
        ``[sensor]``, ``[solver]`` and ``[rfid]``, by dotted paths in quotes, such as
        ``"mission.navigator" = "thesis"``; ``"tag.antenna"`` is that of every tag, which hangs as
        usual.
    objects : Objects that stand there besides the room's own: the tables ``[[layout.object]]``.
    """

    name: Name
    room: Room | None = None
    values: dict[Word, Any] = {}  # noqa: RUF012  msgspec gives every layout a table of its own
    objects: tuple[RoomObject, ...] = msgspec.field(default=(), name="object")


class Report(Table, frozen=True, kw_only=True):
    """What the report of a study holds besides its results: table ``[report]``.

    Parameters
    ----------
    thesis : Whether the claims of the thesis about its designs are held against the results, where
        the sweep varies what the thesis varies.
    """

    thesis: bool = False


class Study(Table, frozen=True, kw_only=True):
    """A whole study: the root of the study file.

    Parameters
    ----------
    name : Name in the report.
    seed : Seed of every random number.
    radio, room, reader, sweep, solver, map : What is studied, see the classes of these names (all
        units SI, angles in [deg]).
    tags : The tables ``[[tag]]``.
    scoring : The receiver whose readings are scored beside the exact RSS.
    choice : By which scores a reader is chosen.
    mission : None: the study drives no robot.
    robot : The robot of missions, tracking and docking.
    sensor : How the robot's reader measures on missions.
    track : Trajectory tracking from RSS; None: the study has none.
    dock : Docking at a tagged station; None: the study has none.
    optimise : The search for a reader design; None: the study has none.
    tolerance : How exactly readers are made; None: the defaults.
    layouts : The tables ``[[layout]]``.
    rfid : How the reader wakes and inventories tags; None: all tags are active.
    report : What the report holds besides the results.
    truth : How the world of missions differs from all this; None: not at all.
    calibration : What measurements add to computed levels; None: nothing.
    log : Where measured readings are, and how to read them; None: nowhere.
    """

    name: Name = "study"
    seed: Seed = 1
    radio: Radio = Radio()
    room: Room
    tags: tuple[Tag, ...] = msgspec.field(default=(), name="tag")
    reader: Reader = Reader()
    sweep: Sweep = {}  # noqa: RUF012  msgspec gives every study a table of its own
    scoring: Scoring = Scoring()
    choice: Choice = Choice()
    solver: Solver = Solver()
    map: Map = Map()
    mission: Mission | None = None
    robot: Robot = Robot()
    sensor: Sensor = Sensor()
    track: Track | None = None
    dock: Dock | None = None
    optimise: Optimise | None = None
    tolerance: Tolerance | None = None
    layouts: tuple[Layout, ...] = msgspec.field(default=(), name="layout")
    rfid: Rfid | None = None
    report: Report = Report()
    truth: Truth | None = None
    calibration: Calibration | None = None
    log: Log | None = None
