"""Planetary sets in short form: as the set written by hand, and phases by the geometry of the teeth."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, run

import geartrain as gt

BODIES = [
    gt.Body(name="sun", inertia=8.2e-4, torque=600.0),
    gt.Body(name="ring", held=True),
    gt.Body(name="arm", inertia=0.085, balances=True),
]
COMMON = {"normal_module": 4e-3, "damping_ratio": 0.03}


def short(teeth=(17, 22, 61), bodies=BODIES, **more):
    given = {"planets": 3, "planet_inertia": 2.2e-3, "stiffness": (1e9, 1.2e9), "half_backlash": (4e-5, 5e-5), **COMMON, **more}
    stage = gt.Planetary(name="stage 1", sun="sun", ring="ring", carrier="arm", teeth=teeth, **given)
    with pytest.warns(gt.DrawingWarning) if teeth[0] <= 17 else _nothing():
        return gt.Train(bodies=bodies, planetaries=[stage])


class _nothing:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None


def by_hand(teeth, angles, lag, **more):
    """The set with phases by the rule: z_s psi, and -z_r psi + lag."""
    meshes = [
        gt.Mesh(
            between=("sun", f"planet {n}"),
            carrier="arm",
            teeth=teeth[:2],
            stiffness=1e9,
            half_backlash=4e-5,
            phase=2 * np.pi * (teeth[0] * psi % 1),
            **COMMON,
            **more,
        )
        for n, psi in enumerate(angles)
    ] + [
        gt.Mesh(
            between=(f"planet {n}", "ring"),
            carrier="arm",
            internal=True,
            teeth=teeth[1:],
            stiffness=1.2e9,
            half_backlash=5e-5,
            phase=2 * np.pi * ((lag - teeth[2] * psi) % 1),
            **COMMON,
            **more,
        )
        for n, psi in enumerate(angles)
    ]
    planets = [gt.Body(name=f"planet {n}", inertia=2.2e-3) for n in range(len(angles))]
    return gt.Train(bodies=[*BODIES, *planets], meshes=meshes)


def lag_by_drawing(train, driving="sun"):
    """Lag of the ring mesh of planet 1 behind its sun mesh in cycles, from where flanks meet in the plane.

    The sun turns counterclockwise round the origin, the planet clockwise round (a, 0); angles of the planet count clockwise.
    """
    planets = sum(body.name.startswith("stage 1 planet") for body in train.bodies)
    sun, ring = (train.explain()[f"mesh {number}"] for number in (1, planets + 1))
    own = (1, 0) if driving == "sun" else (0, 1)  # place of the planet in either mesh
    a, z = sun["centre_distance"], train.meshes[0].teeth[own[0]]
    shift = (train.meshes[0].profile_shift or (0.0, 0.0))[own[0]]
    base, tip = sun["base_radius"][own[0]], sun["tip_diameter"][own[0]] / 2
    centre, alpha = np.array([a, 0.0]), np.arccos(base / (sun["reference_diameter"][own[0]] / 2))

    def half_thickness(radius):
        def involute(angle):
            return np.tan(angle) - angle

        return (np.pi / 2 + 2 * shift * np.tan(np.deg2rad(20))) / z + involute(alpha) - involute(np.arccos(base / radius))

    def middle(mesh, own, pitch_x, mirror, trailing):
        """Angle of the planet in the middle of the contact of a pair: at the tips of both gears."""
        angle = np.deg2rad(mesh["working_angle"])
        direction = np.array([np.sin(angle), mirror * np.cos(angle)])
        start = np.array([pitch_x, 0.0])
        turned = []
        for about, radius in ((centre, tip), (np.zeros(2), mesh["tip_diameter"][1 - own] / 2)):
            # Where the line of action meets the tip circle, next to the pitch point.
            away = start - about
            half, rest = away @ direction, away @ away - radius**2
            along = min(np.roots([1.0, 2 * half, rest]), key=abs)
            point = start + along * direction - centre
            psi = -np.arctan2(point[1], point[0])
            turned.append(psi + (1 if trailing else -1) * half_thickness(np.hypot(*point)))
        return np.mean(np.unwrap(turned)) * z / (2 * np.pi)

    first = middle(
        sun, own[0], a - base / np.cos(np.deg2rad(sun["working_angle"])), 1 if driving == "sun" else -1, driving == "sun"
    )
    second = middle(
        ring, own[1], a + base / np.cos(np.deg2rad(ring["working_angle"])), -1 if driving == "sun" else 1, driving != "sun"
    )
    return (second - first) % 1


@pytest.mark.parametrize(
    ("teeth", "more"),
    [
        ((17, 22, 61), {}),
        ((19, 21, 61), {"planets": 5}),
        ((27, 36, 99), {"profile_shift": (0.3, 0.1, -0.5)}),
        ((20, 31, 82), {"profile_shift": (0.2, -0.1, 0.0), "driving": "ring"}),
        ((27, 36, 99), {"driving": "ring"}),
    ],
)
def test_phases_follow_from_the_teeth(teeth, more):
    train = short(teeth, **more)
    planets = more.get("planets", 3)
    phase = np.array([mesh.phase or 0.0 for mesh in train.meshes]) / (2 * np.pi)
    psi = np.arange(planets) / planets
    for found, expected in ((phase[:planets], teeth[0] * psi), (phase[planets:] - phase[planets], -teeth[2] * psi)):
        assert np.abs(np.exp(2j * np.pi * found) - np.exp(2j * np.pi * expected)).max() < 1e-12
    wanted = lag_by_drawing(train, more.get("driving", "sun"))
    assert abs(np.exp(2j * np.pi * phase[planets]) - np.exp(2j * np.pi * wanted)) < 1e-9


@pytest.mark.parametrize(
    ("teeth", "angles"), [((27, 36, 99), None), ((17, 22, 61), None), ((19, 21, 61), (0.0, 99.0, 189.0, 270.0))]
)
def test_short_form_is_the_set_by_hand(teeth, angles):
    more = {} if angles is None else {"planets": None, "angles": angles}
    train = short(teeth, **more, sun_error_cos=2e-6, ring_error_cos=2e-6)
    psi = np.arange(3) / 3 if angles is None else np.array(angles) / 360
    lag = train.meshes[len(psi)].phase / (2 * np.pi)
    with pytest.warns(gt.DrawingWarning) if teeth[0] <= 17 else _nothing():
        hand = by_hand(teeth, psi, lag, error_cos=2e-6)
    assert np.abs(train.natural_frequencies() / hand.natural_frequencies() - 1).max() < 1e-12
    settings = {"start": 9000.0, "stop": 9500.0, "harmonics": 6, "stability": False}
    one, other = train.response(**settings), hand.response(**settings)
    assert len(one.rms) == len(other.rms)
    assert np.abs(one.rms - other.rms).max() < 1e-12 * other.rms.max()


def test_python_expands_as_a_case_file_does():
    train = short()
    assert train.planetaries == ()
    assert [body.name for body in train.bodies[3:]] == [f"stage 1 planet {n}" for n in (1, 2, 3)]
    assert train.mesh_labels == tuple(f"stage 1 {kind} {n}" for kind in ("sun", "ring") for n in (1, 2, 3))
    with pytest.warns(gt.DrawingWarning):
        again = replace(train)
    assert again == train
    expected = [5149.07092, 6580.49593, 6580.49593, 11043.24781]
    assert train.natural_frequencies(unit="Hz") == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("planets", "teeth", "phasing"),
    [
        (3, (27, 36, 99), "in phase"),
        (3, (17, 22, 61), "sequential"),
        (4, (22, 25, 72), "other"),
        (4, (30, 26, 82), "counter-phase"),
        (5, (19, 21, 61), "sequential"),
    ],
)
def test_harmonics_that_drive_torsion(planets, teeth, phasing):
    if (teeth[0] + teeth[2]) % planets:
        with pytest.raises(gt.InputError, match="cannot be equally spaced"):
            short(teeth, planets=planets)
        return
    told = short(teeth, planets=planets).explain()["stage 1"]
    harmonics = np.arange(1, 2 * planets + 1)
    assert told["sun_torsion"] == pytest.approx((harmonics * teeth[0] % planets == 0).astype(float), abs=1e-12)
    assert told["ring_torsion"] == pytest.approx(told["sun_torsion"], abs=1e-12)
    assert told["sun_phasing"].strip() == told["ring_phasing"].strip() == phasing
    assert told["carrier_turns"] == pytest.approx(teeth[0] / (teeth[0] + teeth[2]), rel=1e-14)
    assert told["mesh_frequency"] == pytest.approx(teeth[0] * teeth[2] / (teeth[0] + teeth[2]), rel=1e-14)


def test_face_widths_and_moduli_of_each_gear():
    """c' of ISO 6336-1 goes with 2 E_1 E_2/(E_1 + E_2), and a mesh with its own face width."""
    drawn = {"stiffness": None, "half_backlash": None, "backlash": 6e-5, "face_width": 0.05}
    plain, narrow = (short((20, 22, 64), **drawn, **more).explain() for more in ({}, {"ring_face_width": 0.04}))
    assert narrow["mesh 1"]["stiffness"] == plain["mesh 1"]["stiffness"]
    assert narrow["mesh 4"]["stiffness"] == pytest.approx(0.8 * plain["mesh 4"]["stiffness"], rel=1e-12)
    iron = short((20, 22, 64), **drawn, elastic_modulus=[2.06e11, 1.1e11, 1.7e11]).explain()
    steel = 2.06e11
    for mesh, (one, other) in (("mesh 1", (steel, 1.1e11)), ("mesh 4", (1.1e11, 1.7e11))):
        share = 2 * one * other / (one + other) / steel
        assert iron[mesh]["single_stiffness"] == pytest.approx(share * plain[mesh]["single_stiffness"], rel=1e-12)


