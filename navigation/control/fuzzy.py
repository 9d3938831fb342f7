"""Mamdani inference for the five-rule controller: terms as data, a centroid without a grid."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.geometries.names import nearest_name
from octant.navigation.control._fuzzy_kernels import mamdani_centroid, mamdani_centroids


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """One linguistic term: a trapezoid over its variable.

    Parameters
    ----------
    name : Label that the rules use, such as "NH".
    corners : (4,) float64 — Where the membership leaves 0, reaches 1, leaves 1 and reaches 0 again,
        in order [in the variable's unit]; two equal inner ones make a triangle, outer ones a step.
    """

    name: str
    corners: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        corners = frozen_array(
            self.corners, name=f"corners of term {self.name!r}", shape=(4,), error=NavigationError
        )
        if (np.diff(corners) < 0.0).any() or corners[3] <= corners[0]:
            msg = (
                f"term {self.name!r} has the corners {corners.tolist()}, which must not decrease "
                "and must enclose an area: order them from left to right."
            )
            raise NavigationError(msg)
        object.__setattr__(self, "corners", corners)

    def membership(self, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return how far values belong to the term, from 0 to 1 [-]; NaN for NaN.

        Parameters
        ----------
        value : (...) float64 — Where to evaluate [in the variable's unit].
        """
        x = np.asarray(value, dtype=np.float64)
        a, b, c, d = self.corners
        rising = np.where(x >= b, 1.0, (x - a) / (b - a if b > a else 1.0))
        falling = np.where(x <= c, 1.0, (d - x) / (d - c if d > c else 1.0))
        inside = (x >= a) & (x <= d)
        return np.where(np.isnan(x), np.nan, np.where(inside, np.minimum(rising, falling), 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class FuzzyVariable:
    """A variable with the terms that cover its universe.

    Parameters
    ----------
    name : What the variable is, such as "normalised difference".
    low, high : Ends of the universe [in the variable's unit].
    terms : Ordered by the middle of their cores, inside the universe and covering all of it.
    """

    name: str
    low: float
    high: float
    terms: tuple[Term, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", tuple(self.terms))
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            msg = (
                f"the universe of {self.name!r} is [{self.low}, {self.high}], but its lower end "
                "must be below its upper end: give two finite ends in order."
            )
            raise NavigationError(msg)
        self._check_terms()
        self._check_cover()

    def _check_terms(self) -> None:
        names = self.term_names
        if not names or len(set(names)) != len(names):
            msg = f"{self.name!r} has the terms {list(names)}; give at least one, each name once."
            raise NavigationError(msg)
        for term in self.terms:
            if term.corners[0] < self.low or term.corners[3] > self.high:
                msg = (
                    f"term {term.name!r} of {self.name!r} has the corners "
                    f"{term.corners.tolist()}, which leave the universe [{self.low}, {self.high}]: "
                    "move them inside."
                )
                raise NavigationError(msg)
        middles = np.array([term.corners[1] + term.corners[2] for term in self.terms]) / 2.0
        if (np.diff(middles) <= 0.0).any():
            msg = (
                f"the terms {list(names)} of {self.name!r} have the core middles "
                f"{middles.tolist()}, which must increase: list the terms from left to right."
            )
            raise NavigationError(msg)

    def _check_cover(self) -> None:
        corners = np.concatenate([term.corners for term in self.terms])
        knots = np.unique(np.concatenate([corners, [self.low, self.high]]))
        # Between two corners a membership is linear, so a look at the knots and half-way is exact.
        looks = np.sort(np.concatenate([knots, (knots[:-1] + knots[1:]) / 2.0]))
        bare = looks[self.memberships(looks).max(axis=-1) <= 0.0]
        if bare.size:
            msg = (
                f"no term of {self.name!r} covers {bare[0]:g}, but the terms must cover all of "
                f"[{self.low}, {self.high}]: widen the terms beside it."
            )
            raise NavigationError(msg)

    @property
    def term_names(self) -> tuple[str, ...]:
        """Return the names of the terms from left to right."""
        return tuple(term.name for term in self.terms)

    def memberships(self, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return how far values belong to each term, (..., terms), from 0 to 1 [-].

        Parameters
        ----------
        value : (...) float64 — Where to evaluate [in the variable's unit].
        """
        return np.stack([term.membership(value) for term in self.terms], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """One rule: if the input is `when`, then each output is its term in `then`.

    Parameters
    ----------
    when : Term of the input.
    then : One term for each output, in the outputs' order.
    """

    when: str
    then: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RuleBase:
    """A complete Mamdani rule base with one input.

    Implication by minimum, aggregation by maximum, centroid (thesis 5.2.2.2; Karray, de Silva
    2004).

    Parameters
    ----------
    input_variable : The input; values outside its universe are moved to the nearer end.
    outputs : The outputs.
    rules : Exactly one for each term of the input.
    """

    input_variable: FuzzyVariable
    outputs: tuple[FuzzyVariable, ...]
    rules: tuple[Rule, ...]
    _input_corners: npt.NDArray[np.float64] = field(init=False, repr=False, compare=False)
    _output_corners: npt.NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "outputs", tuple(self.outputs))
        object.__setattr__(self, "rules", tuple(self.rules))
        if not self.outputs:
            msg = "the rule base has no output; give at least one output variable."
            raise NavigationError(msg)
        for rule in self.rules:
            if len(rule.then) != len(self.outputs):
                msg = (
                    f"the rule for {rule.when!r} sets {len(rule.then)} outputs, but there are "
                    f"{len(self.outputs)}: name one term for each output."
                )
                raise NavigationError(msg)
        conditions = [_term(self.input_variable, rule.when) for rule in self.rules]
        self._check_complete()
        conclusions = [
            [_term(output, rule.then[k]).corners for rule in self.rules]
            for k, output in enumerate(self.outputs)
        ]
        shape = (len(self.rules), 4)
        object.__setattr__(
            self,
            "_input_corners",
            frozen_array([term.corners for term in conditions], name="conditions", shape=shape),
        )
        object.__setattr__(
            self,
            "_output_corners",
            frozen_array(conclusions, name="conclusions", shape=(len(self.outputs), *shape)),
        )

    def _check_complete(self) -> None:
        used = [rule.when for rule in self.rules]
        for name in self.input_variable.term_names:
            if used.count(name) != 1:
                msg = (
                    f"the rule base is incomplete or ambiguous: term {name!r} of "
                    f"{self.input_variable.name!r} stands in {used.count(name)} rules; "
                    "give exactly one rule for each term."
                )
                raise NavigationError(msg)

    def infer(self, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return each output's centroid, (..., outputs) [in its variable's unit]; NaN for NaN.

        Exact up to rounding: the piecewise-linear aggregated set is summed piece by piece.

        Parameters
        ----------
        value : (...) float64 — Input [in its variable's unit]; moved into the universe first.
        """
        if isinstance(value, float):  # one step of a mission: no array to be shaped
            crisp: npt.NDArray[np.float64] = mamdani_centroid(
                value,
                float(self.input_variable.low),
                float(self.input_variable.high),
                self._input_corners,
                self._output_corners,
            )
            return crisp
        x = np.ascontiguousarray(value, dtype=np.float64)
        outputs: npt.NDArray[np.float64] = mamdani_centroids(
            x.reshape(-1),
            float(self.input_variable.low),
            float(self.input_variable.high),
            self._input_corners,
            self._output_corners,
        )
        return outputs.reshape(*np.shape(value), len(self.outputs))


def _term(variable: FuzzyVariable, name: str) -> Term:
    for term in variable.terms:
        if term.name == name:
            return term
    near = nearest_name(name, variable.term_names)
    msg = (
        f"a rule names the term {name!r}, but {variable.name!r} has {list(variable.term_names)}: "
        f"did you mean {near!r}?"
    )
    raise NavigationError(msg)


def variable_from_table(
    name: str, universe: tuple[float, float], table: Iterable[tuple[str, npt.ArrayLike]]
) -> FuzzyVariable:
    """Return a variable from plain rows of data.

    Parameters
    ----------
    name : What the variable is.
    universe : Lower and upper end [in the variable's unit].
    table : Each term's name with its four corners, three for a triangle [in the variable's unit].
    """
    terms = []
    for term_name, row in table:
        corners = np.asarray(row, dtype=np.float64)
        if corners.shape == (3,):
            corners = corners[[0, 1, 1, 2]]
        terms.append(Term(name=term_name, corners=corners))
    return FuzzyVariable(name=name, low=universe[0], high=universe[1], terms=tuple(terms))


INPUT_TERMS: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("NH", (-1.0, -1.0, -0.5)),
    ("NL", (-1.0, -0.5, 0.0)),
    ("Z", (-0.5, 0.0, 0.5)),
    ("PL", (0.0, 0.5, 1.0)),
    ("PH", (0.5, 1.0, 1.0)),
)
"""Terms of the steering input on [-1, 1] [-]: negative high and low, zero, positive low, high."""

SPEED_TERMS: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("VL", (0.0, 0.0, 0.25)),
    ("L", (0.0, 0.25, 0.5)),
    ("M", (0.25, 0.5, 0.75)),
    ("H", (0.5, 0.75, 1.0)),
    ("VH", (0.75, 1.0, 1.0)),
)
"""Terms of a wheel's normalised speed on [0, 1] [-]: very low, low, medium, high, very high."""

THESIS_RULES: tuple[Rule, ...] = (
    Rule(when="NH", then=("VH", "VL")),
    Rule(when="NL", then=("H", "L")),
    Rule(when="Z", then=("M", "M")),
    Rule(when="PL", then=("L", "H")),
    Rule(when="PH", then=("VL", "VH")),
)
"""Thesis Table 5.1: the speeds of the right and the left wheel for each term of the input."""


def thesis_rule_base() -> RuleBase:
    """Return the five-rule controller: steering input on [-1, 1] to wheel speeds on [0, 1].

    Outputs are uRn, uLn, 0.5 being the cruise speed. The rules are thesis Table 5.1. Its figure 5.5
    gives no numbers ("tuned based on an empirical analysis"), so the terms here are chosen: evenly
    spaced triangles whose memberships add up to one. The input in nanowatts is divided by its full
    scale first, which is what "normalized to [-1200, 1200] nW" comes to.
    """
    return RuleBase(
        input_variable=variable_from_table("steering input", (-1.0, 1.0), INPUT_TERMS),
        outputs=(
            variable_from_table("right wheel", (0.0, 1.0), SPEED_TERMS),
            variable_from_table("left wheel", (0.0, 1.0), SPEED_TERMS),
        ),
        rules=THESIS_RULES,
    )
