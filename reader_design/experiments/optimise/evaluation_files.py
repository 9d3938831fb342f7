"""The file of one evaluation: JSON, named by its hash, written whole, checked when read back."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from octant.geometries.errors import SweepStateError
from octant.geometries.files import write_text
from octant.reader_design.experiments.optimise.evaluation import ARRAYS, Evaluation
from octant.reader_design.setting.design import ReaderDesign, canonical_json, content_hash


def evaluation_path(folder: Path, key: str) -> Path:
    """Return where an evaluation's file lies.

    Parameters
    ----------
    folder : Path
        Folder of the search's evaluations.
    key : str
        Name of the evaluation.

    Returns
    -------
    Path
        A JSON file named by the first 32 digits of the key.
    """
    return folder / f"{key[:32]}.json"


def write_evaluation(folder: Path, evaluation: Evaluation) -> None:
    """Return nothing; write an evaluation whole or not at all, in the units of its names.

    Parameters
    ----------
    folder : Path
        Folder of the search's evaluations.
    evaluation : Evaluation
        What to keep.

    Raises
    ------
    ConfigError
        When the folder cannot be written to.
    """
    content = _content(evaluation)
    text = canonical_json({**content, "digest": content_hash(content)})
    write_text(evaluation_path(folder, evaluation.key), text + "\n")


def _content(evaluation: Evaluation) -> dict[str, Any]:
    return {
        "key": evaluation.key,
        "design": evaluation.design.as_dict(),
        "reason": evaluation.reason,
        "footprint_m": evaluation.footprint_m,
        "height_m": evaluation.height_m,
        "notes": list(evaluation.notes),
        **{name: getattr(evaluation, name).tolist() for name in ARRAYS},
    }


def read_evaluation(folder: Path, key: str, design: ReaderDesign) -> Evaluation | None:
    """Return a kept evaluation, bit by bit as it was written; None when there is none.

    Parameters
    ----------
    folder : Path
        Folder of the search's evaluations.
    key : str
        Name of the evaluation.
    design : ReaderDesign
        The design that the key stands for.

    Returns
    -------
    Evaluation or None
        None when there is no file.

    Raises
    ------
    SweepStateError
        When the file is damaged or another design's.
    """
    path = evaluation_path(folder, key)
    try:
        found = json.loads(path.read_text("utf-8"))
        told = found.pop("digest")
        if told != content_hash(found) or found["key"] != key:
            msg = f"the file {path} is damaged or another design's; delete it."
            raise SweepStateError(msg)
        return Evaluation(
            key=key,
            design=design,
            reason=found["reason"],
            footprint_m=found["footprint_m"],
            height_m=found["height_m"],
            notes=tuple(found["notes"]),
            **{name: np.array(found[name], dtype=np.float64) for name in ARRAYS},
        )
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as exc:
        msg = f"the file {path} cannot be read ({exc}); delete it, or let it be overwritten."
        raise SweepStateError(msg) from exc
