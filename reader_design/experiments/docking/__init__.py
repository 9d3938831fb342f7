"""The docking verb's work: a study's missions, the published experiments, figures and report."""
