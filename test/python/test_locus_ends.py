"""Ends of curves of special points: told as values and in the unit of the train; motions of very many cycles are refused."""

import pickle
import time
from dataclasses import replace

import pytest
from conftest import paper_train

import geartrain as gt


@pytest.fixture(scope="module")
def train():
    """A stage of teeth from a drawing, whose frequencies are speeds in rpm."""
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(23, 59), normal_module=2.5e-3, face_width=0.03, backlash=6e-5,
                   damping_ratio=0.04, stiffness_harmonics=2)
    bodies = [gt.Body(name="motor", inertia=0.005, torque=60.0), gt.Body(name="pinion"), gt.Body(name="wheel"),
              gt.Body(name="load", inertia=0.3, balances=True)]
    shafts = [gt.Shaft(between=("motor", "pinion"), stiffness=2e4, damping_ratio=0.02),
              gt.Shaft(between=("wheel", "load"), stiffness=1e5, damping_ratio=0.02)]
    return gt.Train(bodies=bodies, shafts=shafts, meshes=[mesh])


def test_the_end_of_the_range(train):
    fold = train.response(start=6800.0, stop=7900.0, unit="rpm").special_points[0]
    locus = train.locus(fold, parameter="motor torque", start=55.0, stop=65.0)
    assert locus.complete and locus.ends == ("range", "range")


def test_a_curve_that_ends_at_a_corner_says_so(train):
    """In the value `ends`, at its last point and in words, in rpm as all frequencies of the train."""
    special = train.response(start=13900.0, stop=14700.0, unit="rpm").special_points
    fold = min((point for point in special if point.kind == "fold"), key=lambda point: abs(point.frequency - 14277.0))
    locus = train.locus(fold, parameter="stiffness_variation", start=0.03, stop=0.5)
    assert "corner" in locus.ends and not locus.complete
    end = -locus.ends.index("corner")
    last = locus.special_points[end]
    assert last.kind == "grazing on a fold"
    assert last.frequency == locus.frequency[end] and last.parameter == locus.parameter[end]
    assert f"a corner: mesh 1 grazes a wall of its gap at {last.frequency:.6f}"[:-3] in locus.ended
    for words in (locus.ended, repr(locus)):
        assert "rpm" in words and "Lambda" not in words
    again = pickle.loads(pickle.dumps(locus))
    assert again.ends == locus.ends and locus.to_dataset().attrs["ended"] == locus.ended


def test_motions_of_hunting_teeth_are_refused_at_once():
    """Orders 35 and 34 have no common divisor: a motion is 35 cycles of mesh 1 long."""
    own = paper_train()
    exact = own.response(start=0.5, stop=0.9).special_points[0].exact()
    hunting = replace(own, meshes=[replace(mesh, order=order) for mesh, order in zip(own.meshes, (35, 34))])
    motion = hunting.response(start=0.3 / 35, stop=0.301 / 35, harmonics=70, stability=False).at(0.3 / 35)[0]
    begun = time.process_time()
    with pytest.raises(gt.InputError, match=r"the period is 35 cycles of mesh 1.*several values of the parameter"):
        hunting.locus(replace(exact, motion=motion, frequency=motion.frequency), parameter="input_torque", start=140.0, stop=160.0)
    assert time.process_time() - begun < 2.0
    # As often as the meshes repeat themselves together within the period does not count.
    alike = replace(own, meshes=[replace(mesh, order=35) for mesh in own.meshes])
    fold = next(special for special in alike.response(start=0.7 / 35, stop=0.85 / 35, harmonics=0).special_points
                if special.kind == "fold")
    assert alike.locus(fold, parameter="input_torque", start=145.0, stop=155.0).complete
