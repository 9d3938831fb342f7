"""The table ``[reader.feed]``: what lies between the reader's antennas and its receiver."""

from typing import Annotated

from msgspec import Meta

from octant.em.reader.feeding import Cable, Feeding, Multiplexer
from octant.em.reader.ladders import Ladder
from octant.geometries.errors import AntennaError, ConfigError
from octant.reader_design.study_file.quantities import (
    Deviation,
    DistanceOrZero,
    FileName,
    Frequency,
    Load,
    Ratio,
    Word,
)
from octant.reader_design.study_file.room import Table

Reactance = Annotated[float, Meta(ge=-1e6, le=1e6)]
OffResistance = Annotated[float, Meta(ge=0.0, le=1e6)]
Velocity = Annotated[float, Meta(ge=0.1, le=1.0)]
Quality = Annotated[float, Meta(ge=1.0, le=1e6)]


class ReaderFeed(Table, frozen=True, kw_only=True):
    """What lies between the antennas and their receiver: table ``[reader.feed]``.

    In this order from the antenna: a network of coils and capacitors, a two-port from a file, a
    cable, a multiplexer, the receiver. Applied by network algebra, without a new solution; full
    wave only. RSS is the power at the receiver, so that losses here lower it; the receiver's own
    noise is ``noise_figure_db`` of ``[sensor]``. Lists have one entry for all antennas or one each.

    Parameters
    ----------
    resistance_ohm : Resistance of the receiver [ohm]; empty: ``load_ohm`` of ``[reader]``.
    reactance_ohm : Reactance of the receiver [ohm]; empty: 0.
    load_file : Touchstone file that gives the receiver's impedance instead, of one port or of one
        for each antenna.
    match : Networks at the antennas, parts from the antenna to the receiver, such as
        ``0.82 pF across, 6.8 nH in series``; `octant reader` proposes them.
    coil_q, capacitor_q : Reactance over resistance of their parts [-]; None: without losses.
    network_files : Touchstone files of passive two-ports, first port towards the antenna.
    cable_m : Length of each antenna's cable [m].
    cable_loss_db_per_m : Its loss [dB/m] at ``cable_loss_at_hz``; it grows with the root of the
        frequency.
    cable_loss_at_hz : Frequency of that loss [Hz].
    cable_velocity : Speed of the cable's wave over that of light [-].
    cable_ohm : Its wave impedance [ohm].
    multiplexer_loss_db : Loss of a multiplexer's connected way [dB]; None: there is none, and each
        antenna has a receiver of its own.
    multiplexer_leakage_db : Level [dB] at which each antenna that is not connected reaches the
        receiver, in phase with the connected one; None: it does not.
    off_resistance_ohm, off_reactance_ohm : What the multiplexer ends the other antennas with [ohm];
        a resistance of 0 is a short, 1e6 is open.
    off_file : Touchstone file of one port that says it instead.
    """

    resistance_ohm: tuple[Load, ...] = ()
    reactance_ohm: tuple[Reactance, ...] = ()
    load_file: FileName | None = None
    match: tuple[Word, ...] = ()
    coil_q: Quality | None = None
    capacitor_q: Quality | None = None
    network_files: tuple[FileName, ...] = ()
    cable_m: DistanceOrZero = 0.0
    cable_loss_db_per_m: Deviation = 0.0
    cable_loss_at_hz: Frequency = 2.4e9
    cable_velocity: Velocity = 0.7
    cable_ohm: Load = 50.0
    multiplexer_loss_db: Deviation | None = None
    multiplexer_leakage_db: Ratio | None = None
    off_resistance_ohm: OffResistance = 50.0
    off_reactance_ohm: Reactance = 0.0
    off_file: FileName | None = None

    @property
    def files(self) -> tuple[str, ...]:
        """All files that are named."""
        return tuple(name for name in (self.load_file, *self.network_files, self.off_file) if name)

    def words(self) -> str:
        """Return what lies there in a few words, such as ``match, 0.5 m cable, multiplexer``."""
        named = (
            ("complex loads", bool(self.resistance_ohm or self.reactance_ohm or self.load_file)),
            ("matching networks", bool(self.match)),
            ("two-ports of files", bool(self.network_files)),
            (f"{self.cable_m:g} m of cable", self.cable_m > 0.0),
            ("a multiplexer", self.multiplexer_loss_db is not None),
        )
        return ", ".join(word for word, there in named if there)

    def feeding(self, load_ohm: float) -> Feeding:
        """Return it for the solver.

        Parameters
        ----------
        load_ohm : Resistance of the receiver where none is given here [ohm].
        """
        resistances, reactances = self.resistance_ohm or (load_ohm,), self.reactance_ohm or (0.0,)
        count = max(len(resistances), len(reactances))
        pairs = zip(
            resistances * (count // len(resistances)),
            reactances * (count // len(reactances)),
            strict=True,
        )
        infinite = float("inf")
        quality = {"coil": self.coil_q or infinite, "capacitor": self.capacitor_q or infinite}
        return Feeding(
            loads_ohm=tuple(complex(r, x) for r, x in pairs),
            load_file=self.load_file,
            ladders=tuple(Ladder.of_text(text).with_quality(**quality) for text in self.match),
            network_files=self.network_files,
            cable=self._cable(),
            multiplexer=self._multiplexer(),
        )

    def _cable(self) -> Cable | None:
        if self.cable_m == 0.0:
            return None
        return Cable(
            length_m=self.cable_m,
            loss_db_per_m=self.cable_loss_db_per_m,
            loss_at_hz=self.cable_loss_at_hz,
            velocity=self.cable_velocity,
            impedance_ohm=self.cable_ohm,
        )

    def _multiplexer(self) -> Multiplexer | None:
        if self.multiplexer_loss_db is None:
            return None
        return Multiplexer(
            loss_db=self.multiplexer_loss_db,
            leakage_db=self.multiplexer_leakage_db,
            off_ohm=complex(self.off_resistance_ohm, self.off_reactance_ohm),
            off_file=self.off_file,
        )


_OF_MULTIPLEXER = ("multiplexer_leakage_db", "off_resistance_ohm", "off_reactance_ohm", "off_file")


def check_feed(feed: ReaderFeed, *, antennas: int, response: str) -> None:
    """Refuse a feed that says what does not fit together.

    Parameters
    ----------
    feed : The table.
    antennas, response : ``antennas`` and ``response`` of ``[reader]``.
    """
    if response not in {"fullwave", "metal"}:
        msg = (
            f"reader.feed is given, but reader.response is {response!r}, whose antennas count as "
            'matched; set reader.response = "fullwave", or leave the table out.'
        )
        raise ConfigError(msg)
    for name in ("resistance_ohm", "reactance_ohm", "match", "network_files"):
        given = len(getattr(feed, name))
        if given not in {0, 1, antennas}:
            msg = (
                f"reader.feed.{name} has {given} entries, but the reader has {antennas} antennas; "
                "give one for all, or one for each in their order."
            )
            raise ConfigError(msg)
    if feed.load_file and (feed.resistance_ohm or feed.reactance_ohm):
        msg = (
            "reader.feed.load_file and resistance_ohm or reactance_ohm are both given, but the "
            "receiver has one impedance; give one of them."
        )
        raise ConfigError(msg)
    for i, text in enumerate(feed.match):
        try:
            Ladder.of_text(text)
        except AntennaError as exc:
            msg = f"reader.feed.match[{i}]: {exc}"
            raise ConfigError(msg) from exc
    default = ReaderFeed()
    if feed.multiplexer_loss_db is None:
        for name in _OF_MULTIPLEXER:
            if getattr(feed, name) != getattr(default, name):
                msg = (
                    f"reader.feed.{name} is given, but without reader.feed.multiplexer_loss_db "
                    "there is no multiplexer; give its loss, or leave the key out."
                )
                raise ConfigError(msg)
