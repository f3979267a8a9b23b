"""What is measured: motions of every kind of contact, and chains of any length."""

from dataclasses import dataclass, replace
from math import pi, sin
from random import Random

import numpy as np

import geartrain as gt
from paper_cases import paper_case

STORED = 1000  # harmonics of a reference's waveform


@dataclass(frozen=True)
class Case:
    """A motion of a train, and the stretch of its branch on which the time of a point is taken."""

    name: str
    what: str
    train: gt.Train
    frequency: float  # where errors are taken
    stop: float  # end of the stretch that begins at `frequency`
    traced: tuple[float, float]  # range of Lambda over which the branch is traced that holds the motion
    near: tuple[float, float]  # rms of the motion meant, to tell it from others at the same frequency
    order: int | None  # of the waveform's largest error in 1/R by theory; None: spectral

    def find(self):
        """The motion at `frequency`, and one a little farther along the stretch, to start from."""
        start, stop = self.traced
        branch = self.train.response(start=start, stop=stop, harmonics=12, stability=False)
        motion = nearest(branch.at(self.frequency), self.near)
        before = nearest(branch.at(self.frequency + 0.02 * (self.stop - self.frequency)), motion.rms)
        return motion, before


def cases():
    figure3 = paper_case("fig03").train
    square = paper_case("fig08_rectangular").train
    light = paper_case("fig09_001").train
    # The whole square wave whose harmonics 1, 3 and 5 figure 8 has.
    wave = [0.42 * sin(k * pi / 2) / k for k in range(1, 512)]
    whole = replace(square, meshes=[replace(mesh, stiffness_cos=wave) for mesh in square.meshes])
    return (
        Case("smooth", "figure 3, contact never lost", figure3, 0.22, 0.3, (0.2, 0.3), (0.135, 0.142), None),
        Case("separated", "figure 3, teeth part at both meshes", figure3, 0.9, 1.0, (0.85, 1.0), (0.410, 0.714), 3),
        Case("back contact", "figure 8, the back flanks collide as well", square, 0.7, 0.65, (0.2, 2.6), (0.693, 3.166), 3),
        Case("square wave", "stiffness a square wave, contact never lost", whole, 0.4, 0.43, (0.4, 0.43), (0.263, 0.315), 2),
        Case("low damping", "figure 9, damping ratio 0.01, back contact", light, 0.65, 0.69, (0.2, 2.6), (2.664, 2.461), 3),
    )


def nearest(motions, rms):
    """The motion whose rms is nearest, relative."""
    return min(motions, key=lambda motion: np.abs(motion.rms / np.asarray(rms) - 1).max())


def reference(motion):
    """The same orbit by shooting, its waveform stored with so many harmonics that cutting it off does not show."""
    padded = np.zeros((len(motion.rms), 1 + 2 * STORED * motion.period))
    kept = min(padded.shape[1], motion.coefficients.shape[1])
    padded[:, :kept] = motion.coefficients[:, :kept]
    return replace(motion, coefficients=padded).refine()


def tree(shape, meshes):
    """Figure 3's first pairs in a tree, down and up by turns; torques at its branchings load every mesh alike.

    With little of figure 3's kappa: so no motion loses its stability, and no time goes into locating where.
    """
    down, force = replace(paper_case("fig03").train.meshes[0], stiffness_cos=[0.02]), 150 / 0.05
    random = Random(1)
    before = {
        "chain": lambda i: i - 1, "comb": lambda i: i - 1 if i % 2 == 0 else max(0, i - 2), "binary tree": lambda i: i // 2,
        "random tree": lambda i: random.randint(min(1, i - 1), i - 1),
    }[shape]  # fmt: skip
    parents = [before(i) for i in range(1, meshes + 1)]
    depths = [0]
    for parent in parents:
        depths.append(depths[parent] + 1)
    bodies, shafts, gears = [gt.Body(name="to 0", inertia=2.3e-7, torque=150.0)], [], []
    for i, parent in enumerate(parents, 1):
        small, large = (down.driving_radius, down.driving_inertia), (down.driven_radius, down.driven_inertia)
        (driving, inertia), (driven, other) = (small, large) if depths[i] % 2 else (large, small)
        last = i == meshes
        torque = 0.0 if last else (parents.count(i) - 1) * force * driven
        bodies += [gt.Body(name=f"from {i}", inertia=inertia), gt.Body(name=f"to {i}", inertia=other, torque=torque, balances=last)]
        shafts.append(gt.Shaft(between=(f"to {parent}", f"from {i}"), stiffness=1e8 if parent else 1e3, damping_ratio=0.01))
        between = (f"from {i}", f"to {i}")
        gears.append(replace(
            down, driving_radius=driving, driven_radius=driven, driving_inertia=None, driven_inertia=None, between=between,
        ))  # fmt: skip
    return gt.Train(
        title=f"{shape} of {meshes} meshes", characteristic_length=30e-6, characteristic_frequency=9870.0, bodies=bodies,
        shafts=shafts, meshes=gears,
    )  # fmt: skip
