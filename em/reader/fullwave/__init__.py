"""Method of moments on the reader's own triangle mesh: currents, matrices, embedded patterns."""
