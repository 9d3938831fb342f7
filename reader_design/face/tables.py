"""A table of the study file as an object of Python, and studies put together from such objects."""

import inspect
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Self

import msgspec
import numpy as np

from octant.geometries.errors import ConfigError
from octant.reader_design.face.shown import text_html
from octant.reader_design.study_file.loading import study_of_tables
from octant.reader_design.study_file.room import Table
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.schema import Tag as TagTable

EMPTY_ROOM: Mapping[str, Any] = {"free_space": True}


def plain(value: Any) -> Any:  # noqa: ANN401  any tree of values
    """Return a value as the study file's reader takes it: text, numbers, lists and dicts.

    Parameters
    ----------
    value : Also arrays, paths and objects of the face.
    """
    if isinstance(value, StudyTable | Table):
        return given_keys(value.table if isinstance(value, StudyTable) else value)
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def given_keys(table: Table) -> dict[str, Any]:
    """Return the keys of a table that are not at their default, as the study file writes them.

    Parameters
    ----------
    table : Any table of a study.
    """
    shown: dict[str, Any] = {}
    tag = type(table).__struct_config__
    if tag.tag_field is not None:
        shown[tag.tag_field] = tag.tag
    for field in msgspec.structs.fields(table):
        value = getattr(table, field.name)
        default = field.default
        if field.default_factory is not msgspec.NODEFAULT:
            default = field.default_factory()
        if value is not None and value != default:
            shown[field.encode_name] = plain(value)
    return shown


def study_from(source: str, tables: Mapping[str, Any]) -> Study:
    """Return the study of tables, checked as a study file is; files lie below the working folder.

    Parameters
    ----------
    source, tables : What is made, for messages; tables by their names, None is left out.
    """
    raw = {"room": EMPTY_ROOM, **{k: v for k, v in tables.items() if v is not None}}
    return study_of_tables(plain(raw), source=source, directory=Path.cwd())


def solver_keys(
    solver: Mapping[str, Any] | None, *, max_reflections: int | None
) -> dict[str, Any] | None:
    """Return the table ``[solver]`` of a call that may name the highest order by itself.

    Parameters
    ----------
    solver, max_reflections : Keys of ``[solver]``, and the order in place of theirs.
    """
    keys = dict(solver or {})
    if max_reflections is not None:
        keys["max_reflections"] = max_reflections
    return keys or None


class StudyTable:
    """A table of the study file, checked; its keys are arguments and attributes."""

    __slots__ = ("table",)
    table: Any
    _kind: ClassVar[type[Table]]

    @classmethod
    def of(cls, table: Table) -> Self:
        """Return the object of a table that has been checked.

        Parameters
        ----------
        table : For example the room of a loaded study.
        """
        made = cls.__new__(cls)
        made.table = table
        return made

    def replaced(self, changes: Mapping[str, Any]) -> Self:
        """Return the same with other values of some keys.

        Parameters
        ----------
        changes : Value by key, in the unit that the key names ([m], [Hz], ...).
        """
        return type(self)(**{**given_keys(self.table), **changes})

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  a key of the table
        if name.startswith("__") or name == "table":
            raise AttributeError(name)
        return getattr(self.table, name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.table.__struct_fields__})

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.table == getattr(other, "table", None)

    def __hash__(self) -> int:
        return hash((type(self), repr(self.table)))

    def __repr__(self) -> str:
        keys = ", ".join(f"{key}={value!r}" for key, value in given_keys(self.table).items())
        return f"{type(self).__name__}({keys})"

    def _repr_html_(self) -> str:
        return text_html(repr(self))


def with_keys_of(table: type[Table]) -> Any:  # noqa: ANN401  a decorator of classes
    """Return a decorator that gives a class the signature and the description of a table's keys.

    Parameters
    ----------
    table : A table of the study file.
    """

    def decorated(face: Any) -> Any:  # noqa: ANN401
        described = inspect.cleandoc(table.__doc__ or "").partition("\nParameters\n")
        doc = inspect.cleandoc(face.__doc__)
        if "\nParameters\n" not in doc and described[1]:
            text, mark, example = doc.partition("\nExamples\n")
            keys = f"Parameters\n{described[2].rstrip()}"
            face.__doc__ = f"{text.rstrip()}\n\n{keys}\n\n{mark.lstrip()}{example}"
        if not hasattr(face, "__signature__"):
            face.__signature__ = inspect.signature(table)
        return face

    return decorated


