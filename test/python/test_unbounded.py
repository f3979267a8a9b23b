"""What grows without bound is told so, and nothing else: whatever the characteristic length and frequency."""

from itertools import pairwise

import numpy as np
import pytest
from conftest import paper_train

import geartrain as gt
from geartrain.errors import SolverError

GAUGES = [(1.0, 1.0), (1.0, 1e-7), (1.0, 1e3), (1e5, 1e-7), (1e-6, 1.0)]


def in_gauge(length, frequency, **values):
    """The paper's train with other characteristic values: displacements are over ``length``, Lambda over ``frequency``."""
    return paper_train(characteristic_length=30e-6 * length, characteristic_frequency=9870.0 * frequency, **values)


@pytest.mark.parametrize(("length", "frequency"), GAUGES)
def test_bounded_in_every_gauge(length, frequency):
    """Figure 3 at 0.72 and 1.92: every analysis of flights finds what it finds with the paper's characteristic values."""
    train = in_gauge(length, frequency)
    assert train.integrate(0.72 / frequency).rms * length == pytest.approx(paper_train().integrate(0.72).rms, rel=1e-8)
    sweep = train.sweep(start=1.90 / frequency, stop=1.92 / frequency, points=3)
    assert "unbounded" not in {motion.kind for motion in sweep}
    run_up = train.run_up(start=0.5 / frequency, stop=0.6 / frequency, duration=0.05)
    assert run_up.complete and len(run_up.frequency)
    diagram = train.bifurcation_diagram(start=1.90 / frequency, stop=1.92 / frequency, points=2, transient=50, sections=20)
    assert "unbounded" not in set(diagram.kind)


@pytest.mark.parametrize(("length", "frequency"), GAUGES)
def test_unbounded_in_every_gauge(length, frequency):
    """Without backlash the motion at 1.92 grows without bound."""
    train = in_gauge(length, frequency, half_backlash=0.0)
    with pytest.raises(SolverError, match="grows without bound"):
        train.integrate(1.92 / frequency)
    diagram = train.bifurcation_diagram(start=1.92 / frequency, stop=1.92 / frequency, points=1, transient=1000, sections=20)
    assert set(diagram.kind) == {"unbounded"}


def test_three_stages_from_their_drawing():
    """Lambda in rpm makes velocities over the characteristic frequency large; the motion is a few micrometres."""
    names = ["motor", "pinion 1", "wheel 1", "pinion 2", "wheel 2", "pinion 3", "wheel 3", "load"]
    bodies = [gt.Body(name="motor", inertia=0.05, torque=120.0), *(gt.Body(name=name) for name in names[1:-1]),
              gt.Body(name="load", inertia=4.0, balances=True)]
    ends = list(pairwise(names))
    shafts = [gt.Shaft(between=between, diameter=[diameter], length=[0.12], damping_ratio=0.01)
              for between, diameter in zip(ends[::2], (0.03, 0.045, 0.06, 0.09), strict=True)]
    meshes = [gt.Mesh(between=between, teeth=teeth, normal_module=module, face_width=0.05, helix_angle=12.0, backlash=60e-6,
                      damping_ratio=0.05, stiffness_harmonics=3)
              for between, teeth, module in zip(ends[1::2], ((20, 60), (20, 60), (18, 54)), (2e-3, 3e-3, 4.5e-3), strict=True)]
    train = gt.Train(bodies=bodies, shafts=shafts, meshes=meshes, speed_of="motor")
    motion = train.integrate(1500.0, unit="rpm", max_periods=20)
    assert motion.kind != "unbounded" and np.isfinite(motion.rms).all()
    run_up = train.run_up(start=1400.0, stop=1450.0, unit="rpm", duration=2.0)
    assert run_up.complete and len(run_up.frequency)
