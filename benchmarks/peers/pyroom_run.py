"""The polyhedral image source engine of pyroomacoustics on one workload: places, no fields."""

import time

import numpy as np
import pyroomacoustics as pra
from serve import serve


def prepare(workload):
    """Return the engine's run and the lengths of the paths that it found."""
    walls = [
        pra.wall_factory(np.array(polygon).T, [0.1], [0.0], name=str(i))
        for i, polygon in enumerate(workload["polygons"])
    ]
    room = pra.Room(walls, fs=16000, max_order=workload["order"])
    room.add_source(np.array(workload["source_m"]))
    room.add_microphone_array(workload["receivers_m"].T.copy())

    def run():
        room.image_source_model()
        return room.visibility[0]

    def results(visible):
        images = np.array(room.sources[0].images, dtype=np.float64).T
        receiver, image = np.nonzero(np.reshape(visible, (-1, len(images))))
        offset = images[image] - workload["receivers_m"][receiver]
        start = time.perf_counter()
        room.room_engine.image_source_model(room.sources[0].position)
        return {
            "receiver": receiver,
            "length_m": np.linalg.norm(offset, axis=1),
            "kernel_seconds": time.perf_counter() - start,
        }

    return run, results


if __name__ == "__main__":
    serve(prepare)
