"""Pictures of trains: Campbell diagrams, modes, the train itself."""

from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from conftest import ROOT, paper_train, reducer, texts
from matplotlib.patches import Circle

import geartrain as gt

mpl.use("Agg")
pytestmark = pytest.mark.usefixtures("closed_figures")


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_a_campbell_diagram_of_engine_and_meshes():
    """Order 2 of the engine and three harmonics of each mesh: all that meet a natural frequency in the range."""
    rattle = gt.read_case(ROOT / "namelists" / "rattle.nml").train
    diagram = rattle.campbell(start=500.0, stop=6000.0, unit="rpm")
    orders = sorted([2, *(teeth * harmonic for teeth in (18, 11, 36 * 18 / 35) for harmonic in (1, 2, 3))])
    assert [order.per_revolution for order in diagram.orders] == pytest.approx(orders)
    speeds = [60 * hertz / order for hertz in rattle.modes().natural_frequency_hertz for order in orders]
    within = sorted(speed for speed in speeds if 500 <= speed <= 6000)
    np.testing.assert_allclose([crossing.speed for crossing in diagram.crossings], within)
    assert "2 x revolution of engine" in str(diagram)


def test_a_campbell_diagram_of_the_reducer(drawn):
    diagram = drawn.campbell(start=200.0, stop=4000.0)
    hertz = drawn.natural_frequencies() / 60 / (71 / 23)
    np.testing.assert_allclose(diagram.natural_frequency, hertz)
    assert [(order.order, order.name) for order in diagram.orders] == [
        (19, "mesh 2"), (38, "2 x mesh 2"), (57, "3 x mesh 2"), (71, "mesh 1"), (142, "2 x mesh 1"), (213, "3 x mesh 1")]
    assert [order.per_revolution for order in diagram.orders[2:4]] == pytest.approx([3 * 19 * 23 / 71, 23])
    expected = sorted(
        60 * natural * 71 / 23 / order for natural in hertz for order in (19, 38, 57, 71, 142, 213)
        if 200 <= 60 * natural * 71 / 23 / order <= 4000)
    np.testing.assert_allclose([crossing.speed for crossing in diagram.crossings], expected)
    for crossing in diagram.crossings:
        assert crossing.natural_frequency == pytest.approx(crossing.order.order * crossing.fundamental_frequency)
        assert crossing.natural_frequency == pytest.approx(hertz[crossing.mode - 1])
    assert len(str(diagram).splitlines()) == 1 + len(expected) and "excited by" in str(diagram)
    assert "Lambda" not in str(diagram)  # it is the speed
    heading, first = str(diagram).splitlines()[:2]
    assert "order of fundamental" in heading and "per revolution of motor" in heading
    assert int(first.split()[3]) in (19, 38, 57, 71)
    ax = diagram.plot()
    assert ax.get_xlabel() == "speed of motor  [rpm]" and ax.get_ylabel() == "frequency  [Hz]" and ax.get_xlim() == (200.0, 4000.0)
    marks = [line for line in ax.lines if line.get_marker() == "o" and len(line.get_xdata())]
    for line, matters in zip(marks, (True, False), strict=True):
        some = [crossing for crossing in diagram.crossings if crossing.matters is matters]
        np.testing.assert_allclose(line.get_data(), [[each.speed for each in some], [each.natural_frequency for each in some]])
    assert marks[0].get_markersize() > marks[1].get_markersize()


def test_crossings_are_ranked_by_the_mesh_force(drawn):
    """The reducer resonates where its response of docs/case-studies.md does; the others are less than a tenth of the mean force."""
    diagram = drawn.campbell(start=200.0, stop=4000.0)
    ranked = sorted(diagram.crossings, key=lambda crossing: crossing.rank)
    assert [crossing.rank for crossing in ranked] == list(range(1, len(ranked) + 1))
    assert [crossing.over_mean for crossing in ranked] == sorted((each.over_mean for each in ranked), reverse=True)
    assert {round(crossing.speed) for crossing in ranked if crossing.matters} == {253, 829, 947, 1688, 3097}


