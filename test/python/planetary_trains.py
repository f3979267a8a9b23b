"""Trains with gears on carriers for the tests: planetary stages, Ravigneaux sets, stages in series, a power split, random ones."""

import numpy as np

import geartrain as gt

LENGTH, FREQUENCY = 10e-6, 2e4
ALPHA = np.radians(20.0)
#: Stage of the closed forms: teeth of sun, planet and ring; inertias of sun, planet, ring and carrier [kg m^2].
TEETH, INERTIA = (17, 22, 61), (8.2e-4, 2.2e-3, 0.12, 0.085)


def radius(teeth, module=4e-3):
    """Base radius [m]."""
    return module * teeth / 2 * np.cos(ALPHA)


def train_of(bodies, meshes, shafts=(), **changes):
    values = {"characteristic_length": LENGTH, "characteristic_frequency": FREQUENCY}
    return gt.Train(**{**values, "bodies": bodies, "meshes": meshes, "shafts": list(shafts), **changes})


def mesh_of(one, other, teeth, module=4e-3, **more):
    """A mesh of gears of these numbers of teeth, drawn by their base radii alone."""
    return gt.Mesh(between=(one, other), driving_radius=radius(teeth[0], module), driven_radius=radius(teeth[1], module), **more)


def each(value, planet):
    """The value of a planet of a dictionary entry that is one for all or a tuple with one for each."""
    return value[planet] if isinstance(value, tuple) else value


def stage(planets=3, teeth=TEETH, name="", sun="sun", ring="ring", carrier="arm", sun_mesh=None, ring_mesh=None, phases=False,
          planet=None, module=4e-3):
    """Planets and meshes of a stage; a variable of its meshes is one for all, or a tuple with one for each planet."""
    bodies, suns, rings = [], [], []
    for number in range(planets):
        own = f"{name}planet {number + 1}"
        bodies.append(gt.Body(**{"name": own, "inertia": INERTIA[1],
                                 **{key: each(value, number) for key, value in (planet or {}).items()}}))
        place = number / planets
        for group, ends, joined, more, delay in (
            (suns, (sun, own), (teeth[0], teeth[1]), sun_mesh, teeth[0] * place),
            (rings, (own, ring), (teeth[1], teeth[2]), ring_mesh, -teeth[2] * place),
        ):
            values = {key: each(value, number) for key, value in (more or {}).items()}
            if phases:
                values["phase"] = 2 * np.pi * (delay % 1.0) + values.get("phase", 0.0)
            group.append(mesh_of(*ends, joined, module, carrier=carrier, internal=group is rings, **values))
    return bodies, suns + rings


SUN_MESH = {"stiffness": 1.0e9, "damping_ratio": 0.03, "half_backlash": 20e-6, "stiffness_cos": [0.3, 0.08],
            "error_cos": [2e-6]}
RING_MESH = {"stiffness": 1.2e9, "damping_ratio": 0.035, "half_backlash": 25e-6, "stiffness_cos": [0.2], "stiffness_sin": [0.1],
             "error_sin": [1e-6]}
LINEAR = {"stiffness_cos": None, "stiffness_sin": None, "half_backlash": 0.0}


def planetary(planets=3, teeth=TEETH, held="ring", torque=300.0, sun_mesh=None, ring_mesh=None, phases=True, planet=None,
              bodies=None, first="sun", last="arm", **changes):
    """One stage driven at ``first``; ``last`` balances; ``bodies`` are more variables of bodies by name."""
    more = bodies or {}

    def body(name, inertia, **values):
        if name == held:
            values["held"] = True
        if name == first:
            values["torque"] = torque
        if name == last:
            values["balances"] = True
        return gt.Body(**{"name": name, "inertia": inertia, **values, **more.get(name, {})})

    members = [body("sun", INERTIA[0]), body("ring", INERTIA[2]), body("arm", INERTIA[3])]
    wheels, meshes = stage(planets, teeth, sun_mesh={**SUN_MESH, **(sun_mesh or {})}, ring_mesh={**RING_MESH, **(ring_mesh or {})},
                           phases=phases, planet=planet)
    return train_of([members[0], *wheels, *members[1:]], meshes, **changes)


