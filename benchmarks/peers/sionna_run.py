"""Sionna RT on one workload, within its own environment: exact paths, or its Monte Carlo map."""

import drjit as dr
import mitsuba as mi
import numpy as np
from serve import serve

mi.set_variant("llvm_ad_mono_polarized")

from sionna.rt import (  # noqa: E402  the variant comes first
    AntennaArray,
    PathSolver,
    PlanarArray,
    RadioMapSolver,
    RadioMaterial,
    Receiver,
    SceneObject,
    Transmitter,
    load_scene,
)
from sionna.rt.antenna_pattern import antenna_pattern_registry  # noqa: E402
from sionna.rt.path_solvers.sb_candidate_generator import SBCandidateGenerator  # noqa: E402

SPEED_OF_LIGHT_M_PER_S = 299792458.0
COUNTERS = int(2e8)
"""Slots for candidates; with the default of 1e6 up to 9 % of the paths are lost to collisions."""
HALF_SPACE_M = 100.0
"""Sionna RT knows slabs only; of one this thick nothing comes back from behind."""
INTERACTIONS = {
    "los": True,
    "specular_reflection": True,
    "diffuse_reflection": False,
    "refraction": False,
    "diffraction": False,
}


def scene_of(workload):
    """Return the scene with its transmitter."""
    scene = load_scene()
    scene.frequency = workload["frequency_hz"]
    materials = {
        name: RadioMaterial(
            name=f"the_{name}",
            thickness=m["thickness_m"] or HALF_SPACE_M,
            relative_permittivity=m["eps_r"],
            conductivity=m["sigma_s_per_m"],
        )
        for name, m in workload["materials"].items()
    }
    bodies = [
        SceneObject(fname=b["file"], name=f"body_{i}", radio_material=materials[b["material"]])
        for i, b in enumerate(workload["bodies"])
    ]
    scene.edit(add=bodies)
    scene.tx_array = PlanarArray(num_rows=1, num_cols=1, pattern="hw_dipole", polarization="V")
    scene.add(Transmitter("tx", position=workload["source_m"]))
    return scene


def paths_of(workload):
    """Return the path solver's run and what it found."""
    SBCandidateGenerator.MIN_SPEC_COUNT_SIZE = COUNTERS
    scene = scene_of(workload)
    receivers = workload["receivers_m"]
    pattern = antenna_pattern_registry.get("iso")(polarization="V")
    wavelength = SPEED_OF_LIGHT_M_PER_S / workload["frequency_hz"]
    scene.rx_array = AntennaArray(pattern, mi.Point3f((receivers / wavelength).T))
    scene.add(Receiver("rx", position=[0.0, 0.0, 0.0]))
    solver = PathSolver()

    def run():
        paths = solver(
            scene,
            max_depth=workload["order"],
            samples_per_src=workload["samples"],
            max_num_paths_per_src=workload["most_paths"],
            synthetic_array=False,
            **INTERACTIONS,
        )
        real, imaginary = paths.a
        dr.eval(real, imaginary, paths.tau, paths.valid)
        dr.sync_thread()
        return paths

    def results(paths):
        count = len(receivers)
        valid = np.asarray(paths.valid.numpy()).reshape(count, -1)
        delay = np.asarray(paths.tau.numpy()).reshape(count, -1).astype(np.float64)
        amplitude = sum(
            unit * np.asarray(part.numpy()).reshape(count, -1)
            for unit, part in zip((1.0, 1.0j), paths.a, strict=True)
        )
        carrier = np.exp(-2j * np.pi * workload["frequency_hz"] * delay)
        receiver, _ = np.nonzero(valid)
        return {
            "receiver": receiver,
            "length_m": delay[valid] * SPEED_OF_LIGHT_M_PER_S,
            "gain": (amplitude * carrier)[valid],
        }

    return run, results


def map_of(workload):
    """Return the radio map solver's run, and its noise against a far longer run [dB rms]."""
    scene = scene_of(workload)
    scene.rx_array = PlanarArray(num_rows=1, num_cols=1, pattern="iso", polarization="V")
    solver = RadioMapSolver()

    def path_gain(*, samples, seed):
        found = solver(
            scene,
            center=mi.Point3f(2.5, 2.5, float(workload["receivers_m"][0, 2])),
            orientation=mi.Point3f(0.0, 0.0, 0.0),
            size=mi.Point2f(5.0, 5.0),
            cell_size=mi.Point2f(5.0 / workload["side"], 5.0 / workload["side"]),
            samples_per_tx=samples,
            max_depth=workload["order"],
            seed=seed,
            **INTERACTIONS,
        )
        return np.asarray(found.path_gain.numpy())[0]

    def results(found):
        many = [path_gain(samples=10 * workload["samples"], seed=seed) for seed in range(1, 5)]
        error_db = 10.0 * np.log10(found / np.mean(many, axis=0))
        return {"path_gain": found.T, "noise_db": np.sqrt(np.mean(error_db**2))}

    return lambda: path_gain(samples=workload["samples"], seed=42), results


if __name__ == "__main__":
    serve(lambda workload: (map_of if workload["is_map"] else paths_of)(workload))