def test_the_force_of_a_crossing_is_that_of_the_linear_response():
    """A train without gaps and with little excitation at a natural frequency, 3 %: the other modes answer as well."""
    meshes = [gt.Mesh(**{name: getattr(mesh, name) for name in mesh.variables} | {
        "backlash": None, "half_backlash": 0.0, "stiffness_harmonics": None, "stiffness_cos": [1e-3], "error_cos": error})
        for mesh, error in zip(reducer().meshes, ([1e-8], None), strict=True)]
    train = reducer(meshes=meshes)
    crossings = [crossing for crossing in train.campbell(start=1000.0, stop=4000.0).crossings if crossing.mode in {2, 3}]
    assert len(crossings) >= 2
    for crossing in crossings:
        motion = train.integrate(crossing.speed)
        amplitude = np.ptp(motion.mesh_force, axis=0) / 2
        mesh = int(np.argmax(crossing.mesh_force))
        assert amplitude[mesh] == pytest.approx(crossing.mesh_force[mesh], rel=0.03), crossing


def test_only_orders_with_an_amplitude_excite(drawn):
    """Those of stiffness, transmission error and torques, the latter of Lambda and of a body's own revolutions."""
    meshes = [gt.Mesh(**{name: getattr(mesh, name) for name in mesh.variables} | {"stiffness_cos": [0.0, 0.1], "error_cos": None})
              for mesh in drawn.meshes]
    bodies = [gt.Body(name="motor", inertia=0.02, torque=90.0, revolution_torque_cos=[0.0, 3.0]), *drawn.bodies[1:]]
    whole = reducer(meshes=meshes, bodies=bodies, characteristic_frequency=1.0)
    diagram = whole.campbell(start=200.0, stop=4000.0, unit="rpm")
    # The period of the fundamental is 71 turns of the motor now.
    assert [(order.name, round(order.per_revolution, 9)) for order in diagram.orders] == [
        ("2 x revolution of motor", 2.0), ("2 x mesh 2", round(2 * 19 * 23 / 71, 9)), ("2 x mesh 1", 46.0)]
    chain = paper_train(torque_sin=[0.0, 0.0, 5.0])
    assert [(order.order, order.name) for order in chain.campbell(start=0.2, stop=1.0).orders] == [
        (1, "mesh 1, mesh 2"), (3, "3 x input torque")]
    for wrong, told in (({"start": -1.0, "stop": 1.0}, "start = -1"), ({"start": 0.2, "stop": 1.0, "unit": "rpm"}, "unit = 'rpm'")):
        with pytest.raises(gt.InputError, match=told):
            chain.campbell(**wrong)


def test_the_picture_of_a_campbell_diagram(drawn):
    """Orders have names of their own, near the ends of their lines; a limit leaves out high modes."""
    diagram = drawn.campbell(start=200.0, stop=4000.0)
    ax = diagram.plot()
    assert ax.get_legend().get_title().get_text() == "orders per revolution of motor"
    modes = [text.get_text() for text in ax.texts if text.get_text().startswith("mode")]
    assert modes[0] == "mode 1: 97.16 Hz, 0.48 %"
    speeds = [text for text in ax.texts if text.get_fontweight() == "bold"]
    assert [text.get_text() for text in speeds] == ["3097", "1688", "828.7", "947.2", "253.5"]
    ax.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in ax.texts]
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    names = [(text.get_text(), text.xy) for text in ax.texts if text not in speeds and text.get_text() not in modes]
    assert [name for name, _ in names] == [f"{order.per_revolution:.4g}" for order in diagram.orders]
    for (name, (speed, hertz)), order in zip(names, diagram.orders, strict=True):
        assert hertz == pytest.approx(order.per_revolution * speed / 60), name
    assert diagram.plot(highest=1600.0).get_ylim() == (0, 1600)
    with pytest.raises(gt.InputError, match="highest = -1: must be a number > 0"):
        diagram.plot(highest=-1)