def ravigneaux(gear=1, torque=250.0, **mesh):
    """A Ravigneaux set: small sun with short planets, large sun and ring with long planets, each pair in mesh on the carrier.

    Gear 1: small sun drives, carrier held. Gear 2: small sun drives, large sun held. Reverse (3): large sun drives, carrier held.
    """
    small, large, short, long, ring = 24, 32, 20, 22, 76
    drive, held = {1: ("small sun", "arm"), 2: ("small sun", "large sun"), 3: ("large sun", "arm")}[gear]
    inertia = {"small sun": 1.1e-3, "large sun": 2.5e-3, "ring": 0.11, "arm": 0.07}
    bodies = [
        gt.Body(name=name, inertia=value, held=name == held, torque=torque if name == drive else None, balances=name == "ring")
        for name, value in inertia.items()
    ]
    groups = ([], [], [], [])
    values = {"stiffness": 0.9e9, "damping_ratio": 0.04, "half_backlash": 20e-6, "stiffness_cos": [0.25],
              "error_cos": [1e-6], **mesh}
    for number in range(2):
        names = f"short {number + 1}", f"long {number + 1}"
        bodies += [gt.Body(name=names[0], inertia=1.3e-3), gt.Body(name=names[1], inertia=1.8e-3)]
        for group, ends, teeth, stiffness, phase in (
            (groups[0], ("small sun", names[0]), (small, short), 0.9e9, 0.0),
            (groups[1], names, (short, long), 0.8e9, 1.1),
            (groups[2], ("large sun", names[1]), (large, long), 1.0e9, 2.3),
            (groups[3], (names[1], "ring"), (long, ring), 1.1e9, 0.4),
        ):
            own = {**values, "stiffness": stiffness, "phase": phase}
            group.append(mesh_of(*ends, teeth, 3e-3, carrier="arm", internal=ends[1] == "ring", **own))
    return train_of(bodies, [mesh for group in groups for mesh in group])


def two_stages(torque=150.0, **changes):
    """Two stages in series with ring gears held, a shaft between them, and wheels of unlike mesh frequencies."""
    one, first = stage(3, name="a ", sun="sun a", ring="housing", carrier="arm a", phases=True,
                       sun_mesh=SUN_MESH, ring_mesh=RING_MESH)
    other, second = stage(3, (21, 24, 69), name="b ", sun="sun b", ring="housing", carrier="arm b", phases=True,
                          sun_mesh={**SUN_MESH, "stiffness": 1.5e9, "order": 2, "half_backlash": 15e-6},
                          ring_mesh={**RING_MESH, "stiffness": 1.8e9, "order": 2, "half_backlash": 18e-6})
    bodies = [
        gt.Body(name="motor", inertia=0.01, torque=torque), gt.Body(name="sun a", inertia=9e-4), *one,
        gt.Body(name="housing", held=True), gt.Body(name="arm a", inertia=0.05), gt.Body(name="sun b", inertia=2e-3), *other,
        gt.Body(name="arm b", inertia=0.2), gt.Body(name="load", inertia=1.0, balances=True),
    ]
    shafts = [gt.Shaft(between=ends, stiffness=value, damping_ratio=0.02) for ends, value in (
        (("motor", "sun a"), 3e4), (("arm a", "sun b"), 2e5), (("arm b", "load"), 8e5))]
    return train_of(bodies, first + second, shafts, **changes)


def power_split(ratio=-0.4, **changes):
    """A differential: engine at the carrier, one motor at the sun, wheels at the ring; sun and ring balance."""
    bodies = {"arm": {"torque": 400.0, "torque_cos": [40.0], "balances": None}, "sun": {"torque": None, "balances": True},
              "ring": {"balances": True, "speed_ratio": ratio}}
    values = {"held": None, "first": "", "last": "", "speed_of": "arm", "bodies": bodies, **changes}
    return planetary(**values)


def random_rows(rng, backlash=False):
    """A train of random rows: speeds of one sense are drawn first, and radii follow from them, so that no loop locks."""
    while True:
        train = _random_rows(rng, backlash)
        if train is not None:
            return train


