"""Where a robot world's files lie: ``model://``, ``package://`` and relative names, safely."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from octant.geometries.errors import GeometryError
from octant.geometries.xml_files import URL, xml_root

ENVIRONMENT = (
    "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH", "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH", "ROS_PACKAGE_PATH",
)  # fmt: skip
"""Variables in which Gazebo and ROS keep lists of folders."""
LEVELS_UP = 3
"""How many folders above a world's its models are looked for [-]."""
_MODELS = ("models", "model", "Models", "fuel_models")
_SCHEMES = ("model://", "package://", "file://")


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldPlaces:
    """The folders that a world may read from, the first found first.

    Parameters
    ----------
    world : The world file itself.
    folders : Where models and packages are looked for.
    """

    world: Path
    folders: tuple[Path, ...]

    def found(self, uri: str, beside: Path, *, chain: Sequence[str]) -> Path:
        """Return the file or folder that a name stands for; refuse URLs and what lies elsewhere.

        Parameters
        ----------
        uri : As a world names it.
        beside : Folder of the file in which it stands.
        chain : Files and models that led there, for messages.
        """
        name = unquote(uri.strip())
        if URL.match(name):
            msg = (
                f"{shown(chain)}: {name[:200]!r} is an address on a network, which is not read; "
                "download it (gz fuel download -u URL), put its folder on the resource path and "
                "name it model://NAME."
            )
            raise GeometryError(msg)
        scheme = next((s for s in _SCHEMES if name.startswith(s)), "")
        bare = name.removeprefix(scheme)
        if scheme in {"model://", "package://"}:
            tried = [folder / bare for folder in self.folders]
            # The folder of a package, or of a model, may be on the path itself.
            first, _, rest = bare.partition("/")
            tried += [folder / rest for folder in self.folders if folder.name == first]
        elif Path(bare).is_absolute():
            tried = [Path(bare)]
        else:
            tried = [beside / bare, *(folder / bare for folder in self.folders)]
        there = [path for path in tried if path.exists()]
        allowed = [path for path in there if self._is_inside(path)]
        if allowed:
            return Path(os.path.normpath(allowed[0]))
        if there or ".." in Path(bare).parts:
            msg = (
                f"{shown(chain)}: {name[:200]!r} leads out of the folders of the world "
                f"({self._listed()}); copy it there, or name its folder in room.resource_path."
            )
            raise GeometryError(msg)
        msg = (
            f"{shown(chain)}: {name[:200]!r} does not exist in {self._listed()}; give its folder "
            "in room.resource_path, or in GZ_SIM_RESOURCE_PATH."
        )
        raise GeometryError(msg)

    def model_file(self, uri: str, beside: Path, *, chain: Sequence[str]) -> Path:
        """Return the SDF file of an included model: named itself, or that of the model's folder.

        Parameters
        ----------
        uri, beside, chain : As in `found`.
        """
        path = self.found(uri, beside, chain=chain)
        if path.is_file():
            return path
        config = path / "model.config"
        names = ["model.sdf"]
        if config.is_file():
            root = xml_root(config, what="a model.config", roots=("model", "sdf"))
            listed = [(e.get("version", "0"), (e.text or "").strip()) for e in root.iter("sdf")]
            names = [name for _, name in sorted(listed, key=_version, reverse=True) if name] + names
        for name in names:
            file = path / name
            if file.is_file() and self._is_inside(file):
                return file
        msg = (
            f"{shown(chain)}: the model folder {path} holds no {' or '.join(dict.fromkeys(names))};"
            " complete it."
        )
        raise GeometryError(msg)

    def _is_inside(self, path: Path) -> bool:
        real = path.resolve()
        return any(real.is_relative_to(folder.resolve()) for folder in self.folders)

    def _listed(self) -> str:
        shown_folders = [str(folder) for folder in self.folders[:6]]
        more = len(self.folders) - len(shown_folders)
        return ", ".join(shown_folders) + (f" and {more} more" if more > 0 else "")


def world_places(world: Path, resource_path: Sequence[str | Path] = ()) -> WorldPlaces:
    """Return where a world's files are looked for.

    Its own folder, the given ones, those of Gazebo's and ROS' variables, and, up to `LEVELS_UP`
    folders above, ``models`` folders and packages (folders with a package.xml or model.config).

    Parameters
    ----------
    world : The world, model or URDF file.
    resource_path : Further folders.
    """
    own = Path(os.path.abspath(world)).parent  # noqa: PTH100  keeps links, as Gazebo does
    folders = [own, *(Path(os.path.abspath(folder)) for folder in resource_path)]  # noqa: PTH100
    folders += [own / name for name in _MODELS]
    for above in list(own.parents)[:LEVELS_UP]:
        folders += [above / name for name in _MODELS]
        if any((above / name).exists() for name in ("package.xml", "model.config", *_MODELS)):
            folders.append(above)
    for variable in ENVIRONMENT:
        folders += [Path(p) for p in os.environ.get(variable, "").split(os.pathsep) if p]
    there = [folder for folder in dict.fromkeys(folders) if folder.is_dir()]
    return WorldPlaces(world=world, folders=tuple(there))


def shown(chain: Sequence[str]) -> str:
    """Return a chain of includes as text.

    Parameters
    ----------
    chain : Files and models, the outermost first.
    """
    return " > ".join(chain)


def _version(entry: tuple[str, str]) -> tuple[int, ...]:
    digits = entry[0].split(".")
    return tuple(int(d) if d.isdigit() else 0 for d in digits)
