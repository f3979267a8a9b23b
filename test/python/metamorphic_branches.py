"""Analyses of branches and modes of a train and its image, whose results are compared."""

from copy import copy
from dataclasses import replace

import numpy as np
from comparisons import (
    BALANCE,
    CURVE,
    PLACE,
    SHOOTING,
    close,
    points_of,
    same_motion,
    same_multipliers,
    same_points,
    same_waveform,
)
from transformations import amplitudes, plain

from geartrain.errors import SolverError

#: Special points of a branch that are likely to be far apart.
FEW = 10


class Plan:
    """What is asked of a train, at random: a range of Lambda about a resonance of a mesh, and a frequency in the range."""

    def __init__(self, train, rng):
        modes, numbers = train.modes(), plain(train)
        meshes = [name.startswith("mesh") for name in modes.element]
        order = int(rng.choice([mesh.order or 1 for mesh in numbers.meshes]))
        mode = int(rng.choice(np.flatnonzero(np.abs(modes.shape[:, meshes]).max(1) > 0.3)))
        middle = modes.natural_frequency[mode] / order
        self.start, self.stop = middle * rng.uniform(0.7, 0.85), middle * rng.uniform(1.0, 1.1)
        self.frequency = rng.uniform(self.start, self.stop)
        self.harmonics = 6 * max(mesh.order or 1 for mesh in numbers.meshes)
        self.seed, self.mesh = int(rng.integers(1000)), int(rng.integers(len(train.meshes)))
        self.variation = max(np.abs(amplitudes(mesh.stiffness_cos, mesh.stiffness_sin)).max(initial=0.0) for mesh in numbers.meshes)
        self.fraction = rng.uniform(0.3, 0.7)

    def range(self, image):
        return {"start": self.start * image.frequency, "stop": self.stop * image.frequency}

    def order(self, image):
        """Harmonics of the image."""
        return self.harmonics * image.cycles * image.subharmonic


class NothingFoundError(Exception):
    """Neither the train nor its image has what is looked for."""


def both(*calls):
    """What the calls give; none of them may find nothing alone."""
    results, failed = [], []
    for call in calls:
        try:
            results.append(call())
        except SolverError as error:
            failed.append(str(error))
    if len(failed) == len(calls):
        raise NothingFoundError(failed[0])
    assert not failed, failed[0]
    return results


def respond(train, image, plan, **settings):
    """The branches of a train and of its image."""
    more = {"subharmonic": image.subharmonic} if image.subharmonic > 1 else {}
    known, found = both(
        lambda: train.response(start=plan.start, stop=plan.stop, harmonics=plan.harmonics, **settings),
        lambda: image.train.response(**plan.range(image), harmonics=plan.order(image), step=image.step, **more, **settings))
    return same_beginning(known, found, image)


def same_beginning(known, found, image):
    """Two branches that are to be the same.

    One of a longer period may begin with a motion that has this period itself. How far a branch gets that does not get through its
    range depends on its steps, and these on how the meshes are weighed.
    """
    if image.weighs and not (known.complete and found.complete):
        raise NothingFoundError("a branch in part")
    if image.subharmonic > 1 and not np.allclose(found.rms[0], known.rms[0], rtol=1e-4):
        raise NothingFoundError("the image begins with a motion of a longer period")
    return known, found


def modes(train, image, plan):
    """Frequencies to rounding: that of a square, relative to the largest square."""
    known, found = train.modes(), image.train.modes()
    frequency = known.natural_frequency
    factor = image.frequency * image.cycles
    # Two halves of a mesh in parallel are one element more but no mode more.
    rounding = 1e-13 * max(frequency.max() / frequency.min(), 10) ** 2
    close(found.natural_frequency / factor, frequency, rounding, "frequency", frequency)
    # A damping ratio near 1 is that of a nearly double eigenvalue.
    close(found.damping_ratio, known.damping_ratio, 1e-7, "damping ratio", 1.0)
    parts = [np.array([name.startswith("mesh") for name in side.element]) for side in (known, found)]
    for mode, (one, other) in enumerate(zip(known.shape, found.shape)):
        if np.abs(np.delete(frequency, mode) / frequency[mode] - 1).min(initial=1.0) < 1e-3:
            continue  # of close modes any mixture is one
        wanted, have = one[parts[0]][image.meshes] * image.displacement, other[parts[1]]
        wanted, have = (shape / max(shape, key=abs) if np.abs(shape).max() > 1e-6 else 0 * shape for shape in (wanted, have))
        close(have, wanted, 1e-6, f"shape {mode + 1}", 1.0)