@pytest.mark.parametrize("make", [reducer, paper_train, lambda: gt.read_case(ROOT / "namelists" / "branched.nml").train])
def test_rotations_of_modes_are_those_of_the_whole_train(make):
    """K phi = omega^2 M phi, set up from the numbers that explain() tells, without the library's coordinates."""
    from geartrain.plots.schematic import joints_of

    train = make()
    modes, numbers = train.modes(), train.explain()
    number = len(train.body_labels)
    if train.bodies:
        inertia = np.array([numbers[name]["inertia"] for name in train.body_labels])
    else:
        gears = [value for mesh in train.meshes for value in (mesh.driving_inertia, mesh.driven_inertia)]
        inertia = np.array([train.prime_mover_inertia, *gears, train.load_inertia])
    stiffness = np.zeros((number, number))
    for joint in joints_of(train):
        told, row = numbers[joint.element], np.zeros(number)
        row[list(joint.ends)] = np.array(told["base_radius"] if joint.is_mesh else (1.0, 1.0)) * [1, -1]
        stiffness += told["stiffness"] * np.outer(row, row)
    scale = 1 / np.sqrt(inertia)
    squares = np.linalg.eigvalsh(scale[:, None] * stiffness * scale)[1:]
    np.testing.assert_allclose(modes.natural_frequency_hertz, np.sqrt(squares) / (2 * np.pi), rtol=1e-6)
    for mode, rotation in enumerate(modes.rotation):
        square = (2 * np.pi * modes.natural_frequency_hertz[mode]) ** 2
        residual = stiffness @ rotation - square * inertia * rotation
        assert abs(residual).max() < 1e-7 * abs(stiffness @ rotation).max()
        assert abs(rotation).max() == pytest.approx(1)
        shares = modes.energy_shares(mode + 1)
        assert tuple(shares) == modes.element and sum(shares.values()) == pytest.approx(1)


def test_a_mode_on_the_train(split):
    modes = split.modes()
    ax = modes.plot(2)
    assert ax.get_title() == "mode 2:  350.1 Hz,  3.8 % of critical damping" and "damping [%]" in str(modes)
    discs = [patch for patch in ax.patches if isinstance(patch, Circle)]
    colours = mpl.colormaps["coolwarm"]((1 + modes.rotation[1]) / 2)
    np.testing.assert_allclose([disc.get_facecolor() for disc in discs], colours)
    assert any("98.4 %" in text for text in texts(ax))
    with pytest.raises(gt.InputError, match="mode = 9: must be 1 to 6"):
        modes.plot(9)


def test_the_train_as_a_picture(drawn, split):
    ax = drawn.plot()
    assert [text for text in texts(ax) if "turn" in text] == [
        "motor\n1 turn", "pinion 1\n1 turn", "wheel 1\n-0.3239 turns", "pinion 2\n-0.3239 turns", "wheel 2\n0.07694 turns",
        "load\n0.07694 turns"]
    assert "mesh 1\n23 : 71" in texts(ax) and "shaft 1\n42.4 kN m/rad" in texts(ax)
    assert f"wheel 2\n{1500 * 23 / 71 * 19 / 80:.4g} rpm" in texts(drawn.plot(speed=1500.0))
    assert f"pinion 2\n{-1500 * 23 / 71:.4g} rpm" in texts(drawn.plot(speed=1500.0))  # an external pair: the opposite sense
    assert "mesh 3\n1 : 1.667" in texts(split.plot()) and "driven gear 2" in texts(paper_train().plot())


@pytest.mark.parametrize("case", ["planetary", "hybrid", "ravigneaux"])
def test_words_of_planetary_sets_keep_apart(case):
    """In the drawing of a train no words cover others, and those of a planet have the sign of its sense."""
    train = gt.read_case(ROOT / "namelists" / f"{case}.nml").train
    ax = train.plot()
    ax.figure.canvas.draw()
    boxes = {text.get_text(): text.get_window_extent() for text in ax.texts}
    assert len(boxes) == len(train.body_labels) + len(train.shafts) + len(train.meshes)
    assert [pair for pair in combinations(boxes, 2) if boxes[pair[0]].overlaps(boxes[pair[1]])] == []
    words = {"planetary": "stage 1 planet 1\n-0.375 turns", "hybrid": "motor 1\n-1.6 turns",
             "ravigneaux": "large sun\n-0.8158 turns"}
    assert words[case] in boxes