def _random_rows(rng, backlash):
    count = int(rng.integers(3, 7))
    names = [f"body {number + 1}" for number in range(count)]
    speed = rng.uniform(0.3, 1.5, count) * rng.choice([-1.0, 1.0], count)
    held = np.zeros(count, bool)
    if rng.random() < 0.4:
        held[rng.integers(count)] = True
    speed[held] = 0.0
    wanted = int(rng.choice([1, 1, 2]))
    shafts, meshes, rows, joined = [], [], list(np.eye(count)[held]), np.arange(count)
    for _ in range(40):
        ends = rng.choice(count, 2, replace=False)
        row = np.zeros(count)
        if rng.random() < 0.2 and not held[ends].any():
            # The second body takes the speed of the first while nothing is joined with it.
            if any(abs(row[ends[1]]) > 0 for row in rows):
                continue
            speed[ends[1]] = speed[ends[0]]
            row[ends] = 1.0, -1.0
            shafts.append(gt.Shaft(between=[names[end] for end in ends], stiffness=rng.uniform(0.5e5, 4e5), damping_ratio=0.03))
            members = ends
        else:
            carrier = None if rng.random() < 0.35 else int(rng.integers(count))
            if carrier in ends or (carrier is None and held[ends].any()):
                continue
            relative = speed[ends] - (0.0 if carrier is None else speed[carrier])
            if np.abs(relative).min() < 0.1:
                continue
            ratio = relative[1] / relative[0]
            if not 0.25 < abs(ratio) < 4.0 or abs(ratio - 1) < 0.05:
                continue
            internal = relative[1] / relative[0] > 0
            first = rng.uniform(0.03, 0.08)
            radii = first, first * abs(relative[0] / relative[1])
            row[ends] = radii[0], -radii[1] if internal else radii[1]
            if carrier is not None:
                row[carrier] = -row.sum()
            meshes.append((ends, carrier, dict(
                driving_radius=radii[0], driven_radius=radii[1], internal=internal, stiffness=rng.uniform(2e8, 1e9),
                damping_ratio=rng.uniform(0.03, 0.08), error_cos=[rng.uniform(0.0, 2e-6)], error_sin=[rng.uniform(-1e-6, 1e-6)],
                phase=rng.uniform(0, 2 * np.pi), order=int(rng.choice([1, 1, 2])))))
            members = ends if carrier is None else (*ends, carrier)
        rows.append(row / np.abs(row).max())
        for member in members:
            joined[joined == joined[member]] = joined[members[0]]
        if count - np.linalg.matrix_rank(rows, tol=1e-9) <= wanted and len(set(joined)) == 1 and rng.random() < 0.7:
            break
    if not meshes or len(set(joined)) > 1 or (np.abs(rows).max(axis=0) == 0).any():
        return None
    _, values, vectors = np.linalg.svd(np.array(rows))
    motions = vectors[int((values > 1e-9 * values[0]).sum()):].T
    if not motions.shape[1] or motions.shape[1] > 2:
        return None
    more = [{} for _ in names]
    if rng.random() < 0.25:  # a spring to ground for each motion: the train cannot turn
        for body in rng.choice(np.flatnonzero(~held), motions.shape[1], replace=False):
            more[body]["stiffness_to_ground"] = rng.uniform(1e5, 1e6)
            rows.append(np.eye(count)[body])
        motions = motions[:, :0]
        if np.linalg.matrix_rank(rows, tol=1e-9) < count:
            return None
    elif np.abs(motions).max(axis=1)[~held].min() < 1e-6:
        return None
    balancing = _balance(rng, motions, speed, more, ~held)
    if balancing is None:
        return None
    for body in np.flatnonzero(~held):
        if body not in balancing:
            more[body]["torque"] = rng.uniform(-150.0, 150.0)
        if rng.random() < 0.3:
            more[body]["torque_cos"], more[body]["torque_sin"] = [rng.uniform(-30.0, 30.0)], [0.0, rng.uniform(-20.0, 20.0)]
        if rng.random() < 0.25:
            more[body]["damping_to_ground"] = rng.uniform(0.5, 5.0)
    bodies = [gt.Body(name=name, held=bool(still), inertia=None if still else rng.uniform(1e-3, 2e-2), **values)
              for name, still, values in zip(names, held, more)]
    law = {}
    if backlash:
        law = {"half_backlash": rng.uniform(5e-6, 20e-6), "stiffness_cos": [rng.uniform(0.1, 0.3)], "stiffness_sin": [0.0, 0.05]}
    return train_of(bodies, [
        gt.Mesh(between=[names[end] for end in ends], carrier=None if carrier is None else names[carrier], **values, **law)
        for ends, carrier, values in meshes], shafts)


def _balance(rng, motions, speed, more, moving):
    """Chooses the balancing bodies and, of two motions, the body whose speed is given; None where none will do."""
    if not motions.shape[1]:
        return []
    bodies = np.flatnonzero(moving)
    balancing = list(rng.choice(bodies, motions.shape[1], replace=False))
    if np.linalg.svd(motions[balancing], compute_uv=False)[-1] < 0.05:
        return None
    if motions.shape[1] == 2:
        given = int(rng.choice(bodies[1:]))
        ratio = speed[given] / speed[bodies[0]]
        if abs(np.linalg.norm(motions[given] - ratio * motions[bodies[0]])) < 0.05:
            return None
        more[given]["speed_ratio"] = ratio
    for body in balancing:
        more[body]["balances"] = True
    return balancing
