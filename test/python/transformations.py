"""Transformations of a train that leave its physics as they are, and what becomes of a result."""

from dataclasses import dataclass, replace

import numpy as np

import geartrain as gt


@dataclass(frozen=True)
class Image:
    """A transformed train, and how its results follow from those of the train that it is the image of.

    Attributes
    ----------
    train : Train
    meshes, shafts : ndarray of int
        For each mesh and shaft of the image the index of the original one; -1 of a shaft that is new.
    displacement, force, torque : ndarray
        Factors of displacements and forces of the meshes of the image, and of torques of its shafts.
    mirrored : bool
        Whether all displacements have the other sign.
    frequency : float
        Lambda of the image over that of the original.
    seconds : float
        Times in seconds of the image over those of the original.
    phase : float
        By which the fundamental of the image lags [rad].
    cycles : int
        Periods of the original's fundamental in one of the image's.
    subharmonic : int
        Periods of the fundamental in which a motion of period 1 is looked for.
    step : float
        Largest step along branches of the image.
    rest, starts : bool
        Whether the state at rest at phase 0 is that of the original, and whether random starts are.
    """

    train: gt.Train
    meshes: np.ndarray
    shafts: np.ndarray
    displacement: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    mirrored: bool = False
    frequency: float = 1.0
    seconds: float = 1.0
    phase: float = 0.0
    cycles: int = 1
    subharmonic: int = 1
    step: float = 0.05
    rest: bool = True
    starts: bool = True

    @property
    def weighs(self):
        """Whether meshes count otherwise in a norm over all of them: by another gauge, or twice."""
        return len(set(self.meshes)) < len(self.meshes) or np.ptp(self.displacement / self.displacement[0]) > 1e-9


def unchanged(train, image=None, **changes):
    """The image of a train, the train itself unless given, whose results are those of the train but for the changes."""
    meshes, shafts = len(train.meshes), len(train.shafts)
    return replace(
        Image(image or train, np.arange(meshes), np.arange(shafts), np.ones(meshes), np.ones(meshes), np.ones(shafts)), **changes)


def plain(train):
    """A train of a drawing by plain numbers."""
    if not any(mesh.teeth for mesh in train.meshes):
        return train
    told = train.explain()
    bodies = [replace(body, inertia=told[body.name]["inertia"]) for body in train.bodies]
    shafts = [gt.Shaft(between=shaft.between, stiffness=told[f"shaft {number}"]["stiffness"], damping_ratio=shaft.damping_ratio)
              for number, shaft in enumerate(train.shafts, 1)]
    meshes = []
    for number, mesh in enumerate(train.meshes, 1):
        known = told[f"mesh {number}"]
        driving, driven = known["base_radius"]
        # What is told of kappa has the phase in it.
        cosines, sines = turned(known.get("stiffness_cos"), known.get("stiffness_sin"), -(mesh.phase or 0.0))
        meshes.append(gt.Mesh(
            between=mesh.between, driving_radius=driving, driven_radius=driven, damping_ratio=mesh.damping_ratio,
            stiffness=known.get("stiffness", mesh.stiffness), half_backlash=known["half_backlash"], order=int(known["order"]),
            stiffness_cos=cosines, stiffness_sin=sines, error_cos=mesh.error_cos, error_sin=mesh.error_sin, phase=mesh.phase))
    return gt.Train(bodies=bodies, shafts=shafts, meshes=meshes,
                    **{name: told["train"][name] for name in ("characteristic_length", "characteristic_frequency")})


def times(series, factor):
    """A series of amplitudes times a factor."""
    return None if series is None else [factor * value for value in np.atleast_1d(series)]


def amplitudes(cosines, sines):
    """Complex amplitudes a - i b of series of cosine and sine amplitudes."""
    cosines, sines = (np.atleast_1d([] if series is None else series) for series in (cosines, sines))
    found = np.zeros(max(len(cosines), len(sines)), complex)
    found[: len(cosines)] += cosines
    found[: len(sines)] -= 1j * sines
    return found