def test_a_long_train_goes_there_and_back():
    mesh = paper_train().meshes[0]
    train = paper_train(shafts=[gt.Shaft(stiffness=1e5, damping_ratio=0.01)] * 8, meshes=[mesh] * 7)
    discs = [patch.center for patch in train.plot().patches if isinstance(patch, Circle)]
    heights = [y for _, y in discs]
    assert heights == sorted(heights, reverse=True) and len(set(heights)) == 2
    assert discs[9][0] == discs[10][0] and discs[8][0] == discs[11][0]


def test_the_layout_of_a_train_keeps_bodies_apart(split):
    from geartrain.plots.schematic import Joint, joints_of, places_of

    places = places_of(7, joints_of(split))
    assert places[:, 0].tolist() == [0, 1, 2, 2, 3, 2, 4]  # the pinion drives both wheels and the pump
    assert places[[2, 3, 5], 1].tolist() == [1, 0, -1] and places[4, 1] == 0.5
    random = np.random.default_rng(1)
    for bodies in (2, 5, 20, 60):
        tree = [Joint(f"mesh {body}", (int(random.integers(body)), body)) for body in range(1, bodies)]
        places = places_of(bodies, tree)
        for column in range(int(places[:, 0].max()) + 1):
            heights = np.sort(places[places[:, 0] == column, 1])
            assert (np.diff(heights) > 1 - 1e-9).all()
        for joint in tree:
            one, other = places[list(joint.ends)]
            assert other[0] == one[0] + 1


# Bearings and couplings


@pytest.fixture(scope="module")
def carried():
    """A gear pair on two bearings, the pinion with clearance, behind a spline: one motion and a short branch."""
    bodies = [gt.Body(name="motor", inertia=0.02, torque=40.0), gt.Body(name="pinion", inertia=1e-3, position=[0.0, 0.0]),
              gt.Body(name="wheel", inertia=0.014, position=[0.12, 0.0], balances=True)]
    train = gt.Train(
        bodies=bodies, characteristic_length=1e-6, characteristic_frequency=1e4,
        couplings=[gt.Coupling(between=("motor", "pinion"), stiffness=8e3, half_play=0.002, damping=1.0)],
        meshes=[gt.Mesh(between=("pinion", "wheel"), driving_radius=0.035, driven_radius=0.077, stiffness=4e8, damping=1300.0,
                        stiffness_cos=[0.3, 0.1], half_backlash=28e-6)],
        bearings=[gt.Bearing(body="pinion", mass=2.5, stiffness=[2.5e8, 2e8], damping=[800.0, 800.0], half_clearance=5e-6),
                  gt.Bearing(body="wheel", mass=7.0, stiffness=[3e8, 2.5e8], damping=[1200.0, 1200.0])])
    return train.response(start=0.55, stop=0.75, harmonics=10)


def test_bearings_of_the_train(carried):
    """A ring of eight balls between two rings in each body on a bearing, and its name below; of a mode its share of energy."""
    train = carried.train
    ax = train.plot()
    assert sum(isinstance(patch, Circle) for patch in ax.patches) == 3 + 2 * 10
    assert "pinion\nbearing 1" in texts(ax) and "wheel\nbearing 2" in texts(ax)
    modes = train.modes()
    shares = modes.energy_shares(2)
    for number in (1, 2):
        share = shares[f"bearing {number} x"] + shares[f"bearing {number} y"]
        assert (f"bearing {number}: {100 * share:.3g} %" in "\n".join(texts(modes.plot(2)))) == (share >= 0.005)


def names(ax):
    """What a legend or the words on axes name."""
    return [*texts(ax), *(line.get_label() for line in ax.lines)]