@pytest.mark.parametrize("error", [1.0e-6, 2.0e-6, 2.4e-6, 2.51e-6])
def test_stiffness_and_load_of_a_planet_go_together(error):
    """A planet that lies back takes less load, by ISO 6336-1 is softer, and takes less again: both are those of one another."""
    numbers = gt.Train(
        characteristic_frequency=1e4, shafts=[],
        bodies=[gt.Body(name="sun", torque=60.0), gt.Body(name="ring", held=True),
                gt.Body(name="arm", inertia=0.05, balances=True)],
        planetaries=[gt.Planetary(name="set", sun="sun", ring="ring", carrier="arm", teeth=[24, 30, 84], planets=4,
                                  normal_module=1.75e-3, helix_angle=15.0, face_width=0.025, backlash=60e-6, damping_ratio=0.05,
                                  planet_errors=[0.0, 0.0, -error, 0.0])]).explain()
    meshes = [numbers[f"mesh {number}"] for number in range(1, 9)]
    for mesh, first in zip(meshes, 4 * meshes[:1] + 4 * meshes[4:5], strict=True):
        assert mesh["stiffness"] == pytest.approx(0.025 * mesh["mesh_stiffness"], rel=1e-9)
        assert mesh["stiffness"] == pytest.approx(first["stiffness"] * (mesh["mean_force"] / first["mean_force"])**0.25, rel=1e-8)
    # All planets bear: the deflections of the planets in series with both meshes differ by their errors.
    deflection = [one["mean_force"] / one["stiffness"] + two["mean_force"] / two["stiffness"]
                  for one, two in zip(meshes[:4], meshes[4:], strict=True)]
    assert deflection[0] - deflection[2] == pytest.approx(2 * error, rel=1e-6)
    assert 0 < numbers["set"]["load_share"][2] < 0.14