def turned(cosines, sines, angle):
    """Series of amplitudes whose harmonics 1, 2, ... lag by 1, 2, ... times the angle."""
    lagging = amplitudes(cosines, sines)
    lagging = lagging * np.exp(-1j * angle * np.arange(1, len(lagging) + 1))
    return (list(lagging.real), list(-lagging.imag)) if len(lagging) else (None, None)


def _torques(body, factor):
    return replace(body, **{name: times(getattr(body, name), factor) for name in ("torque_cos", "torque_sin")},
                   torque=factor * (body.torque or 0.0))


def mirror(train, rng, starts):
    """All torques and transmission errors have the other sign: what the drive flanks bore the back flanks bear."""
    train = plain(train)
    meshes = []
    for mesh in train.meshes:
        changed = replace(mesh, error_cos=times(mesh.error_cos, -1), error_sin=times(mesh.error_sin, -1))
        if mesh.back_stiffness:
            phase = mesh.back_phase or 0.0
            cosines, sines = turned(mesh.stiffness_cos, mesh.stiffness_sin, phase)
            changed = replace(changed, stiffness=mesh.back_stiffness, back_stiffness=mesh.stiffness, back_phase=-phase,
                              stiffness_cos=cosines, stiffness_sin=sines,
                              damping_ratio=mesh.damping_ratio * (mesh.stiffness / mesh.back_stiffness) ** 0.5)
        meshes.append(changed)
    image = unchanged(replace(train, bodies=[_torques(body, -1) for body in train.bodies], meshes=meshes))
    return replace(image, mirrored=True, torque=-image.torque, starts=False)


def names(train, rng, starts):
    """Bodies, shafts and meshes have other names and another order; a shaft may begin at its other end."""
    new = {body.name: f"{rng.integers(1000)} {chr(97 + place)}" for place, body in enumerate(train.bodies)}
    loops = len(train.shafts) + len(train.meshes) >= len(train.bodies)
    order = rng.permutation(len(train.bodies))
    bodies = [replace(train.bodies[i], name=new[train.bodies[i].name]) for i in order]
    shafts, sign = rng.permutation(len(train.shafts)), rng.choice([-1.0, 1.0], len(train.shafts))
    # Random starts go by the order of the meshes; in a loop the order also chooses which mesh closes it.
    meshes = np.arange(len(train.meshes)) if starts else rng.permutation(len(train.meshes))

    def ends(part, sign=1):
        return tuple(new[name] for name in part.between)[:: int(sign)]

    changed = replace(
        train, bodies=bodies, shafts=[replace(train.shafts[i], between=ends(train.shafts[i], sign[i])) for i in shafts],
        meshes=[replace(train.meshes[i], between=ends(train.meshes[i])) for i in meshes],
        speed_of=new[train.speed_name])
    return unchanged(changed, shafts=shafts, torque=sign[shafts], meshes=meshes, starts=starts and not loops)


