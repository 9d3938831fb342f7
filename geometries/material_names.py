"""What materials are called elsewhere, and which one the name of a body suggests."""

import re
from collections.abc import Mapping
from types import MappingProxyType

USUAL = "concrete"
"""Material of bodies whose names say nothing."""

SYNONYMS: Mapping[str, str] = MappingProxyType(
    {
        word: material
        for material, words in (
            ("plasterboard", "gypsum drywall plaster gyprock sheetrock rigips gips gipskarton"),
            (
                "metal",
                "steel iron aluminium aluminum copper brass tin zinc stainless chrome stahl metall",
            ),
            ("glass", "acrylic plexiglass glas pane"),
            ("wood", "oak pine beech timber birch walnut holz wooden"),
            ("chipboard", "mdf fibreboard fiberboard laminate particleboard hpl"),
            ("concrete", "cement screed mortar beton stone granite tile tiles ceramic plain"),
            ("marble", "terrazzo"),
            ("brick", "masonry bricks clinker ziegel"),
            ("floorboard", "parquet planks"),
            ("ceiling_board", "acoustic gridceiling"),
            ("medium_dry_ground", "soil earth asphalt grass gravel terrain lawn street road"),
        )
        for word in words.split()
    }
)
"""Materials of the table by other words for them."""

THICKNESS_M: Mapping[str, float] = MappingProxyType(
    {
        "plasterboard": 0.1, "glass": 0.006, "wood": 0.04, "chipboard": 0.03, "plywood": 0.02,
        "concrete": 0.2, "brick": 0.24, "ceiling_board": 0.02, "marble": 0.02, "floorboard": 0.02,
    }
)  # fmt: skip
"""Usual thickness of walls, doors and boards of each material [m]."""

_TABLE = (
    "plasterboard", "ceiling_board", "floorboard", "chipboard", "plywood", "concrete", "brick",
    "marble", "glass", "metal", "wood",
)  # fmt: skip
_METAL_THINGS = (
    "cabinet|locker|fridge|refriger|radiator|heater|server|rack|machine|elevator|lift|pipe|duct|"
    "railing|robot|forklift|container|barrel|bin|trash|sink|oven|stove|dishwasher|wheelchair|"
    "trolley|bed_?frame|shelf_?metal|conveyor|lamp|extinguisher|schrank"
)
_WOODEN_THINGS = (
    "desk|table|shelf|shelv|book|chair|stool|bench|sofa|couch|bed|wardrobe|drawer|counter|"
    "furniture|pallet|crate|tisch|stuhl|regal|cupboard|kitchen|dresser|frame|board"
)
_THINGS: tuple[tuple[str, str], ...] = (
    # The first that fits counts.
    ("lintel|parapet", "concrete"),
    ("window|glaz|screen|mirror|display|fenster|monitor|vitrine", "glass"),
    (_METAL_THINGS, "metal"),
    ("door|tuer|tür", "wood"),
    (_WOODEN_THINGS, "chipboard"),
    ("ceiling|decke|roof", "concrete"),
    ("partition|inner_?wall|interior_?wall|divider|trennwand", "plasterboard"),
    ("floor|slab|column|pillar|stair|wall|wand|building|house|ground_plane", "concrete"),
    ("ground|terrain|garden|lawn|road|street", "medium_dry_ground"),
)
SHEETS = re.compile(
    r"wall|lintel|parapet|window|glass|door|partition|pane|board|screen|curtain|desk|table|shelf",
    re.IGNORECASE,
)
"""Names of bodies that are usually thin."""


def known_as(word: str) -> str | None:
    """Return the table's name of a material that is called otherwise, or None.

    Parameters
    ----------
    word : As a person writes it, such as "gypsum" or "stainless steel".
    """
    for part in reversed(re.split(r"[^a-z]+", word.casefold())):
        if part in SYNONYMS:
            return SYNONYMS[part]
        if part in _TABLE:
            return part
    return None


def guess_material(name: str) -> tuple[str, str] | None:
    """Return the material that the name of a body suggests, and the word that does; None: none.

    Parameters
    ----------
    name : Of a body, such as "Door_leaf.001".
    """
    plain = name.casefold()
    words = re.split(r"[^a-zäöüß]+", plain)
    for material in _TABLE:  # a material that is named counts before what the thing is
        if material in plain or material.replace("_", "") in words:
            return material, material
    for word in words:
        if word in SYNONYMS:
            return SYNONYMS[word], word
    for pattern, material in _THINGS:
        found = re.search(pattern, plain)
        if found:
            return material, found[0]
    return None