@pytest.mark.parametrize(("torque", "driving", "warned"), [(200.0, "sun", 0), (-200.0, "sun", 1), (-200.0, "ring", 0)])
def test_flanks_that_bear_against_driving(torque, driving, warned):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gt.Train(characteristic_frequency=1e4, shafts=[],
                 bodies=[gt.Body(name="sun", torque=torque), gt.Body(name="ring", held=True),
                         gt.Body(name="arm", inertia=0.05, balances=True)],
                 planetaries=[gt.Planetary(name="set", sun="sun", ring="ring", carrier="arm", teeth=[24, 30, 84], planets=3,
                                           normal_module=2e-3, face_width=0.025, backlash=60e-6, damping_ratio=0.05,
                                           driving=driving)])
    assert sum("all meshes of set bear on their coast flanks" in str(one.message) for one in caught) == warned


@pytest.mark.parametrize(("places", "ring_places", "said"), [
    ((0, 26, 52), (0, 26, 52), ""),
    ((0, 25, 53), (0, 25, 53), ""),
    ((0, 26, 52), (0, -26, -52),
     "planet 1 - ring lags 0.333333 cycles behind planet 0 - ring, but sun - planet 1 lags 0.666667 behind"),
    ((0, 0, 0), (0, 0, 0), "phase: 3 planets have this phase, but with 17 and 61 teeth 1 place has it"),
])
def test_phases_that_no_places_of_planets_give(places, ring_places, said):
    """By places of 1/(z_s + z_r) turns each; the drawing does not know them."""
    lag = np.array([17 * place / 78 for place in places] + [-61 * place / 78 for place in ring_places])
    meshes = [gt.Mesh(between=("sun", f"planet {n % 3}") if n < 3 else (f"planet {n % 3}", "ring"), carrier="arm", internal=n >= 3,
                      teeth=(17, 22) if n < 3 else (22, 61), stiffness=1e9, half_backlash=4e-5, stiffness_cos=[0.1],
                      phase=2 * np.pi * (lag[n] % 1), normal_module=4e-3, damping_ratio=0.03) for n in range(6)]
    planets = [gt.Body(name=f"planet {n}", inertia=2.2e-3) for n in range(3)]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gt.Train(bodies=[*BODIES, *planets], meshes=meshes)
    found = [str(one.message) for one in caught if "phase:" in str(one.message)]
    assert found == [] if said == "" else found and said in found[0]


