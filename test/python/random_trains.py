"""Random trains of two to six bodies: chains, branched trains and loops, by plain numbers or by a drawing."""

import numpy as np

import geartrain as gt

#: Share of the trains that are given by a drawing, of those with branches, and of those with a loop [1].
DRAWN, BRANCHED, LOOPED = 0.1, 0.35, 0.25
#: Characteristic length [m] and frequency [rad/s] of trains by plain numbers.
LENGTH, FREQUENCY = 30e-6, 1e4


def random_train(rng):
    """A train of which all numbers are random, without a mesh that floats in its gap: its mean position would not be unique."""
    if rng.random() < DRAWN:
        return drawn_train(rng)
    while True:
        train = plain_train(rng)
        told = train.explain()
        loads = [told[f"mesh {number}"]["mean_force"] for number in range(1, len(train.meshes) + 1)]
        if all(load or not mesh.half_backlash for load, mesh in zip(loads, train.meshes)):
            return train


def drawn_train(rng):
    """A stage of two gears between a motor and a load, by its drawing; the stiffness is that of the standard or given."""
    teeth = int(rng.integers(17, 30)), int(rng.integers(35, 70))
    more = {} if rng.random() < 0.5 else {"stiffness": rng.uniform(3e8, 7e8)}
    bodies = [
        gt.Body(name="motor", inertia=rng.uniform(0.01, 0.03), torque=rng.uniform(40.0, 140.0)), gt.Body(name="pinion"),
        gt.Body(name="wheel"), gt.Body(name="load", inertia=rng.uniform(0.5, 2.0), balances=True),
    ]
    shafts = [
        gt.Shaft(between=between, diameter=[rng.uniform(0.02, 0.05)], length=[rng.uniform(0.05, 0.2)], damping_ratio=0.02)
        for between in (("motor", "pinion"), ("wheel", "load"))
    ]
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=teeth, normal_module=3e-3, face_width=rng.uniform(0.03, 0.06),
                   helix_angle=float(rng.choice([0.0, 15.0])), backlash=rng.uniform(20e-6, 100e-6),
                   damping_ratio=rng.uniform(0.03, 0.1), stiffness_harmonics=2, error_cos=[rng.uniform(0.0, 3e-6)], **more)
    return gt.Train(bodies=bodies, shafts=shafts, meshes=[mesh])


def plain_train(rng):
    """A tree of bodies joined by meshes and shafts, at times with one more mesh or shaft that closes a loop."""
    count = int(rng.integers(2, 7))
    branched, looped = rng.random() < BRANCHED, count > 2 and rng.random() < LOOPED
    turns, sense, ends = [1.0], [1], []
    for body in range(1, count):
        to = int(rng.integers(body)) if branched else body - 1
        meshes = body == 1 or rng.random() < 0.5
        ratio = rng.uniform(0.4, 1.6) if meshes else 1.0
        turns.append(turns[to] * ratio)
        sense.append(-sense[to] if meshes else sense[to])
        ends.append((to, body, meshes))
    if looped:
        one, other = (int(body) for body in sorted(rng.choice(count, 2, replace=False)))
        ends.append((one, other, turns[one] != turns[other] or sense[one] != sense[other]))
    return gt.Train(
        characteristic_length=LENGTH, characteristic_frequency=FREQUENCY, bodies=_bodies(rng, turns, ends),
        shafts=[_shaft(rng, one, other) for one, other, meshes in ends if not meshes],
        meshes=[_mesh(rng, one, other, turns, sense, looped) for one, other, meshes in ends if meshes],
    )


def name_of(body):
    return f"body {body + 1}"


def _bodies(rng, turns, ends):
    """The first body drives, the last one balances, each at another end and all in a loop bear a load: no mesh is without one.

    A body that turns slower is larger, as a wheel is.
    """
    joints = np.bincount([body for one, other, _ in ends for body in (one, other)], minlength=len(turns))
    torque = rng.uniform(60.0, 240.0)
    bodies = []
    for body, speed in enumerate(turns):
        more = {}
        if body == 0:
            more["torque"] = torque
        elif body == len(turns) - 1:
            more["balances"] = True
        elif joints[body] == 1 or len(ends) == len(turns) or rng.random() < 0.1:
            more["torque"] = -rng.uniform(0.1, 0.3) * torque / speed
        if rng.random() < 0.2:
            more["torque_cos"] = [rng.uniform(-0.2, 0.2) * torque, *([rng.uniform(-0.1, 0.1) * torque] * int(rng.integers(2)))]
            more["torque_sin"] = [rng.uniform(-0.2, 0.2) * torque]
        if rng.random() < 0.15:
            more["damping_to_ground"] = rng.uniform(0.1, 1.0)
        bodies.append(gt.Body(name=name_of(body), inertia=rng.uniform(0.8, 4.0) * (0.05 / speed) ** 2, **more))
    return bodies


def _shaft(rng, one, other):
    return gt.Shaft(between=(name_of(one), name_of(other)), stiffness=10.0 ** rng.uniform(4.0, 6.0),
                    damping_ratio=rng.uniform(0.01, 0.05))


def _mesh(rng, one, other, turns, sense, looped):
    """A mesh; in a loop, where it may rest in its gap, with like flanks, as modes take its drive flank there."""
    radius = rng.uniform(0.03, 0.08)
    more = {"internal": True} if sense[one] == sense[other] else {}
    if rng.random() < 0.8:
        more["half_backlash"] = rng.uniform(5e-6, 60e-6)
        if rng.random() < 0.15:
            more["damping_acts"] = "contact"
        if rng.random() < 0.15 and not looped:
            more["back_stiffness"] = rng.uniform(1e8, 5e8)
            more["back_phase"] = rng.uniform(-1.0, 1.0)
    if rng.random() < 0.4:
        more["phase"] = rng.uniform(0.0, 6.0)
    if rng.random() < 0.3:
        more["error_cos"], more["error_sin"] = [rng.uniform(-5e-6, 5e-6)], [0.0, rng.uniform(-2e-6, 2e-6)]
    if rng.random() < 0.3:
        more["stiffness_sin"] = [rng.uniform(-0.1, 0.1)]
    return gt.Mesh(
        between=(name_of(one), name_of(other)), driving_radius=radius, driven_radius=radius * turns[one] / turns[other],
        stiffness=10.0 ** rng.uniform(8.0, 8.7), damping_ratio=rng.uniform(0.02, 0.08),
        stiffness_cos=[rng.uniform(0.05, 0.35), *([rng.uniform(-0.1, 0.1)] * int(rng.integers(2)))],
        order=int(rng.choice([1, 1, 1, 2])), **more,
    )
