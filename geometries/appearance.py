"""What materials look like to people, in pictures and in GLB files; it does not affect rays."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Looks:
    """Colour and surface of a material after the metallic-roughness model of glTF 2.

    Parameters
    ----------
    colour : (3,) tuple of float — Red, green and blue as on a screen (sRGB) [-], 0 to 1.
    opacity : 1 for what hides everything behind it [-].
    metallic, roughness : 0 to 1 [-].
    """

    colour: tuple[float, float, float]
    opacity: float = 1.0
    metallic: float = 0.0
    roughness: float = 0.9


def _of(
    hex_colour: str, *, opacity: float = 1.0, metallic: float = 0.0, rough: float = 0.9
) -> Looks:
    red, green, blue = (int(hex_colour[i : i + 2], 16) / 255.0 for i in (0, 2, 4))
    return Looks(colour=(red, green, blue), opacity=opacity, metallic=metallic, roughness=rough)


LOOKS: Mapping[str, Looks] = MappingProxyType(
    {
        "concrete": _of("a9a7a1"),
        "brick": _of("b0604a"),
        "plasterboard": _of("e6e1d6"),
        "wood": _of("b58a57"),
        "glass": _of("9fc9d8", opacity=0.35, rough=0.1),
        "ceiling_board": _of("eeece4"),
        "chipboard": _of("c9a877"),
        "plywood": _of("d2b382"),
        "marble": _of("dcdad8", rough=0.3),
        "floorboard": _of("9c7146"),
        "metal": _of("8d979f", metallic=0.8, rough=0.4),
        "pec": _of("c7a548", metallic=0.9, rough=0.3),
        "very_dry_ground": _of("c8b18a"),
        "medium_dry_ground": _of("a5834f"),
        "wet_ground": _of("6f5a3c"),
    }
)
"""Looks of the materials that Octant knows by name."""

_DRAWN: Mapping[str, Looks] = MappingProxyType(
    {
        "transmitter": _of("0b7a75"),
        "receiver": _of("1f4e9c"),
        "tag": _of("d9331a"),
        "antenna": _of("b5333f", metallic=0.6, rough=0.4),
        "trajectory": _of("332288"),
        "axis x": _of("cc2222"),
        "axis y": _of("22aa22"),
        "axis z": _of("2222cc"),
        **{
            f"path of order {n}": _of(c)
            for n, c in enumerate(("332288", "cc6677", "117733", "ddaa33", "88ccee", "aa4499"))
        },
    }
)
"""What is drawn into a scene besides materials."""

UNKNOWN = _of("b9a7c4")
"""What every other material looks like."""


def looks_of(label: str) -> Looks:
    """Return what a material, end or drawn path of a label looks like; `UNKNOWN` for any other.

    Parameters
    ----------
    label : A body's material: a name, or keys and values: ``name = concrete, thickness_m = 0.1``.
    """
    named = re.search(r"\bname = ([^,]+)", label)
    name = (named[1] if named else label).strip().lower().removeprefix("itu_")
    return LOOKS.get(name) or _DRAWN.get(name, UNKNOWN)


def gltf_visual(label: str, *, opacity: float | None = None) -> Any:  # noqa: ANN401  trimesh's own
    """Return the visuals, both sides drawn, with which trimesh writes a mesh to GLB or GLTF.

    Parameters
    ----------
    label : A body's material, which becomes the name of the glTF material.
    opacity : 0 to 1 [-]; None: that of the material.
    """
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    looks = looks_of(label)
    alpha = looks.opacity if opacity is None else opacity
    linear = [_linear(c) for c in looks.colour]  # glTF's base colour is linear light
    return TextureVisuals(
        material=PBRMaterial(
            name=label,
            baseColorFactor=[*linear, alpha],
            metallicFactor=looks.metallic,
            roughnessFactor=looks.roughness,
            alphaMode="OPAQUE" if alpha >= 1.0 else "BLEND",
            doubleSided=True,
        )
    )


def _linear(value: float) -> float:
    """Return linear light of a screen value (IEC 61966-2-1)."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