def splitting(train, rng, starts):
    """The inertia of a body is on two bodies that a rigid shaft joins, and what it was joined to is on either of them."""
    train = plain(train)
    place = int(rng.integers(len(train.bodies)))
    body, share = train.bodies[place], float(rng.choice([0.0, rng.uniform(0.1, 0.9)]))
    parts = [replace(body, inertia=body.inertia * (1 - share)),
             gt.Body(name="other part", inertia=body.inertia * share)]
    inertia = {body.name: body.inertia for body in train.bodies}

    def moved(part):
        return replace(part, between=tuple("other part" if name == body.name and share and rng.random() < 0.5 else name
                                           for name in part.between))

    def damped(mesh):
        """The mesh with its damping given: a ratio would be that of the inertia of one part alone."""
        mobility = sum(radius**2 / inertia[name] for name, radius in zip(mesh.between, (mesh.driving_radius, mesh.driven_radius)))
        return replace(mesh, damping_ratio=None, damping=2 * mesh.damping_ratio * (mesh.stiffness / mobility) ** 0.5)

    def twisted(shaft):
        """The shaft with its damping given, likewise."""
        if shaft.rigid or not shaft.damping_ratio:
            return shaft
        mobility = sum(1 / inertia[name] for name in shaft.between)
        return replace(shaft, damping_ratio=None, damping=2 * shaft.damping_ratio * (shaft.stiffness / mobility) ** 0.5)

    changed = replace(
        train, bodies=[*train.bodies[:place], *parts, *train.bodies[place + 1 :]],
        meshes=[moved(damped(mesh)) for mesh in train.meshes],
        shafts=[*(moved(twisted(shaft)) for shaft in train.shafts), gt.Shaft(between=(body.name, "other part"), rigid=True)])
    shafts = len(train.shafts)
    return unchanged(train, changed, shafts=np.append(np.arange(shafts), -1), torque=np.ones(shafts + 1))


def homogeneity(train, rng, starts):
    """All torques, gaps and transmission errors are larger by one factor."""
    train, factor = plain(train), 10.0 ** rng.uniform(-4, 4)
    meshes = [replace(mesh, error_cos=times(mesh.error_cos, factor), error_sin=times(mesh.error_sin, factor),
                      half_backlash=factor * (mesh.half_backlash or 0.0)) for mesh in train.meshes]
    image = unchanged(replace(train, bodies=[_torques(body, factor) for body in train.bodies], meshes=meshes))
    return replace(image, displacement=factor * image.displacement, force=factor * image.force, torque=factor * image.torque)


def units(train, rng, starts):
    """Characteristic length and frequency are others, and all numbers are in other units of mass, length and time."""
    given = train
    train = plain(train)
    length, frequency = 10.0 ** rng.uniform(-4, 4, 2)
    kilogram, metre, second = (1.0, 1.0, 1.0) if rng.random() < 0.4 else 10.0 ** rng.uniform(-2, 2, 3)
    newton = kilogram * metre / second**2
    bodies = [replace(_torques(body, newton * metre), inertia=body.inertia * kilogram * metre**2,
                      damping_to_ground=(body.damping_to_ground or 0.0) * newton * metre * second) for body in train.bodies]
    shafts = [replace(shaft, stiffness=shaft.stiffness * newton * metre) for shaft in train.shafts]
    meshes = []
    for mesh in train.meshes:
        lengths = {name: None if getattr(mesh, name) is None else getattr(mesh, name) * metre
                   for name in ("driving_radius", "driven_radius", "half_backlash")}
        stiffnesses = {name: None if getattr(mesh, name) is None else getattr(mesh, name) * newton / metre
                       for name in ("stiffness", "back_stiffness")}
        errors = {name: times(getattr(mesh, name), metre) for name in ("error_cos", "error_sin")}
        meshes.append(replace(mesh, **lengths, **stiffnesses, **errors))
    values = {"characteristic_length": train.characteristic_length * length * metre,
              "characteristic_frequency": train.characteristic_frequency * frequency / second}
    if kilogram == metre == second == 1:
        changed = replace(given, **values)
    else:
        changed = replace(train, bodies=bodies, shafts=shafts, meshes=meshes, **values)
    image = unchanged(changed)
    return replace(image, displacement=image.displacement / length, frequency=1 / frequency, force=newton * image.force,
                   torque=newton * metre * image.torque, seconds=second)