@pytest.mark.parametrize(("old", "new", "said"), [
    ("'ring', held = .true.", "'ring', inertia = 0.1", "or held = .true. of a body that stands still"),
    ("inertia = 0.05", "held = .true.", "gears do not turn: 'ring' and 'carrier' are held"),
    ("&shaft", "!", "2: 'sun', 'ring', 'carrier', 'stage 1 planet 1' and 2 more are joined with 'motor' by no shaft"),
])
def test_sets_that_do_not_turn_by_what_is_given(executable, tmp_path, old, new, said):
    case = (ROOT / "namelists" / "planetary.nml").read_text(encoding="utf-8").replace(old, new)
    (tmp_path / "case.nml").write_text(case)
    assert said in run(executable, "--check", "case.nml", cwd=tmp_path).stderr


def stage(planets=3, **more):
    """A set in sequence: 31 teeth of the sun are no multiple of 3."""
    given = {"teeth": [31, 20, 71], "planets": planets, "normal_module": 1.5e-3, "face_width": 0.02, "damping_ratio": 0.05, **more}
    return gt.Planetary(name="set", sun="sun", ring="ring", carrier="arm", **given)


@pytest.mark.parametrize(("more", "said"), [
    ({"backlash": 60e-6}, ""),
    ({"planet_errors": [0.0, 150e-6, 0.0]}, "the teeth of this planet of set pull at rest"),
    ({"planet_errors": [0.0, 5e-6, 0.0], "backlash": 60e-6}, ""),
    ({"planet_errors": [0.0, 1e-3, 0.0], "backlash": 60e-6}, "error_mean = 0.001: more than the backlash and a tenth"),
])
def test_errors_of_planets_that_are_hardly_meant(more, said):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gt.Train(bodies=BODIES, planetaries=[stage(**more)])
    found = [str(one.message) for one in caught]
    assert any(said in words for words in found) if said else not any("pull" in words or "error_mean" in words for words in found)