def test_forces_of_bearings_over_the_speed(carried):
    """Curves of x and y of each bearing; a bearing, or a coupling, asked for alone."""
    ax = carried.plot(quantity="bearing_force_rms")
    # A panel each, or one for all.
    assert {"pinion bearing x", "wheel bearing y"} <= {text for panel in ax.figure.axes for text in names(panel)}
    drawn = np.concatenate([line.get_ydata() for panel in ax.figure.axes for line in panel.lines])
    assert np.isin(carried.bearing_force_rms, drawn).all()
    assert ax.get_ylim()[0] == 0
    drawn = np.concatenate([line.get_ydata() for panel in carried.plot(bearing=2).figure.axes for line in panel.lines])
    for of_bearing in (carried.bearing_force_minimum, carried.bearing_force_maximum):
        assert np.isin(of_bearing[:, 1], drawn).all() and not np.isin(of_bearing[:, 0], drawn).any()
    assert carried.plot(coupling=1).get_ylabel() == "coupling torque, smallest to largest  [N m]"
    with pytest.raises(gt.InputError, match="bearing = 3: must be 1 to 2"):
        carried.plot(bearing=3)
    with pytest.raises(gt.InputError, match="is of each bearing, and of no other part"):
        carried.plot(bearing=1, quantity="bearing_force", mesh=1)
    frame = carried.to_dataframe()
    assert (frame["bearing_force_mean, bearing 2 y"] == carried.bearing_force_mean[:, 1, 1]).all()
    assert list(carried.to_dataset().bearing_label.values) == ["pinion", "wheel"]


def test_spectra_of_forces(carried):
    """The squares of the amplitudes add up to the mean square of a force: Parseval."""
    motion = carried.at(0.65)[0]
    order, amplitude = motion.spectrum("bearing_force")
    assert amplitude.shape == (len(order), 2, 2) and order[0] == 1
    # Lines above those kept, of the corners of the force: their squares fall with the fourth power of the order.
    assert np.sqrt((amplitude**2).sum(0) / 2) == pytest.approx(motion.bearing_force_rms, rel=1e-6)
    meshes = motion.spectrum("mesh_force")[1]
    assert (meshes[:, 2:].reshape(-1, 2, 2) == amplitude).all()
    assert motion.spectrum("coupling_torque")[1][:, 0] == pytest.approx(meshes[:, 1], abs=1e-12 * meshes.max())
    table = motion.orders(what="bearing_force")
    assert table.amplitude.attrs["units"] == "N" and list(table.bearing.values[:2]) == ["pinion bearing x", "pinion bearing y"]
    axes = motion.plot(mesh=3, spectrum="mesh_force")
    assert axes[2].get_ylabel().startswith("amplitude  [N") and axes[1].get_ylabel().startswith("mesh or bearing force")
    assert max(line.get_ydata().max() for line in axes[2].lines) == pytest.approx(amplitude[:, 0, 0].max())
    with pytest.raises(gt.InputError, match="spectrum = 'velocity': must be 'displacement' or 'mesh_force'"):
        motion.plot(spectrum="velocity")
    with pytest.raises(gt.InputError, match="what = 'noise': must be 'displacement'"):
        motion.spectrum("noise")


def test_the_gap_of_a_bearing(carried):
    """Grey where a bearing has clearance, in the phase plane of its displacement; channels have the names of the elements."""
    motion = carried.at(0.65)[0]
    (gap,) = [patch for patch in motion.phase_plane(3).patches if hasattr(patch, "get_width")]
    assert gap.get_width() == pytest.approx(2 * 5.0)
    assert motion.rainflow("coupling 1").unit == "N m"
    assert motion.rainflow("bearing 2 y").unit == "N"


def test_ranges_of_bearings(carried):
    """A bearing that bears on its negative side is not said to hit with its back flanks."""
    assert carried.back_contact_fraction[:, 2].min() == 1.0  # x of the pinion
    ax = carried.plot(quantity="mesh_force", ranges=True)
    words = [word for panel in ax.figure.axes for word in texts(panel)]
    assert "bearing 1 x" not in words and not any("back flanks" in word for word in words)
