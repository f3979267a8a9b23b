"""Analyses that integrate a train and its image in time, whose results are compared."""

import numpy as np
from comparisons import SETTLED, close, same_flow, same_sections
from metamorphic_branches import NothingFoundError, respond
from transformations import plain

import geartrain as gt
from geartrain.errors import SolverError


def seeds_of(train, image, plan):
    """What a flow begins with: nothing, that is rest, or a stable motion where the image is not at rest at the same time."""
    if image.rest:
        return (), ()
    known, found = respond(train, image, plan)
    for motion, other in zip(known.at(plan.frequency), found.at(plan.frequency * image.frequency)):
        if motion.stable and not motion.undecided:
            return (motion.refine(),), (other.refine(),)
    raise NothingFoundError("no stable motion")


def integrate(train, image, plan):
    """The motion from rest."""
    seeds = seeds_of(train, image, plan)
    same_flow(image.train.integrate(plan.frequency * image.frequency, start=next(iter(seeds[1]), None)),
              train.integrate(plan.frequency, start=next(iter(seeds[0]), None)), image, "motion")


def sweep(train, image, plan):
    """Motions at one frequency after another, up and down."""
    known = train.sweep(start=plan.start, stop=plan.stop, points=3, direction="both", max_periods=500)
    found = image.train.sweep(**plan.range(image), points=3, direction="both", max_periods=500)
    for place, (motion, other) in enumerate(zip(known, found)):
        same_flow(other, motion, image, f"motion {place}")


def attractors(train, image, plan):
    """Motions on which random starts settle, and their shares."""
    settings = {"starts": 6, "random_seed": plan.seed}
    known = train.attractors(plan.frequency, max_periods=300, **settings)
    found = image.train.attractors(plan.frequency * image.frequency, max_periods=300 // image.cycles, **settings)
    assert found.unsettled == known.unsettled
    assert len(found) == len(known), f"{[motion.share for motion in found]}, {[motion.share for motion in known]}"
    pairs = [sorted(side, key=lambda motion: (-round(motion.share, 6), motion.period == 0, motion.rms[place]))
             for side, place in ((known, image.meshes[0]), (found, 0))]
    for motion, other in zip(*pairs):
        assert motion.share == other.share, f"shares {motion.share}, {other.share}"
        same_flow(other, motion, image, "attractor")


def basins(train, image, plan):
    """The motion that each start of a grid reaches; of a mirrored train the grid is mirrored."""
    settings = {"points": (3, 3), "starts": 4, "random_seed": plan.seed}
    known = train.basins(plan.frequency, mesh=plan.mesh + 1, max_periods=180, **settings)
    mesh = int(np.flatnonzero(image.meshes == plan.mesh)[0])
    found = image.train.basins(plan.frequency * image.frequency, mesh=mesh + 1, max_periods=180 // image.cycles, **settings)
    factor = image.displacement[mesh]
    close(found.displacement, known.displacement * factor, 1e-9, "displacements of the grid")
    close(found.velocity, known.velocity * factor * image.frequency * image.cycles, 1e-9, "velocities of the grid")
    label = found.label[::-1, ::-1] if image.mirrored else found.label
    for one, other in zip(known.label.ravel(), label.ravel()):
        motions = [side.motions[place - 1] if place > 0 else None for side, place in ((known, one), (found, other))]
        periodic = [motion is not None and motion.kind == "periodic" for motion in motions]
        # A start that is given up may settle within the longer periods of the image; what has no period may be still settling.
        assert periodic[0] == periodic[1] or image.cycles > 1, f"labels {known.label}, {label}"
        if all(periodic):
            same_flow(motions[1], motions[0], image, "motion of a basin")


def lyapunov_spectrum(train, image, plan):
    """Kind, period, sections and exponents at a frequency."""
    seeds = seeds_of(train, image, plan)
    sides = []
    for of, factor, seed in ((train, 1.0, seeds[0]), (image.train, image.frequency, seeds[1])):
        try:
            sides.append(of.lyapunov_spectrum(plan.frequency * factor, transient=200, periods=60, start=next(iter(seed), None)))
        except SolverError as error:
            assert "unbounded" in str(error) or "grows" in str(error), error
            sides.append(None)
    assert (sides[0] is None) == (sides[1] is None), "unbounded"
    if sides[0] is not None:
        same_sections(sides[1], sides[0], image, "spectrum")


def bifurcation_diagram(train, image, plan):
    """Kinds and exponents up and down."""
    settings = {"points": 2, "transient": 200, "sections": 48}
    known = train.bifurcation_diagram(start=plan.start, stop=plan.stop, **settings)
    found = image.train.bifurcation_diagram(**plan.range(image), **settings)
    for place in range(len(known.frequency)):
        sides = []
        for diagram in (known, found):
            sides.append(gt.LyapunovSpectrum(
                frequency=diagram.frequency[place], exponents=diagram.lyapunov_exponents[place],
                errors=diagram.lyapunov_errors[place], kind=diagram.kind[place], period=int(diagram.period[place]),
                rotation_number=diagram.rotation_number[place], displacement=diagram.displacement[place],
                velocity=diagram.velocity[place], state=diagram.final_state[place]))
        same_sections(sides[1], sides[0], image, f"point {place}")


def run_up(train, image, plan):
    """Extremes of forces and torques while the speed rises; inertias take no torque of a train without teeth."""
    duration = 40 * 2 * np.pi / (plain(train).characteristic_frequency * plan.start)
    known = train.run_up(start=plan.start, stop=plan.stop, duration=duration, max_periods=300)
    found = image.train.run_up(**plan.range(image), duration=duration * image.seconds,
                               max_periods=300 // image.cycles)
    assert found.complete == known.complete, f"{found.ended}, {known.ended}"
    if not known.complete or (image.cycles > 1 and not (known.start_period and found.start_period)):
        return  # what has not settled within so many periods goes on within so many longer ones
    assert (found.start_period == 0) == (known.start_period == 0), f"start {found.start_period}, {known.start_period}"
    low, high = (side[image.meshes] * image.force for side in (known.mesh_force_minimum.min(0), known.mesh_force_maximum.max(0)))
    if image.mirrored:
        low, high = -high, -low
    scale = np.maximum(np.abs(low), np.abs(high)).max()
    close([found.mesh_force_minimum.min(0), found.mesh_force_maximum.max(0)], [low, high], SETTLED, "forces", scale)
    old = image.shafts >= 0
    ends = np.sort([known.shaft_torque_minimum.min(0)[image.shafts[old]] * image.torque[old],
                    known.shaft_torque_maximum.max(0)[image.shafts[old]] * image.torque[old]], axis=0)
    close([found.shaft_torque_minimum.min(0)[old], found.shaft_torque_maximum.max(0)[old]], ends, SETTLED, "torques",
          np.abs(ends).max(initial=0.0))