@pytest.mark.parametrize(("ring", "module", "inertia", "said"), [
    (71, 1.5e-3, 1e-5, ""),
    (73, 1.5e-3, 1e-5, "the drawing of p0 - ring has the axes 0.03975 m apart, and the drawing of sun - p0 0.03825 m"),
    (71, 2.0e-3, 1e-5, "a planet is at one distance from the axis of its carrier"),
    (71, 1.5e-3, 0.1, "inertia = 0.1 of 'p0': planets that are full discs of steel, as wide as their teeth, have 1.2"),
])
def test_planets_by_hand_that_do_not_fit(ring, module, inertia, said):
    drawn = {"face_width": 0.02, "carrier": "arm", "backlash": 60e-6, "damping_ratio": 0.05, "stiffness_cos": [0.0]}
    meshes = [gt.Mesh(between=("sun", f"p{n}"), teeth=(31, 20), normal_module=1.5e-3, **drawn) for n in range(3)]
    meshes += [gt.Mesh(between=(f"p{n}", "ring"), teeth=(20, ring), normal_module=module, internal=True, **drawn) for n in range(3)]
    planets = [gt.Body(name=f"p{n}", inertia=inertia) for n in range(3)]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gt.Train(bodies=[*BODIES, *planets], meshes=meshes)
    found = [str(one.message) for one in caught if "one distance" in str(one.message) or "discs of steel" in str(one.message)]
    assert found == [] if said == "" else found and said in found[0]


@pytest.mark.parametrize("gears", [("sun", "planet"), ("planet", "ring")])
def test_a_set_of_a_sun_or_a_ring_alone(gears):
    """Warnings of sets hold for those that lack a ring or a sun."""
    inside = gears[1] == "ring"
    meshes = [gt.Mesh(between=[gear if gear != "planet" else f"p{n}" for gear in gears], carrier="arm", internal=inside,
                      teeth=(20, 71) if inside else (31, 20), normal_module=1.5e-3, face_width=0.02, damping_ratio=0.05,
                      stiffness_cos=[0.1]) for n in range(3)]
    bodies = [gt.Body(name="arm", held=True), gt.Body(name="ring" if inside else "sun", inertia=8.2e-4, torque=60.0),
              *(gt.Body(name=f"p{n}", inertia=1e-5, balances=n == 0) for n in range(3))]
    assert len(gt.Train(bodies=bodies, meshes=meshes).natural_frequencies()) == 3


def test_phases_in_degrees():
    """Whole numbers beyond a turn are degrees; multiples of pi are not, nor is a ring more than a cycle behind its sun."""
    pair = gt.Mesh(between=("a", "b"), teeth=(20, 30), normal_module=2e-3, stiffness=1e8)
    bodies = [gt.Body(name="a", inertia=1e-3, torque=1.0), gt.Body(name="b", inertia=1e-3, balances=True)]
    for phase, warned in ((120.0, True), (7 * np.pi, False), (2.0, False)):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            gt.Train(bodies=bodies, meshes=[replace(pair, phase=phase)])
        assert any("unit is the radian" in str(one.message) for one in caught) == warned
    with pytest.raises(gt.InputError, match=r"ring_phase = 180.0: must be >= -6.2832 and <= 6.2832 rad"):
        gt.Train(bodies=BODIES, planetaries=[stage(ring_phase=180.0)])


