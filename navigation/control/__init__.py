"""Control laws: fuzzy, regulators, docking law."""
