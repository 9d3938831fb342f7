"""The fuzzy controller's rule base, from the numbers of a study."""

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.control.fuzzy import Rule, RuleBase, thesis_rule_base, variable_from_table
from octant.reader_design.study_file.mission import Mission


def mission_rules(table: Mission) -> RuleBase:
    """Return the fuzzy controller's rule base: the study's own, or the thesis'.

    Parameters
    ----------
    table : The table ``[mission]``.
    """
    given = table.membership
    if given is None:
        return thesis_rule_base()
    try:
        return RuleBase(
            input_variable=variable_from_table("input", (-1.0, 1.0), given.input.items()),
            outputs=tuple(
                variable_from_table(name, (0.0, 1.0), given.speed.items())
                for name in ("right wheel", "left wheel")
            ),
            rules=tuple(Rule(when=when, then=then) for when, then in given.rules.items()),
        )
    except NavigationError as exc:
        msg = f"mission.membership: {exc}"
        raise ConfigError(msg) from exc