def test_resonances_of_planets_in_sequence():
    """Harmonics 1 and 2 of the mesh load planets only: they raise no torsional mode, as the response shows, harmonic 3 does."""
    train = gt.Train(bodies=BODIES, planetaries=[stage(backlash=60e-6, sun_error_cos=[1e-6, 1e-6, 1e-6], ring_error_cos=[1e-6])])
    modes = train.modes()
    speeds = 2 * np.array([modes.natural_frequency.min() / 3, modes.natural_frequency.max()])
    crossings = train.campbell(start=speeds[0] / 4, stop=speeds[1]).crossings
    kinds = {(str(modes.kind[one.mode - 1]).split()[0], one.order.order): one.over_mean for one in crossings}
    assert {kind for kind, _ in kinds} == {"torsional", "planets"}
    for (kind, order), height in kinds.items():
        assert (height > 1e-3) == ((kind == "torsional") == (order % 3 == 0)), (kind, order, height)


def test_modes_of_two_equal_sets():
    """Four modes of planets have one frequency, and are any mixture of both sets."""
    bodies = [gt.Body(name="in", inertia=0.02, torque=100.0), gt.Body(name="sun", inertia=0.004), gt.Body(name="out", inertia=0.03),
              gt.Body(name="arm", held=True), gt.Body(name="car", inertia=8.0, balances=True)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sets = [replace(stage(backlash=60e-6), name=name, sun="sun", ring=ring, carrier=carrier)
                for name, ring, carrier in (("front", "in", "out"), ("rear", "out", "arm"))]
        train = gt.Train(bodies=bodies, planetaries=sets, shafts=[gt.Shaft(between=("out", "car"), stiffness=2e4)])
    modes = train.modes()
    names = list(modes.body)
    for kind, turning in zip(modes.kind, modes.rotation, strict=True):
        planets = {name: turning[[place for place, body in enumerate(names) if body.startswith(f"{name} planet")]]
                   for name in ("front", "rear")}
        moving = [name for name, own in planets.items() if np.ptp(own) > 1e-6]
        assert str(kind) == (f"planets of {', '.join(moving)}" if moving else "torsional")
    assert sum(str(kind).startswith("planets of") for kind in modes.kind) == 4


def test_turns_have_the_sign_of_their_sense():
    numbers = short().explain()
    assert numbers["arm"]["turns"] == pytest.approx(17 / 78) and numbers["stage 1 planet 1"]["turns"] < 0


@pytest.mark.parametrize("ratio", [0.3333, 0.4251, 0.33333, -0.4458, np.pi / 8])
def test_any_ratio_of_speeds_of_one_set(ratio):
    """All meshes have one frequency, z_s |n_s - n_c| by Willis, so the order is 1."""
    bodies = [gt.Body(name="sun", inertia=1e-3, torque=100.0), gt.Body(name="ring", inertia=0.1, balances=True, speed_ratio=ratio),
              gt.Body(name="arm", inertia=0.08, balances=True)]
    train = short(teeth=(37, 23, 83), bodies=bodies, planets=4)
    about = train.explain()
    assert {about[f"mesh {number}"]["order"] for number in range(1, 9)} == {1}
    assert about["train"]["speed_ratio"] == pytest.approx(1 / (37 * abs(1 - (37 + 83 * ratio) / 120)), rel=1e-12)


@pytest.mark.parametrize(("ratio", "period", "off"), [(4 / 3, 3.0, 0.0), (1.33333333, 3.0, 1e-8), (1.87331234, None, 1e-5)])
def test_ratios_of_speeds_of_two_sets(ratio, period, off):
    """Exact, given with eight decimals, or without a common period, which a warning says; frequencies by Willis."""
    case = gt.read_case(ROOT / "namelists" / "hybrid.nml").train
    bodies = [replace(body, speed_ratio=ratio) if body.speed_ratio is not None else body for body in case.bodies]
    with pytest.warns(gt.DrawingWarning, match="no common period; the mesh") if off else _nothing():
        train = replace(case, bodies=bodies)
    about = train.explain()
    period = about["train"]["speed_ratio"] if period is None else period
    assert about["train"]["speed_ratio"] == pytest.approx(period, rel=1.1 * off)
    turns = {name: about[name]["turns"] for name in train.body_labels if name != "housing"}
    for number, mesh in enumerate(train.meshes, 1):
        wanted = mesh.teeth[0] * abs(turns.get(mesh.between[0], 0.0) - turns.get(mesh.carrier, 0.0))
        assert about[f"mesh {number}"]["order"] / period == pytest.approx(wanted, rel=max(1e-12, 1.1 * off))


def test_masses_of_planets_add_to_the_carrier():
    told = short(planet_mass=1.5).explain()["arm"]
    assert told["added_inertia"] == pytest.approx(3 * 1.5 * 0.078**2, rel=1e-12)
    assert told["inertia"] == pytest.approx(0.085 + 3 * 1.5 * 0.078**2, rel=1e-12)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            {"planets": 4},
            r"planets = 4: cannot be equally spaced: \(z_sun \+ z_ring\)/planets = 78/4 .* angles = 0.0, 92.307692, 180,",
        ),
        (
            {"teeth": (17, 22, 62)},
            "do not fit on one axis: without backlash .* 0.078 m .*, 0.08 m .* a ring of 61 teeth",
        ),
        ({"teeth": (17, 22, 20)}, "teeth value 3 = 20: must be > 22, the teeth of a planet"),
        ({"planets": 6}, "planets = 6: overlap: the tip diameter of 0.096 m .*, 0.078 m"),
        ({"planets": None, "angles": (0.0, 120.0, 239.0)}, "angles value 3 = 239.0: cannot be assembled: .* the nearest is 240"),
        ({"tip_diameter": (0.073, 0.09, 0.24)}, "sun meshes: teeth = 17, 22: must give a transverse contact ratio > 1"),
        ({"ring_face_width": 0.04}, "lacks face_width .* beside ring_face_width"),
        ({"elastic_modulus": (2e11, 2e11)}, "elastic_modulus = 2 values: must be 3 values"),
        ({"stiffness": (1.0, 2.0, 3.0)}, "stiffness = 3 values: must be 2 values"),
        ({"planet_errors": (0.0, 2e-6, 3.0)}, "planet_errors value 3 = 3.0: must be smaller than the module, 0.004 m"),
        ({"planets": None}, "lacks planets"),
        ({"planet_inertia": None}, "lacks planet_inertia"),
    ],
)
def test_wrong_sets_are_refused(more, message):
    given = {"teeth": (17, 22, 61), "planets": 3, "planet_inertia": 2.2e-3, "stiffness": 1e9, **COMMON, **more}
    with pytest.raises(gt.InputError, match=f"&planetary 1: .*{message}"):
        gt.Train(bodies=BODIES, planetaries=[gt.Planetary(name="stage 1", sun="sun", ring="ring", carrier="arm", **given)])


