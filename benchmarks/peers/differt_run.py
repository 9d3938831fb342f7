"""DiffeRT's exhaustive path tracer on one workload: paths, no fields."""

import jax
import jax.numpy as jnp
import numpy as np
from differt.geometry import Mesh, Scene
from serve import serve

CANDIDATES_AT_ONCE = 500
"""Bounds the memory: every candidate is tried for every receiver."""


def prepare(workload):
    """Return the tracer's run over all orders, and the lengths of the valid paths."""
    quads = np.array(workload["polygons"])
    first = 4 * np.arange(len(quads))[:, None, None]
    mesh = Mesh(
        vertices=jnp.array(quads.reshape(-1, 3)),
        triangles=jnp.array((first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)),
    ).set_assume_quads()
    scene = Scene(
        transmitters=jnp.array(workload["source_m"]),
        receivers=jnp.array(workload["receivers_m"]),
        mesh=mesh,
    )

    def run():
        found = []
        for order in range(workload["order"] + 1):
            for paths in scene.trace_paths(
                order, solver="exhaustive", chunk_size=CANDIDATES_AT_ONCE
            ):
                jax.block_until_ready(paths.mask)
                mask = np.asarray(paths.mask)
                found.append((np.nonzero(mask)[0], np.asarray(paths.vertices)[mask]))
        return found

    def results(found):
        lengths = [
            np.linalg.norm(np.diff(v.astype(np.float64), axis=1), axis=2).sum(axis=1)
            for _, v in found
        ]
        return {
            "receiver": np.concatenate([receiver for receiver, _ in found]),
            "length_m": np.concatenate(lengths),
        }

    return run, results


if __name__ == "__main__":
    serve(prepare)