def response(train, image, plan):
    """Motions at a frequency, special points and jumps of the balance."""
    known, found = respond(train, image, plan)
    assert known.complete == found.complete, f"{known.ended}; {found.ended}"
    motions, images = known.at(plan.frequency), found.at(plan.frequency * image.frequency)
    near = min((abs(point.frequency / plan.frequency - 1) for point in known.special_points), default=1.0)
    if near > 1e-5:
        assert len(motions) == len(images), f"{len(images)} motions, {len(motions)}"
        for number, (motion, other) in enumerate(zip(motions, images), 1):
            same_motion(other, motion, image, BALANCE / near, f"motion {number}")
            same_waveform(other, motion, image, BALANCE / near, f"motion {number}")
            same_multipliers(other, motion, image, BALANCE / near, f"motion {number}")
    same_points(known, found, image)
    if image.subharmonic == 1:
        # A jump that an undecided point makes is a guess.
        jumps = [[jump for jump in branch.jumps if is_clear(jump, branch)] for branch in (known, found)]
        if not any(jump.undecided for branch in (known, found) for jump in branch.jumps):
            words = [[(jump.kind, jump.direction, jump.cause) for jump in side] for side in jumps]
            if image.weighs:
                # Which of two motions is the larger one depends on how many meshes count, and on the gauge of each.
                words = [[(direction, cause) for _, direction, cause in side] for side in words]
            assert words[0] == words[1], f"jumps {words}"


def units_of_motion(point):
    """Largest displacement of a motion times the frequency of the fastest mesh, as far as the order tells it."""
    orders = [mesh.order or 1 for mesh in plain(point.motion.train).meshes]
    return point.frequency * max(orders) * max(np.abs([point.motion.minimum, point.motion.maximum]).max(), 1e-300)


def is_clear(jump, branch):
    """Whether a jump is at an end of a stable stretch that a step cannot miss."""
    others = [point.frequency for point in branch.special_points if point is not jump.special_point]
    return min(np.abs(np.array(others) / jump.frequency - 1), default=1.0) > 1e-2


def is_alone(one, exact, branch):
    """Whether an exact point is much nearer to a special point of the balance than others of the kind are."""
    alike = [point for point in branch.special_points if point is not one and point.kind == one.kind]
    others = [abs(point.frequency - one.frequency) for point in alike]
    return abs(exact.frequency - one.frequency) < 0.1 * min(others, default=np.inf)


def exact(train, image, plan):
    """Each special point of the exact motion, by shooting; one that grazes an edge is known to the root of it."""
    known, found = respond(train, image, plan)
    same_points(known, found, image)
    for one, other in zip(*(points_of(branch, image) for branch in (known, found))):
        points = []
        for point in (one, other):
            try:
                points.append(point.exact())
            except SolverError:
                points.append(None)
        if None in points:
            # A search steps by a metric in which each mesh counts as its gauge has it, and twice where it is two.
            assert points[0] is points[1] or image.weighs, f"{one.kind} at {one.frequency}: {points}"
            continue
        wanted, have = points
        if not (is_alone(one, wanted, known) and is_alone(other, have, found)):
            continue  # which of two is the nearest depends on what counts as a distance
        assert have.kind == wanted.kind
        close(have.frequency, wanted.frequency * image.frequency, SHOOTING, f"exact {one.kind}")
        if image.subharmonic == 1:
            # Beyond a grazing M changes as a square root does: next to it the normal form depends on how far its differences go.
            units = units_of_motion(wanted)
            grazing = wanted.slowest_event is not None and wanted.slowest_event < 0.1 * units
            sides = [(side.before, side.after, "" if grazing else side.criticality) for side in (wanted, have)]
            assert sides[0] == sides[1], f"exact {one.kind}: {sides}"
        same_motion(have.motion, wanted.motion, image, SHOOTING**0.5, f"exact {one.kind}")


def refine(train, image, plan):
    """Motions at a frequency by shooting, with their multipliers; one next to a fold is known to the root."""
    known, found = respond(train, image, plan)
    motions, images = known.at(plan.frequency), found.at(plan.frequency * image.frequency)
    if len(motions) != len(images):
        return response(train, image, plan)
    for number, pair in enumerate(zip(motions, images), 1):
        exact = []
        for motion in pair:
            try:
                exact.append(motion.refine())
            except SolverError:
                exact.append(None)
        assert (exact[0] is None) == (exact[1] is None), f"motion {number}: refined {exact}"
        if exact[0] is not None:
            near = np.abs(exact[0].multipliers - 1).min()
            same_motion(exact[1], exact[0], image, SHOOTING / near, f"refined {number}")
            same_multipliers(exact[1], exact[0], image, SHOOTING / near, f"refined {number}")
    return None


def refined_branch(train, image, plan):
    """Special points of a branch that is refined as a whole."""
    part = copy(plan)
    part.stop = plan.start + (plan.stop - plan.start) / 3
    known, found = respond(train, image, part, refine=True)
    if any(np.isnan(point.correction) for branch in (known, found) for point in branch.special_points):
        same_points(known, found, image, 1e-2)
    else:
        same_points(known, found, image, SHOOTING)