class Tag(StudyTable):
    """One RFID tag.

    Parameters
    ----------
    id, position_m : Its name, and its place in the room's frame, (3,) [m].
    antenna : ``dipole``, ``monopole``, ``patch``, ``conical_patch``, ``isotropic_theta`` or a
        pattern file.
    axis, azimuth_deg : Its antenna's axis (by default up, patches down) and turn about it [deg].
    power_w : Power that an active tag radiates [W].
    **woken : ``kind`` and its further keys in ``[[tag]]`` [dB], [dBm].

    Examples
    --------
    >>> import octant
    >>> tag = octant.Tag("0xFFF9", (2.0, 0.5, 2.95), antenna="dipole", power_w=1.0)
    >>> tag.position_m
    (2.0, 0.5, 2.95)
    """

    __slots__ = ("power_w",)
    power_w: float
    _kind = TagTable

    def __init__(
        self,
        id: str,  # noqa: A002  the study file's own key
        position_m: Sequence[float],
        *,
        antenna: str = "conical_patch",
        axis: Sequence[float] | None = None,
        azimuth_deg: float = 0.0,
        power_w: float = 1.0,
        **woken: Any,  # noqa: ANN401  keys of [[tag]]
    ) -> None:
        keys = {
            "id": id,
            "position_m": position_m,
            "antenna": antenna,
            "axis": axis,
            "azimuth_deg": azimuth_deg,
            **woken,
        }
        tables: dict[str, Any] = {"tag": [keys], "radio": {"tag_power_w": power_w}}
        if woken.get("kind", "active") != "active":
            tables["rfid"] = {"power_w": 1.0}  # of the study that the tag will be in
        study = study_from("Tag", tables)
        self.table = study.tags[0]
        self.power_w = study.radio.tag_power_w

    @classmethod
    def of(cls, table: Table, *, power_w: float = 1.0) -> Self:
        """Return the tag of a study, which radiates ``power_w`` [W]."""
        made = super().of(table)
        made.power_w = power_w
        return made

    def replaced(self, changes: Mapping[str, Any]) -> Self:
        """Return the same tag with other values of some keys, or of ``power_w`` [W]."""
        return type(self)(**{"power_w": self.power_w, **given_keys(self.table), **changes})

    def __repr__(self) -> str:
        return f"Tag({self.id!r}, {self.position_m}, antenna={self.antenna!r})"


def radio_keys(
    tags: Sequence[Tag], *, frequency_hz: float, channels_hz: Sequence[float] = ()
) -> dict[str, Any]:
    """Return the table ``[radio]`` for tags; refuse tags of different powers.

    Parameters
    ----------
    tags : The tags.
    frequency_hz, channels_hz : Carrier and hopping frequencies [Hz].
    """
    powers = sorted({tag.power_w for tag in tags})
    if len(powers) > 1:
        shown = ", ".join(f"{p:g}" for p in powers)
        msg = (
            f"the tags radiate {shown} W, but the tags of one call need the same power_w; compute "
            "them in separate calls."
        )
        raise ConfigError(msg)
    return {
        "frequency_hz": frequency_hz,
        "channels_hz": channels_hz,
        "tag_power_w": powers[0] if powers else 1.0,
    }


def refuse_unlike(name: str, value: Any, kind: type, *, example: str) -> None:  # noqa: ANN401
    """Refuse an argument that is not of the kind that is needed.

    Parameters
    ----------
    name, value : Of the argument.
    kind, example : What is needed, and how to make one.
    """
    if not isinstance(value, kind):
        msg = (
            f"{name} is a {type(value).__name__}, but an octant.{kind.__name__} is needed; "
            f"give for example {example}."
        )
        raise ConfigError(msg)