def test_a_set_without_a_module_lacks_that_alone():
    given = {"teeth": (17, 22, 61), "planets": 3, "planet_inertia": 2.2e-3, "stiffness": 1e9, **COMMON, "normal_module": None}
    members = gt.Planetary(name="stage 1", sun="sun", ring="ring", carrier="arm", planet_errors=(0.0, 2e-6, -1e-6), **given)
    with pytest.raises(gt.InputError, match="lacks normal_module") as said:
        gt.Train(bodies=BODIES, planetaries=[members])
    assert "planet_errors" not in str(said.value)


def test_a_number_of_planets_out_of_range_is_told_at_once(tmp_path):
    """Nothing is made of a set before its numbers are in range: a thousand million planets took minutes and all memory."""
    path = tmp_path / "case.nml"
    bodies = "&body name = 'sun', inertia = 1e-3 /\n&body name = 'ring', held = .true. /\n&body name = 'arm', balances = .true. /\n"
    members = "&planetary name = 's', sun = 'sun', ring = 'ring', carrier = 'arm', teeth = 27, 36, 99"
    path.write_text(f"&train /\n{bodies}{members}, planets = 1000000000, normal_module = 2.5e-3, face_width = 0.03 /\n&modes /\n")
    with pytest.raises(gt.InputError, match="planets = 1000000000: must be >= 2 and <= 1000"):
        gt.read_case(path)