def gradient(train, image, plan):
    """Derivatives of figures of a motion and of the Lambda of folds over the variation of all mesh stiffnesses."""
    known, found = respond(train, image, plan)
    motions, images = known.at(plan.frequency), found.at(plan.frequency * image.frequency)
    same_points(known, found, image)
    for motion, other in zip(motions, images):
        wanted, have = (side.gradient("rms", ["stiffness_variation"])[:, 0] for side in (motion, other))
        near = np.abs(motion.multipliers - 1).min()
        close(have, wanted[image.meshes] * image.displacement, BALANCE / near, "gradient",
              np.abs(wanted[image.meshes] * image.displacement) + motion.rms[image.meshes] * image.displacement)
    if len(known.special_points) > FEW:
        return  # the point of the balance itself may be nearer to another special point
    kinds = ("fold", "period doubling") if image.subharmonic == 1 else ("fold",)
    for one, other in zip(*([point for point in branch.special_points if point.kind in kinds] for branch in (known, found))):
        wanted, have = (side.gradient(["stiffness_variation"]) for side in (one, other))
        close(have, wanted * image.frequency, CURVE, f"gradient of a {one.kind}", one.frequency * image.frequency)


def over_parameter(train, image, plan):
    """A branch over the variation of the mesh stiffnesses."""
    low, high = 0.6 * plan.variation, 1.1 * plan.variation
    value = low + plan.fraction * (high - low)
    more = {"subharmonic": image.subharmonic} if image.subharmonic > 1 else {}
    ends = {"parameter": "stiffness_variation", "start": low, "stop": high}
    known, found = both(
        lambda: train.continuation(frequency=plan.frequency, harmonics=plan.harmonics, **ends),
        lambda: image.train.continuation(frequency=plan.frequency * image.frequency, harmonics=plan.order(image), step=image.step,
                                         **more, **ends))
    same_beginning(known, found, image)
    assert known.complete == found.complete, f"{known.ended}; {found.ended}"
    motions, images = known.at(value), found.at(value)
    near = min((abs(point.parameter / value - 1) for point in known.special_points), default=1.0)
    if near > 1e-5:
        assert len(motions) == len(images), f"{len(images)} motions, {len(motions)}"
        for motion, other in zip(motions, images):
            same_motion(other, motion, image, BALANCE / near, f"at {value}")
    same_points(known, found, image)


def locus(train, image, plan):
    """The curve of the first special point over the variation of the mesh stiffnesses: its ends, and places between them."""
    known, found = respond(train, image, plan)
    same_points(known, found, image)
    kinds = ("fold", "period doubling", "neimark-sacker") if image.subharmonic == 1 else ("fold",)
    points = [[point for point in branch.special_points if point.kind in kinds] for branch in (known, found)]
    for one, other in list(zip(*points))[:1]:
        curves = []
        for of, point in ((train, one), (image.train, other)):
            try:
                curves.append(of.locus(point, parameter="stiffness_variation", start=0.99 * plan.variation,
                                       stop=1.01 * plan.variation))
            except SolverError:
                curves.append(None)
        assert (curves[0] is None) == (curves[1] is None), f"{one.kind} at {one.frequency}: {curves}"
        if curves[0] is None:
            continue
        wanted, have = curves
        # The curve of a motion of period 2 ends where it doubles that of period 1; the curve of the latter goes on.
        assert wanted.complete == have.complete or image.subharmonic > 1, f"{wanted.ended}; {have.ended}"
        ends = [np.sort_complex(curve.parameter[[0, -1]] / plan.variation + 1j * curve.frequency[[0, -1]] / factor)
                for curve, factor in ((wanted, 1.0), (have, image.frequency))]
        if wanted.complete and have.complete:
            close(np.abs(ends[1] - ends[0]), [0.0, 0.0], PLACE, f"ends of the curve of a {one.kind} {ends}", one.frequency)
        if image.subharmonic == 1:
            names = [sorted(point.kind for point in curve.special_points) for curve in curves]
            assert names[0] == names[1], f"special points of a curve {names}"


def stability_map(train, image, plan):
    """Largest multipliers over frequency and the variation of the mesh stiffnesses, with and without backlash."""
    # Back flanks of another stiffness have no place in a linear map, a drawing none in a map over its kappa.
    numbers = plain(train)
    if numbers is not train:
        train, image = numbers, replace(image, train=plain(image.train))
    for linear in (True, False):
        if linear and any(mesh.back_stiffness for mesh in train.meshes):
            continue
        settings = {"points": 3, "parameter_start": 0.5 * plan.variation, "parameter_stop": 1.1 * plan.variation,
                    "parameter_points": 2, "linear": linear}
        known = train.stability_map(start=plan.start, stop=plan.stop, harmonics=plan.harmonics, **settings)
        found = image.train.stability_map(**plan.range(image), harmonics=plan.order(image), **settings)
        assert (known.row_whole == found.row_whole).all()
        assert (known.motions == found.motions).all(), f"motions {known.motions}, {found.motions}"
        decided = np.abs(np.abs(known.multiplier) - 1) > BALANCE**0.5
        counts = [side.stable_motions[decided].tolist() for side in (known, found)]
        assert counts[0] == counts[1] or not linear, f"stable motions {counts}, multipliers {known.multiplier}, {found.multiplier}"
        power = image.cycles
        wanted = np.abs(known.multiplier) ** power
        close(np.abs(found.multiplier), wanted, power * BALANCE**0.5, "multipliers", np.maximum(wanted, 1e-3))