def gauge(train, rng, starts):
    """The base radii of each mesh are larger by a factor of its own, and its kappa may be a table of the stiffness."""
    train = plain(train)
    factors = 10.0 ** rng.uniform(-1, 1, len(train.meshes))
    meshes = []
    for mesh, factor in zip(train.meshes, factors):
        changed = replace(
            mesh, driving_radius=factor * mesh.driving_radius, driven_radius=factor * mesh.driven_radius,
            stiffness=mesh.stiffness / factor**2, half_backlash=factor * (mesh.half_backlash or 0.0),
            back_stiffness=mesh.back_stiffness and mesh.back_stiffness / factor**2,
            error_cos=times(mesh.error_cos, factor), error_sin=times(mesh.error_sin, factor))
        if rng.random() < 0.3:
            changed = replace(changed, stiffness=None, stiffness_cos=None, stiffness_sin=None, stiffness_table=_table(changed))
        meshes.append(changed)
    loops = len(train.shafts) + len(train.meshes) >= len(train.bodies)
    return unchanged(replace(train, meshes=meshes), displacement=factors, force=1 / factors, starts=not loops)


def _table(mesh):
    """The stiffness of a mesh at instants of its cycle, an odd number of them that holds all harmonics."""
    cosines, sines = turned(mesh.stiffness_cos, mesh.stiffness_sin, 0.0)
    harmonics = np.arange(1, len(cosines) + 1)
    instants = np.arange(2 * len(cosines) + 3) * 2 * np.pi / (2 * len(cosines) + 3)
    angles = np.outer(instants, harmonics)
    return list(mesh.stiffness * (1 + np.cos(angles) @ cosines + np.sin(angles) @ sines))


def phase(train, rng, starts):
    """Time begins earlier: all meshes and torques lag."""
    lag = rng.uniform(0.0, 2 * np.pi)
    orders = [mesh.order or 1 for mesh in plain(train).meshes]
    bodies = []
    for body in train.bodies:
        cosines, sines = turned(body.torque_cos, body.torque_sin, lag)
        bodies.append(replace(body, torque_cos=cosines, torque_sin=sines))
    meshes = [replace(mesh, phase=(mesh.phase or 0.0) + order * lag) for mesh, order in zip(train.meshes, orders)]
    return unchanged(replace(train, bodies=bodies, meshes=meshes), phase=lag, rest=False, starts=False)


def parallel(train, rng, starts):
    """One mesh is two with half of its stiffness and damping."""
    train = plain(train)
    place = int(rng.integers(len(train.meshes)))
    mesh = train.meshes[place]
    half = replace(mesh, stiffness=mesh.stiffness / 2, damping_ratio=mesh.damping_ratio / 2**0.5,
                   back_stiffness=mesh.back_stiffness and mesh.back_stiffness / 2)
    loops = len(train.shafts) + len(train.meshes) >= len(train.bodies)
    count = len(train.meshes)
    force = np.ones(count + 1)
    force[[place, count]] = 0.5
    changed = replace(train, meshes=[*train.meshes[:place], half, *train.meshes[place + 1 :], half])
    return unchanged(train, changed, meshes=np.append(np.arange(count), place), force=force,
                     displacement=np.ones(count + 1), starts=not loops)


def orders(train, rng, starts):
    """All orders are multiplied, the frequency of the fundamental is divided."""
    train, factor = plain(train), int(rng.integers(2, 4))

    def spread(series):
        """Amplitudes of the orders 1, 2, ... as those of multiples."""
        return None if series is None else list(np.kron(np.atleast_1d(series), np.eye(1, factor, factor - 1)[0]))

    bodies = [replace(body, torque_cos=spread(body.torque_cos), torque_sin=spread(body.torque_sin)) for body in train.bodies]
    meshes = [replace(mesh, order=factor * (mesh.order or 1)) for mesh in train.meshes]
    return unchanged(replace(train, bodies=bodies, meshes=meshes), cycles=factor, frequency=1 / factor)


def subharmonic(train, rng, starts):
    """A motion of period 1 is one of a longer period."""
    return unchanged(train, subharmonic=int(rng.integers(2, 4)))


TRANSFORMATIONS = {function.__name__: function for function in (
    mirror, names, splitting, homogeneity, units, gauge, phase, parallel, orders, subharmonic)}