def test_a_bore_of_planets_is_told_once(executable, tmp_path):
    case = (ROOT / "namelists" / "planetary.nml").read_text(encoding="utf-8").replace("planet_bore = 0.030", "planet_bore = 30")
    (tmp_path / "case.nml").write_text(case)
    told = run(executable, "--check", "case.nml", cwd=tmp_path).stderr.splitlines()
    assert len(told) == 1 and "planet_bore = 30.0: must be < 0.09 m" in told[0]


def test_a_warning_of_several_meshes_is_one():
    bodies = [gt.Body(name="sun", inertia=1e-3, torque=50.0), gt.Body(name="arm", held=True),
              gt.Body(name="ring", inertia=0.1, balances=True)]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gt.Train(bodies=bodies, planetaries=[gt.Planetary(
            name="a", sun="sun", ring="ring", carrier="arm", teeth=(15, 24, 63), planets=3, face_width=0.02, **COMMON)])
    undercut = [str(each.message) for each in caught if "undercut" in str(each.message)]
    assert len(undercut) == 1 and undercut[0].startswith("&mesh 1 to 3: ")


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_a_set_that_idles_has_no_load_share():
    """A Simpson set in second gear: the rear set rattles, and what integration leaves of its mean forces is no load."""
    bodies = [gt.Body(name="front ring", inertia=0.26, torque=400.0), gt.Body(name="sun", held=True),
              gt.Body(name="output", inertia=0.5, balances=True), gt.Body(name="rear carrier", inertia=0.01)]
    common = {"sun": "sun", "teeth": (28, 17, 62), "planets": 3, "normal_module": 1.6e-3, "face_width": 0.025, "helix_angle": 20.0,
              "damping_ratio": 0.05, "planet_bore": 0.012, "backlash": 80e-6, "sun_error_cos": 2e-6, "ring_error_cos": 2e-6}
    train = gt.Train(bodies=bodies, planetaries=[gt.Planetary(name="front", ring="front ring", carrier="output", **common),
                                                 gt.Planetary(name="rear", ring="output", carrier="rear carrier", **common)])
    motion = train.integrate(2000.0, unit="rpm")
    assert motion.separation_fraction[6:].max() > 0
    assert np.isfinite(motion.load_share[:3]).all() and np.isnan(motion.load_share[3:]).all()
    assert np.isnan(motion.load_share_maximum[3:]).all()


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_the_largest_force_is_named():
    """Planet 2 bears the most, and so has the smallest largest force over its mean."""
    train = short(teeth=(20, 20, 60), planets=5, planet_errors=(0, 8e-6, 1e-6, 0.5e-6, 1.5e-6), sun_stiffness_cos=0.2,
                  ring_stiffness_cos=0.2)
    branch = train.response(start=2000, stop=2300, unit="rpm", harmonics=0, tolerance=1e-3)
    largest = np.nanmax(branch.mesh_force_maximum, axis=0)
    mesh = int(largest.argmax())
    assert mesh == 1
    said = re.sub(r"\s+", " ", str(branch))
    assert re.search(rf"2 \(stage 1 sun 2\)[^:]*: largest force {float(f'{largest[mesh]:.4g}'):.0f} N", said)
