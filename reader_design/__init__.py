"""The design space, its scores and choice, the study, its files, figures and command line."""
