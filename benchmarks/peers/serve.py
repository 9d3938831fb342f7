"""How a peer's process talks with the benchmark: one word a line in, one JSON object a line out.

``run`` times one run, ``save FILE`` writes the results of the last one. The peer's own prints go to
stderr, so that they cannot be taken for an answer.
"""

import json
import os
import resource
import sys
import time
from pathlib import Path

import numpy as np


def serve(prepare):
    """Answer until the input ends; ``prepare(workload)`` returns what runs and what saves."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def answer(**values):
        answers.write(json.dumps(values) + "\n")
        answers.flush()

    workload = json.loads(Path(sys.argv[1]).read_text())
    workload["receivers_m"] = np.array(workload["receivers_m"])
    run, results = prepare(workload)
    answer(ready=True)
    state = None
    for line in sys.stdin:
        word, *rest = line.split()
        if word == "run":
            start, cpu = time.perf_counter(), time.process_time()
            state = run()
            seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
            answer(seconds=seconds, cpu_seconds=cpu, peak_mib=peak)
        else:
            np.savez(rest[0], **results(state))
            answer(saved=rest[0])
