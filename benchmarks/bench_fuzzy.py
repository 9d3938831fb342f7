"""How fast the fuzzy controller infers, beside scikit-fuzzy with the same membership functions.

Prints microseconds per inference one at a time and in a batch, and the time that a whole thesis
navigator takes for one period. Run: ``python benchmarks/bench_fuzzy.py``.
"""

import time
from collections.abc import Callable

import numpy as np
import skfuzzy
import skfuzzy.control

from octant.navigation.control.controllers import FuzzyController
from octant.navigation.control.fuzzy import FuzzyVariable, RuleBase, thesis_rule_base
from octant.navigation.navigators.arrival import ArrivalTest
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.thesis import ThesisMemory, ThesisNavigator
from octant.navigation.robot.drive import DifferentialDrive

GRID = 1001
"""Points of scikit-fuzzy's universes [-]: what 1e-3 of agreement takes."""


def scikit_fuzzy(base: RuleBase) -> Callable[[float], list[float]]:
    """Return scikit-fuzzy's inference of a rule base, ready for calls."""

    def with_terms(kind: type, variable: FuzzyVariable) -> skfuzzy.control.Antecedent:
        grid = np.linspace(variable.low, variable.high, GRID)
        fuzzy = kind(grid, variable.name)
        for term in variable.terms:
            fuzzy[term.name] = skfuzzy.trapmf(grid, term.corners)
        return fuzzy

    steering = with_terms(skfuzzy.control.Antecedent, base.input_variable)
    wheels = [with_terms(skfuzzy.control.Consequent, output) for output in base.outputs]
    rules = [
        skfuzzy.control.Rule(
            steering[rule.when],
            [wheel[term] for wheel, term in zip(wheels, rule.then, strict=True)],
        )
        for rule in base.rules
    ]
    # Without its cache, which would answer the same input from memory.
    system = skfuzzy.control.ControlSystem(rules)
    simulation = skfuzzy.control.ControlSystemSimulation(system, cache=False)

    def infer(value: float) -> list[float]:
        simulation.input[base.input_variable.name] = value
        simulation.compute()
        return [simulation.output[output.name] for output in base.outputs]

    return infer


def best_us(work: Callable[[], object], calls: int) -> float:
    """Return the time of one call, the best of seven rounds [us]."""
    rounds = []
    for _ in range(7):
        begun = time.perf_counter()
        for _ in range(calls):
            work()
        rounds.append((time.perf_counter() - begun) / calls)
    return 1e6 * min(rounds)


def main() -> None:
    """Print the table."""
    base, theirs = thesis_rule_base(), scikit_fuzzy(thesis_rule_base())
    values = np.linspace(-0.99, 0.99, 100_000)
    worst = max(np.abs(base.infer(x) - theirs(x)).max() for x in np.linspace(-0.99, 0.99, 67))
    slow = best_us(lambda: theirs(0.3), 20)
    single = best_us(lambda: base.infer(0.3), 20_000)
    batch = best_us(lambda: base.infer(values), 3) / len(values)
    navigator = ThesisNavigator(
        arrivals=(ArrivalTest(threshold_w=1e-12),),
        azimuths_rad=np.arange(8) * np.pi / 4.0,
        controller=FuzzyController(),
        robot=DifferentialDrive(),
        cruise_speed_m_per_s=0.09,
        period_s=1.0,
    )
    rng = np.random.default_rng(0)
    rss_w, step = 1e-7 * rng.random(8), Odometry(distance_m=0.09)
    memory = ThesisMemory(mode="navigation")
    period = best_us(lambda: navigator.decide(memory, rss_w, step, rng), 2000)
    print(f"scikit-fuzzy, one inference        {slow:10.1f} us  (universes of {GRID} points)")
    print(f"octant, one inference              {single:10.2f} us  {slow / single:8.0f} x faster")
    print(f"octant, one of a batch of 100000   {batch:10.3f} us  {slow / batch:8.0f} x faster")
    print(f"greatest difference                {worst:10.1e}")
    print(f"thesis navigator, one period       {period:10.1f} us")


if __name__ == "__main__":
    main()
