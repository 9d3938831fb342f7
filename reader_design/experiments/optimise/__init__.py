"""The search for a reader design: survey, continuous refinement, Pareto front, short list."""
