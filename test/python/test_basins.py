"""Basins of attraction against time integration the long way."""

import numpy as np
import pytest
from conftest import paper_train

import geartrain as gt


@pytest.fixture(scope="module")
def basins():
    return paper_train().basins(0.7, mesh=2, points=(24, 20), starts=40, displacement_start=-4, displacement_stop=6)


def test_every_start_reaches_the_motion_told(basins):
    """Every eighth start, settled by `Train.integrate` without tables and balls: the same motion, to 1e-7 of its rms."""
    train = paper_train()
    assert basins.complete
    assert len(basins.motions) == 3
    for row in range(20):
        for column in range(row % 8, 24, 8):
            settled = train.integrate(0.7, start=basins.start(basins.displacement[column], basins.velocity[row]))
            told = basins.motions[basins.label[row, column] - 1]
            assert settled.rms == pytest.approx(told.rms, rel=1e-7)
            assert basins.motion_at(basins.displacement[column], basins.velocity[row]) is told


def test_shares(basins):
    """The grid's shares are its labels counted; with their errors they hold against a grid of four times as many starts."""
    assert basins.grid_share.sum() + basins.unsettled + basins.unbounded == pytest.approx(1)
    assert [np.mean(basins.label == n + 1) for n in range(3)] == pytest.approx(basins.grid_share)
    finer = paper_train().basins(0.7, mesh=2, points=(48, 40), starts=40, displacement_start=-4, displacement_stop=6)
    off = np.abs(finer.grid_share - basins.grid_share) / np.hypot(finer.grid_share_error, basins.grid_share_error)
    assert (off < 4).all()
    assert basins.share_error == pytest.approx([np.sqrt(m.share * (1 - m.share) / 40) for m in basins.motions])


def test_another_state_beside(basins):
    """Starts with the state of a motion, its own displacement and velocity among them, settle on it."""
    train = paper_train()
    motion = basins.motions[1]
    own = motion.state[basins.displacement_place - 1], motion.state[basins.velocity_place - 1]
    found = train.basins(0.7, mesh=2, points=(1, 1), starts=40, state=motion, displacement_start=own[0], displacement_stop=own[0],
                         velocity_start=own[1], velocity_stop=own[1])
    assert found.motion_at(*own).rms == pytest.approx(motion.rms)


def test_what_it_refuses():
    train = paper_train()
    with pytest.raises(gt.InputError, match="points = 5: must be two whole numbers"):
        train.basins(0.7, points=5)
    with pytest.raises(gt.InputError, match="mesh = 3: must be 1 to 2"):
        train.basins(0.7, mesh=3)
    with pytest.raises(gt.InputError, match="displacement_points"):
        train.basins(0.7, points=(10, 10), displacement_start=1.0, displacement_stop=1.0)


def test_as_a_file_and_a_picture(basins, tmp_path):
    """A case file gives the same; the Dataset and the picture have all that is there."""
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    data = basins.to_dataset()
    assert data["label"].dims == ("velocity", "displacement")
    axes = basins.plot()
    assert len(axes.get_legend().get_texts()) == 3
    text = paper_train().namelist(basins={"frequency": 0.7, "mesh": 2, "displacement_points": 24, "velocity_points": 20,
                                          "starts": 40, "displacement_start": -4, "displacement_stop": 6})
    (tmp_path / "case.nml").write_text(text)
    results = gt.read_case(tmp_path / "case.nml").run()
    results.write(tmp_path / "case.h5")
    again = gt.read_results(tmp_path / "case.h5").basins
    assert (again.label == basins.label).all()
    assert len(again.motions) == 3 and again.frequency == 0.7
