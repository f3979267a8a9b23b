"""Whether train.motions misses what brute force finds: python benchmarks/motions.py [--quick] [TRAIN ...] [SPEED ...]

At five speeds of the trains of figures 3, 7 (kappa 0.42) and 9 (0.01) and of ten random trains of one to three meshes: 1,000
random starts of time integration; 2,000 shootings from random states of another seed, for periods 1 to 4 from each of 500; 2,000
balances from random waveforms for periods 1 to 4. Each orbit found must be among those of train.motions with its defaults.
Prints a line a place and ends with how many were missing; --quick takes a tenth of it. Names of trains ("fig07_042", "random 3")
and speeds (2.4) choose among the places.
"""

import sys
import time
from pathlib import Path

import numpy as np

import geartrain as gt
from geartrain.errors import SolverError
from geartrain.results.motion_search import _Known, _random_waveforms

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "example" / "paper"))

from paper_cases import paper_case

ROOT = Path(__file__).resolve().parents[1]
SPEEDS = (0.4, 0.7, 1.2, 1.92, 2.4)


def random_train(number):
    """A chain of one to three pairs like those of the paper, all numbers within a factor of 2."""
    moments = np.random.default_rng(number)

    def about(value):
        return value * float(2 ** moments.uniform(-1, 1))

    meshes = [
        gt.Mesh(driving_radius=0.05, driven_radius=0.1, driving_inertia=about(0.0023), driven_inertia=about(0.037),
                stiffness=about(2.5e8), damping_ratio=about(0.05), half_backlash=about(30e-6), stiffness_cos=[about(0.25)])
        for _ in range(1 + number % 3)
    ]
    between = [gt.Shaft(stiffness=about(1e7), damping_ratio=0.01) for _ in meshes[1:]]
    shafts = [gt.Shaft(stiffness=1e3, damping_ratio=0.01), *between, gt.Shaft(stiffness=1e3, damping_ratio=0.01)]
    return gt.Train(
        input_torque=about(150.0), prime_mover_inertia=2.3e-7, load_inertia=2.3e-7, characteristic_length=30e-6,
        characteristic_frequency=9870.0, shafts=shafts, meshes=meshes,
    )


def brute_force(train, frequency, starts, seeds, found):
    """Every orbit of period 1 to 4 that random starts and shooting from random states find."""
    known = _Known(train, frequency, dict.fromkeys(range(1, 5)))
    for motion in train.attractors(frequency, starts=starts, random_seed=11):
        if 0 < motion.period <= 4:
            known.add_near(motion, "start")
    reach = 2 * np.abs([motion.state for motion in found if motion.state is not None]).max(axis=0)
    moments = np.random.default_rng(12)
    for _ in range(seeds):
        state = moments.uniform(-reach, reach)
        for period in range(1, 5):
            orbit = known.shoot(state, period)
            if orbit is not None:
                known.add(orbit, "shooting")
    given = _Known(train, frequency, dict.fromkeys(range(1, 5)))
    given.found = [(motion, "") for motion in found]
    for guess in _random_waveforms(given, [], 2.0, moments, 4 * seeds):
        for balanced in known.balance(guess):
            known.add_near(balanced, "balance")
    return [motion for motion, _ in known.found]


def same_motion(one, other):
    figures = ((motion.rms, motion.maximum, motion.minimum) for motion in (one, other))
    return one.period == other.period and np.allclose(*figures, rtol=1e-6)


def main():
    share = 10 if "--quick" in sys.argv else 1
    read = {name: paper_case(name).train for name in ("fig03", "fig07_042", "fig09_001")}
    trains = {**read, **{f"random {number}": random_train(number) for number in range(1, 11)}}
    chosen = [word for word in sys.argv[1:] if word != "--quick"]
    speeds = [speed for speed in SPEEDS if str(speed) in chosen] or SPEEDS
    trains = {name: train for name, train in trains.items() if name in chosen} or trains
    missing = 0
    for name, train in trains.items():
        for frequency in speeds:
            begun = time.process_time()
            try:
                found = train.motions(frequency)
            except SolverError as error:
                print(f"{name} at {frequency}: {error}", flush=True)
                continue
            took = time.process_time() - begun
            more = [motion for motion in brute_force(train, frequency, 1000 // share, 500 // share, found)
                    if not any(same_motion(motion, own) for own in found)]
            missing += len(more)
            told = "".join(f"; missing: period {motion.period}, rms {motion.rms.round(4)}" for motion in more)
            print(f"{name} at {frequency}: {len(found)} motions in {took:.1f} s of CPU, complete: {found.complete}{told}",
                  flush=True)
    print(f"{missing} missing")
    return missing > 0


if __name__ == "__main__":
    sys.exit(main())
