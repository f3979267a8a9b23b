"""Gearboxes from REXS files: the same numbers as typed by hand, what is assumed and told, what is refused.

The files are written after the published schema by rexs_files.py. The files that other projects publish are read in development.
"""

from math import acos, atan, cos, pi, radians, tan

import numpy as np
import pytest
from conftest import run
from rexs_files import Gearbox, one_stage, planetary, said, scripts, two_stages

import geartrain as gt
from geartrain.files.din3967 import mean_thinning
from geartrain.files.rexs import case_of_rexs
from geartrain.files.rexs_command import main

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")

DENSITY, MODULUS = 7850.0, 2.1e11 / 2.6
COSINE = cos(radians(15))


def inertia(*cylinders):
    """Of cylinders (outer diameter, bore, width) in mm."""
    return sum(pi / 32 * DENSITY * width * (outer**4 - bore**4) * 1e-15 for outer, bore, width in cylinders)


def stiffness(*cylinders):
    """Of cylinders (outer diameter, bore, length) in mm, in series."""
    return 1 / sum(32 * length * 1e9 / (pi * MODULUS * (outer**4 - bore**4)) for outer, bore, length in cylinders)


def cone(begin, end, length, bore, spring):
    """A cone in 20,000 slices: its inertia, or its stiffness."""
    middle = begin + (end - begin) * (np.arange(20000) + 0.5) / 20000
    polar = middle**4 - bore**4
    if spring:
        return 1 / (32e9 * length / (pi * MODULUS) * np.mean(1 / polar))
    return pi / 32 * DENSITY * length * np.mean(polar) * 1e-15


def apart(teeth, module, shifts, distance, helix=0.0):
    """Backlash of teeth of full thickness at the working pitch circles: the pitch there less both thicknesses."""
    transverse = atan(tan(radians(20)) / cos(radians(helix)))
    working = acos(sum(teeth) * module / cos(radians(helix)) / 2 * cos(transverse) / distance)
    involutes = tan(transverse) - transverse - tan(working) + working
    halves = [pi / (2 * z) + 2 * x * tan(radians(20)) / z + involutes for z, x in zip(teeth, shifts, strict=True)]
    return 2 * distance / sum(teeth) * (pi - sum(z * half for z, half in zip(teeth, halves, strict=True)))


def by_hand():
    """The reducer `two_stages` as an engineer types it, with the numbers that a drawing has not worked out beforehand."""
    # Each stretch of a shaft between two places goes to either by half; the cone of the middle shaft is from 100 to 160 mm.
    bodies = [
        gt.Body(name="motor", inertia=inertia((30, 0, 80)), torque=90.0),
        gt.Body(name="pinion 1", inertia=inertia((30, 0, 120), (23 * 2.5 / COSINE, 30, 42))),
        gt.Body(name="wheel 1", inertia=inertia((40, 10, 70), (71 * 2.5 / COSINE, 40, 40))),
        gt.Body(name="pinion 2", inertia=inertia((40, 10, 30), (19 * 4 / COSINE, 40 + 10 / 6, 72)) + cone(40, 50, 60, 10, False)),
        gt.Body(name="wheel 2", inertia=inertia((60, 0, 150), (80 * 4 / COSINE, 60, 70))),
        gt.Body(name="machine", inertia=inertia((60, 0, 100)), balances=True),
    ]
    middle = 1 / (1 / stiffness((40, 10, 70)) + 1 / cone(40, 40 + 10 / 6, 10, 10, True))
    springs = [stiffness((30, 0, 140)), middle, stiffness((60, 0, 180))]
    ends = ("motor", "pinion 1"), ("wheel 1", "pinion 2"), ("wheel 2", "machine")
    shafts = [gt.Shaft(between=pair, stiffness=spring, damping_ratio=0.01) for pair, spring in zip(ends, springs, strict=True)]
    # DIN 3967 c25: mean thinning of the pair in the normal section [um], brought to the working circle; and the distance.
    backlash = [1e-6 * (105 + 140) / COSINE * 122 / (94 * 2.5 / 2 / COSINE) + apart((23, 71), 2.5e-3, (0.1, 0.0), 0.122, 15),
                1e-6 * (105 + 185) / COSINE * 206 / (99 * 4 / 2 / COSINE) + apart((19, 80), 4e-3, (0.2, 0.0), 0.206, 15)]
    drawn = {"helix_angle": 15.0, "damping_ratio": 0.05, "elastic_modulus": [2.1e11, 2.1e11]}
    meshes = [gt.Mesh(between=("pinion 1", "wheel 1"), teeth=[23, 71], normal_module=2.5e-3, face_width=0.040,
                      profile_shift=[0.1, 0.0], centre_distance=0.122, backlash=backlash[0], **drawn),
              gt.Mesh(between=("pinion 2", "wheel 2"), teeth=[19, 80], normal_module=4e-3, face_width=0.070,
                      profile_shift=[0.2, 0.0], centre_distance=0.206, backlash=backlash[1], **drawn)]
    return gt.Train(bodies=bodies, shafts=shafts, meshes=meshes)


@pytest.fixture(name="reducer_file")
def _reducer_file(tmp_path):
    return two_stages().write(tmp_path / "gearbox.rexs")


def test_the_same_modes_as_typed_by_hand(reducer_file):
    # The slices of the cone are good to 1e-9; all else is rounding.
    assert np.allclose(gt.read_rexs(reducer_file).natural_frequencies(), by_hand().natural_frequencies(), rtol=2e-9)


def test_the_same_response_as_typed_by_hand(tmp_path):
    read = gt.read_rexs(one_stage().write(tmp_path / "gearbox.rexs"))
    typed = gt.Train(
        bodies=[gt.Body(name="motor", inertia=inertia((30, 0, 80)), torque=90.0),
                gt.Body(name="pinion", inertia=inertia((30, 0, 120), (57.5, 30, 42))),
                gt.Body(name="wheel", inertia=inertia((60, 20, 145), (177.5, 60, 40))),
                gt.Body(name="machine", inertia=inertia((60, 20, 105)), balances=True)],
        shafts=[gt.Shaft(between=("motor", "pinion"), stiffness=stiffness((30, 0, 140)), damping_ratio=0.01),
                gt.Shaft(between=("wheel", "machine"), stiffness=stiffness((60, 20, 190)), damping_ratio=0.01)],
        meshes=[gt.Mesh(between=("pinion", "wheel"), teeth=[23, 71], normal_module=2.5e-3, face_width=0.040,
                        profile_shift=[0.1, 0.1], centre_distance=0.118, damping_ratio=0.05, elastic_modulus=[2.1e11, 2.1e11],
                        backlash=1e-6 * (105 + 140) * 118 / 117.5 + apart((23, 71), 2.5e-3, (0.1, 0.1), 0.118))])
    assert np.allclose(read.natural_frequencies(), typed.natural_frequencies(), rtol=1e-12)
    ours, theirs = (train.response(start=1500.0, stop=1480.0, unit="rpm", harmonics=4).at(1490.0)[0] for train in (read, typed))
    assert np.allclose(ours.mesh_force_maximum, theirs.mesh_force_maximum, rtol=1e-12)
    assert np.allclose(ours.coefficients, theirs.coefficients, rtol=0, atol=1e-12 * abs(theirs.mean[0]))
    assert ours.mean[0] > 0 and (ours.shaft_torque_mean > 0).all()  # what is named first drives


def test_the_case_has_the_same_numbers(tmp_path):
    file = one_stage().write(tmp_path / "gearbox.rexs")
    (tmp_path / "case.nml").write_text(case_of_rexs(file), encoding="utf-8")
    case, read = gt.read_case(tmp_path / "case.nml"), gt.read_rexs(file)
    asked = {"start": 1500.0, "stop": 1490.0, "unit": "rpm", "harmonics": 2}
    assert np.array_equal(*(train.response(**asked).rms for train in (case.train, read)))
    assert case.modes and (case.response["start"], case.response["stop"], case.response["unit"]) == (300.0, 1800.0, "rpm")


def test_every_number_of_the_case_is_told(reducer_file):
    text = case_of_rexs(reducer_file)
    groups = text[: text.index("&modes")].split("\n&train")[1]
    numbers = [line for line in groups.splitlines() if "=" in line and "'" not in line.split("!")[0]]
    assert len(numbers) > 40 and not [line for line in numbers if "!" not in line]
    assert any(line.strip().startswith("teeth = 23, 71") and line.endswith("! Pinion 1 [11], Wheel 1 [14]") for line in numbers)
    asked = {line.split("=")[0].strip() for line in numbers if "MISSING" in line}
    assert asked == {"added_inertia", "damping_ratio", "dedendum"}


@pytest.mark.parametrize("ending", [".rexsj", ".rexsz"])
def test_the_three_formats_are_equal(reducer_file, tmp_path, ending):
    other = two_stages().write(tmp_path / ("gearbox" + ending))
    assert gt.read_rexs(other).namelist() == gt.read_rexs(reducer_file).namelist()


@pytest.mark.parametrize("version", ["1.0", "1.1", "1.2", "1.3", "1.4", "1.5", "1.7", "2.0.0"])
def test_versions_are_equal(reducer_file, tmp_path, version):
    """Names of attributes and types of components change; in 1.0 gears are placed by their begin."""
    read = gt.read_rexs(two_stages(version).write(tmp_path / "gearbox.rexs"))
    assert read.namelist() == gt.read_rexs(reducer_file).namelist()


def test_coded_arrays(reducer_file, tmp_path):
    (tmp_path / "gearbox.rexsj").write_text(two_stages().json(coded=True))
    assert gt.read_rexs(tmp_path / "gearbox.rexsj").namelist() == gt.read_rexs(reducer_file).namelist()


def test_positions_count_before_coordinates(tmp_path):
    """The middle of a gear by its position, where it has one, in every version."""
    box = two_stages("1.0")
    box.change("Pinion 1 [", support_vector=("mm", [150.0, 0.0, 0.0]), u_coordinate_on_shaft=("mm", 7.0))
    assert gt.read_rexs(box.write(tmp_path / "a.rexs")).namelist() == \
        gt.read_rexs(two_stages("1.0").write(tmp_path / "b.rexs")).namelist().replace("'b'", "'a'")


# Planetary stages.

def test_a_planetary_stage_is_a_set(tmp_path):
    read = gt.read_rexs(planetary().change("Ring [", face_width=("mm", 40.0)).write(tmp_path / "set.rexs"))
    mass = pi / 4 * DENSITY * (50 * (40**2 - 30**2) + 50 * (88**2 - 40**2)) * 1e-9
    pins = pi / 4 * DENSITY * 60 * 20**2 * 1e-9 * 0.078**2 + inertia((20, 0, 60))
    sides = [1e-6 * (105 + 105), 1e-6 * (105 + 140)]  # at reference diameters of 68, 88 and 244 mm
    typed = gt.Train(
        speed_of="motor",
        bodies=[gt.Body(name="motor", inertia=inertia((34, 0, 67.5)), torque=1e5 / (1500 * pi / 30)),
                gt.Body(name="sun", inertia=inertia((34, 0, 82.5), (68, 34, 50))), gt.Body(name="ring", held=True),
                gt.Body(name="carrier", inertia=inertia((80, 60, 50), (219, 80, 8)) + 3 * pins),
                gt.Body(name="machine", inertia=inertia((80, 60, 50)), balances=True)],
        shafts=[gt.Shaft(between=("motor", "sun"), stiffness=stiffness((34, 0, 115)), damping_ratio=0.01),
                gt.Shaft(between=("carrier", "machine"), stiffness=stiffness((80, 60, 90)), damping_ratio=0.01)],
        planetaries=[gt.Planetary(name="set", sun="sun", ring="ring", carrier="carrier", teeth=[17, 22, 61], planets=3,
                                  normal_module=4e-3, face_width=0.05, ring_face_width=0.04, elastic_modulus=[2.1e11] * 3,
                                  centre_distance=0.078, backlash=sides,
                                  damping_ratio=[0.05], planet_mass=mass, planet_inertia=inertia((40, 30, 50), (88, 40, 50)))])
    assert np.allclose(read.natural_frequencies(), typed.natural_frequencies(), rtol=1e-11)
    ours, theirs = (train.response(start=1500.0, stop=1499.0, harmonics=1).mesh_force_maximum for train in (read, typed))
    # The bodies stand in another order, so that sums are rounded otherwise.
    assert np.allclose(ours[0], theirs[0], rtol=1e-9)


def test_planets_of_unlike_widths_are_no_set(tmp_path):
    box = planetary()
    row = next(row for row in box.components if row[2].startswith("Planet [") and row[1] == "cylindrical_gear")
    box.components[row[0] - 1] = *row[:3], {**row[3], "face_width": ("mm", 20.0)}
    read = gt.read_rexs(box.write(tmp_path / "set.rexs"))
    assert said(read.notes, "assumed", "no set of equal planets with one gear each")
    assert sorted(mesh.face_width for mesh in read.meshes) == [0.02] * 2 + [0.05] * 4


@pytest.mark.parametrize(("angles", "written"), [([0.0, 120.0, 240.0], "planets = 3"), ([0.0, 115.0, 240.0], "angles = "),
                                                 ([240.0, 0.0, 120.0], "planets = 3")])
def test_planets_by_their_positions(tmp_path, angles, written):
    box = planetary(angles=angles)
    try:
        text = case_of_rexs(box.write(tmp_path / "set.rexs"))
    except gt.InputError as error:  # planets at 115 degrees do not fit between teeth: asked of the train, not of the text
        text = str(error)
    assert f"   {written}" in text


def test_a_carrier_that_drives(tmp_path):
    """As in a wind turbine: seen from the carrier the ring drives."""
    box = planetary().change("Motor", power=None, defines_torque=None)
    box.change("Machine", torque_around_u_axis=("N m", 2900.0), defines_torque=("none", True))
    text = case_of_rexs(box.write(tmp_path / "set.rexs"))
    assert "driving = 'ring'" in text
    train = gt.read_rexs(tmp_path / "set.rexs")
    assert train.response(start=1500.0, stop=1499.0, harmonics=1).mean.min() > 0  # all meshes on their drive flanks


@pytest.mark.parametrize("defines", [None, False, True])
def test_every_torque_of_the_file_counts(tmp_path, defines):
    """Also of a second motor that does not define the torque; the machine without a torque balances."""
    box = two_stages()
    box.load(box.number("Input"), "Generator", 60.0, torque_around_u_axis=("N m", 50.0),
             **({} if defines is None else {"defines_torque": ("none", defines)}))
    read = gt.read_rexs(box.write(tmp_path / "a.rexs"))
    torque = {body.name.split(" [")[0]: body.torque for body in read.bodies}
    assert torque["Generator"] == 50.0 and torque["Motor"] == 90.0 and read.bodies[-1].balances
    assert bool(said(read.notes, "assumed", "its torque of 50 N m acts")) == (defines is not True)


def test_speeds_and_places_that_contradict(tmp_path):
    box = two_stages().change("Output [", rotational_speed=("1 / min", 200.0))
    box.change("Wheel 1 [", u_coordinate_on_shaft=("mm", 5.0))
    notes = gt.read_rexs(box.write(tmp_path / "a.rexs")).notes
    assert said(notes, "not used", "its speed of 200 1/min: by the teeth it turns at 115.40")
    assert said(notes, "assumed", "Stage 1 [23]: its gears mesh, although their faces are 4 mm apart along the axes")
    assert not any("apart along" in note or "its speed of" in note for note in gt.read_rexs(two_stages().write(
        tmp_path / "b.rexs")).notes)


def test_unlike_planets_are_meshes(tmp_path):
    """Planets of unlike teeth are no set: their meshes stand for themselves, on the carrier, whose inertia has their masses."""
    box = planetary(planets=2)
    one = box.number("Planet [")
    box.change(f"Planet [{one}]", number_of_teeth=("none", 21))
    box.change("Planet left", addendum_modification_coefficient=None).change("Planet right", addendum_modification_coefficient=None)
    train = gt.read_rexs(box.write(tmp_path / "set.rexs"))
    assert [mesh.carrier for mesh in train.meshes] == [f"carrier of Set [{box.number('Set')}]"] * 4
    assert any("phase in the mesh cycle" in note for note in train.notes)


# What is told.

def notes_of(box, tmp_path, **asked):
    return gt.read_rexs(box.write(tmp_path / "gearbox.rexs"), **asked).notes


def test_what_rexs_lacks_is_asked_for(tmp_path):
    notes = notes_of(two_stages(), tmp_path)
    assert said(notes, "missing", "Motor [25], Machine [26]: inertia of the machine there")
    assert said(notes, "missing", "damping ratios 0.05 of meshes and 0.01 of shafts")
    assert said(notes, "assumed", "backlash 337 um, by DIN 3967 c25: mean tooth thickness, mean distance, 82 um of them")
    assert gt.Train(bodies=[gt.Body(name="a", inertia=1.0), gt.Body(name="b", inertia=1.0, balances=True)],
                    meshes=[gt.Mesh(between=("a", "b"), driving_radius=1.0, driven_radius=1.0, stiffness=1.0)],
                    characteristic_length=1.0, characteristic_frequency=1.0).notes == ()


@pytest.mark.parametrize(("name", "attributes", "kind", "words"), [
    ("Pinion 1", {"tip_diameter": ("mm", 1.0)}, "assumed", "a tip diameter of 1 mm cannot be, at 23 teeth of module 2.5 mm"),
    ("Pinion 1", {"tooth_thickness_deviation_tolerance_series_din_3967_1978": None}, "assumed", "by DIN 3967 c25"),
    ("Stage 1", {"minimum_transverse_backlash": ("mm", 0.1), "maximum_transverse_backlash": ("mm", 0.2)}, "assumed",
     "backlash 150 um, the mean of 100 and 200 um"),
    ("Stage 1", {"minimum_transverse_backlash": ("mm", 0.1)}, "not used", "transverse backlash: must have a smallest"),
    ("Input", {"rotational_speed": ("", 1500.0)}, "assumed", "in 1 / min, the unit of the standard, as it has none"),
    ("Stage 1", {"center_distance": None}, "assumed", "centre distance 122 mm, by the positions of the gears"),
    ("Steel", {"density": None}, "missing", "density; that of steel"),
    ("Steel", {"poisson_ratio": ("none", 3.0)}, "assumed", "a Poisson's ratio of 3 is none of a solid; 0.3 (steel)"),
    ("Steel", {"shear_modulus": ("MPa", 60000.0)}, "assumed", "the shear modulus of 6e+10 N/m^2 as given, though modulus of elas"),
    ("Steel", {"elastic_modulus": ("N / mm^2", 206.0)}, "assumed", "a modulus of elasticity of 2.06e+08 N/m^2 is none of a solid"),
    ("Wheel 1", {"tooth_thickness_deviation_tolerance_series_din_3967_1978": None}, "missing", "c25, as of its mate"),
    ("Wheel 1", {"face_width": None}, "missing", "face width; 42 mm, that of its mate"),
    ("Pinion 1", {"tip_diameter": ("mm", 65.0)}, "missing", "Wheel 1 [14]: tip diameter; those of the pair are of the basic rack"),
    ("Motor", {"torque_around_u_axis": None}, "missing", "at which the most loaded mesh has 100 N/mm"),
    ("Motor", {"u_coordinate_on_shaft": None}, "missing", "place on its shaft; u = 0"),
    ("Motor", {"power": ("kW", 50.0)}, "not used", "its power of 50 kW: 90 N m at 1500 1/min are 14.14 kW"),
    ("Input", {"rotational_speed": None}, "missing", "speed of the gearbox (defines_speed, rotational_speed), so no &response"),
    ("Machine", {"torque_around_u_axis": ("N m", -900.0)}, "not used", "its torque of -900 N m: -1169.79 N m balances the others"),
])
def test_a_note_says_what_was_assumed(tmp_path, name, attributes, kind, words):
    notes = notes_of(two_stages().change(name + " [", **attributes), tmp_path)
    assert said(notes, kind, words)
    assert not said(notes, "missing", "torque; 0")


def test_the_shear_modulus_of_a_file(tmp_path):
    box = two_stages().change("Steel [", shear_modulus=("MPa", 60000.0))
    assert {shaft.shear_modulus for shaft in gt.read_rexs(box.write(tmp_path / "gearbox.rexs")).shafts if shaft.length} == {6e10}


@pytest.mark.parametrize("angle", [None, 22.5])
def test_a_pressure_angle_that_is_missing(tmp_path, angle):
    """It is taken from the mate; where both lack it, 20 degrees are."""
    given = None if angle is None else ("deg", angle)
    box = two_stages().change("Wheel 1 ", normal_pressure_angle=None).change("Pinion 1 ", normal_pressure_angle=given)
    read = gt.read_rexs(box.write(tmp_path / "gearbox.rexs"))
    assert read.meshes[0].pressure_angle == (angle or 20.0)
    words = "normal pressure angle; " + (f"{angle} degrees, taken from its mate" if angle else "20 degrees")
    assert said(read.notes, "missing", words)


@pytest.mark.parametrize(("unit", "factor"), [("1 / s", 60.0), ("rad / s", 30 / pi)])
def test_units_of_speeds(tmp_path, unit, factor):
    box = two_stages().change("Input [", rotational_speed=(unit, 1500.0 / factor))
    assert "speed_of = 'Motor [25]'" in case_of_rexs(box.write(tmp_path / "a.rexs"))
    assert "1500 1/min in the file" in case_of_rexs(tmp_path / "a.rexs")


def test_backlash_normal_to_the_flanks(tmp_path):
    """Play in the plane of action of the transverse section, times the cosine of the base helix angle."""
    box = two_stages().change("Stage 1", minimum_normal_backlash=("mm", 0.1), maximum_normal_backlash=("mm", 0.2))
    read = gt.read_rexs(box.write(tmp_path / "a.rexs"))
    half = read.explain()["mesh 1"]["half_backlash"]  # in the transverse plane of action
    base_helix = np.arcsin(np.sin(radians(15)) * cos(radians(20)))
    assert 2 * half * np.cos(base_helix) == pytest.approx(150e-6, rel=1e-12)


def test_a_train_without_torques_is_driven_where_its_speed_is_given(tmp_path):
    read = gt.read_rexs(two_stages(torque=False).change("Motor", defines_torque=None).write(tmp_path / "a.rexs"))
    assert read.body_labels[0].startswith("Motor") and read.bodies[0].torque > 0
    assert [body.name for body in read.bodies if body.balances] == ["Machine [26]"]
    assert read.meshes[0].between == ("Pinion 1 [11]", "Wheel 1 [14]")


def test_a_rim_without_width_has_that_of_its_mate(tmp_path):
    whole, lacking = (gt.read_rexs(two_stages().change("Wheel 1 [", face_width=width).write(tmp_path / "a.rexs")).explain()
                      for width in (("mm", 42.0), None))
    assert lacking["Wheel 1 [14]"]["inertia"] == pytest.approx(whole["Wheel 1 [14]"]["inertia"], rel=1e-12)


def test_a_profile_shift_of_zero_that_cannot_be(tmp_path):
    """Some programs write 0 where a value is open: 0.2 in all at a centre distance that needs 0.4."""
    box = two_stages().change("Stage 2", center_distance=("mm", 206.5))
    read = gt.read_rexs(box.write(tmp_path / "a.rexs"))
    assert said(read.notes, "assumed", "a profile shift of 0 contradicts the centre distance")
    assert read.meshes[1].profile_shift[0] == 0.2 and 0.1 < read.meshes[1].profile_shift[1] < 0.3


def test_couplings(tmp_path):
    """Of 1e20 N mm/rad rigid, of 1e6 a spring, open not there."""
    box = two_stages()
    shaft = box.shaft("Stub", [(50.0, 0.0, 100.0)])
    output = box.number("Output")
    ends = {"u_coordinate_on_shaft_inner_side": ("mm", 250.0), "u_coordinate_on_shaft_outer_side": ("mm", 50.0)}
    coupling = box.couple("coupling", "Coupling", output, shaft, **ends)
    found = {}
    for stiff in (1e20, 1e6):
        box.components[coupling - 1][3]["rotational_stiffness"] = ("N mm / rad", stiff)
        found[stiff] = gt.read_rexs(box.write(tmp_path / "a.rexs"))
    assert [len(train.bodies) for train in found.values()] == [7, 8]
    assert said(found[1e20].notes, "assumed", f"Coupling [{coupling}]: rigid, as a torsional stiffness of 1e+17 N m/rad means")
    assert found[1e6].shafts[-1].stiffness == 1e3
    opened = box.couple("switchable_coupling", "Clutch", output, shaft, 1e20, **ends, is_engaged=("none", [False]))
    box.relations = [row for row in box.relations if row[1].get("assembly") != coupling]
    assert opened and len(gt.read_rexs(box.write(tmp_path / "a.rexs")).bodies) == 7


def test_an_internal_pair_and_an_axis_the_other_way(tmp_path):
    """A shaft whose axis points the other way has its torque and its speed the other way too."""
    def box(axis):
        made = Gearbox()
        steel = made.steel()
        one = made.shaft("One", [(40.0, 0.0, 100.0)], steel, defines_speed=("none", True),
                         rotational_speed=("1 / min", 600.0 * axis[0]), axis=axis)
        other = made.shaft("Two", [(300.0, 260.0, 100.0)], steel)
        pinion = made.gear(one, "Pinion", 22, 4.0, 50.0, 40.0, material=steel)
        ring = made.gear(other, "Ring", 61, 4.0, 50.0, 40.0, kind="ring_gear", material=steel)
        made.stage("Pair", pinion, ring, 78.0)
        made.load(one, "Motor", 0.0, torque_around_u_axis=("N m", 50.0 * axis[0]), defines_torque=("none", True))
        made.load(other, "Machine", 100.0)
        return gt.read_rexs(made.write(tmp_path / "a.rexs"))

    ahead, back = box((1.0, 0.0, 0.0)), box((-1.0, 0.0, 0.0))
    assert ahead.meshes[0].internal and ahead.bodies[0].torque == 50.0 and ahead.namelist() == back.namelist()


def test_an_idle_pair_is_dragged(tmp_path):
    """A wheel without load, loose beside the others: its teeth bear the drag alone, so that the train has a rest."""
    box = one_stage()
    loose = box.shaft("Loose", [(30.0, 0.0, 40.0)], at=(140.0, 0.0, 100.0))
    idle = box.gear(loose, "Idle", 71, 2.5, 10.0, 20.0)
    box.stage("Idle stage", box.number("Pinion ["), idle, 118.0)
    train = gt.read_rexs(box.write(tmp_path / "a.rexs"))
    dragged = [body for body in train.bodies if body.torque and body.torque < 0]
    assert [body.name for body in dragged] == [f"Idle [{idle}]"]
    assert dragged[0].torque == pytest.approx(-1e-3 * 90 * 71 / 23, rel=5e-3)  # written with three digits
    assert said(train.notes, "missing", "drag of idle parts") and train.meshes[1].between[1] == f"Idle [{idle}]"


# Load cases.

def spectrum(tmp_path):
    box = two_stages(torque=False)
    for share, torque, speed in ((20.0, 100.0, 800.0), (50.0, 60.0, 1200.0), (30.0, 90.0, 400.0)):
        box.load_cases.append([(1, "gear_unit", "Gear unit", {"operating_time_fraction": ("%", share)}),
                               (box.number("Input"), "shaft", "Input", {"rotational_speed": ("1 / min", speed)}),
                               (box.number("Motor"), "external_load", "Motor", {"torque_around_u_axis": ("N m", torque)})])
    return box.write(tmp_path / "gearbox.rexs")


def test_load_cases(tmp_path):
    path = spectrum(tmp_path)
    longest, third = gt.read_rexs(path), gt.read_rexs(path, load_case=3)
    assert (longest.bodies[0].torque, third.bodies[0].torque) == (60.0, 90.0)
    assert said(longest.notes, "assumed", "load case 2 of the load spectrum, that of the longest time")
    assert "1200 1/min in the file" in case_of_rexs(path)
    for wrong in (0, 4, True, "2"):
        with pytest.raises(gt.InputError, match=r"load_case"):
            gt.read_rexs(path, load_case=wrong)


# The command and the executable.

def test_the_command(reducer_file, capsys, tmp_path):
    text = case_of_rexs(reducer_file)
    assert main([str(reducer_file)]) == 0 and capsys.readouterr().out == text
    assert main([str(tmp_path / "none.rexs")]) == 4 and "No such file" in capsys.readouterr().err
    assert main([str(reducer_file), "--load-case", "2"]) == 2 and "no load cases" in capsys.readouterr().err


@pytest.mark.full  # starts Python twice
def test_the_executable(reducer_file, executable, tmp_path):
    """By the command of the package, whatever a name of a file has."""
    strange = reducer_file.rename(tmp_path / "it's $(a) gearbox.rexs")
    done = run(executable, "--from-rexs", strange, cwd=tmp_path, env=scripts())
    assert (done.returncode, done.stdout, done.stderr) == (0, case_of_rexs(strange), "")
    done = run(executable, "--from-rexs", "none.rexs", cwd=tmp_path, env=scripts())
    assert done.returncode == 4 and "No such file" in done.stderr and not done.stdout


def test_the_executable_without_the_package(executable, tmp_path):
    done = run(executable, "--from-rexs", "a.rexs", cwd=tmp_path, env={"PATH": "/usr/bin:/bin"})
    assert done.returncode == 2 and "needs geartrain-rexs of the Python package" in done.stderr
    done = run(executable, "--from-rexs", "a.rexs", "b.rexs", cwd=tmp_path)
    assert done.returncode == 2 and "b.rexs is one too many" in done.stderr


# DIN 3967.

@pytest.mark.parametrize(("diameter", "upper", "lower"), [(0.13, 115, 165), (0.30, 155, 215), (0.70, 210, 290), (1.20, 290, 390),
                                                          (1.615, 390, 520)])
def test_thinning_of_din_3967(diameter, upper, lower):
    """c25, as FVA Workbench has worked it out in published files (fva-net/rexs-diff)."""
    assert mean_thinning("c25", diameter) == pytest.approx(1e-6 * (upper + lower) / 2, rel=1e-12)


@pytest.mark.parametrize(("teeth", "module", "helix", "smallest", "largest"), [
    ((27, 51), 4.5, 21.0, 0.22971364245172785, 0.3765541638160784),
    ((23, 34), 6.5, 10.0, 0.21762345074374218, 0.35673552361523214)])
def test_backlash_of_another_program(tmp_path, teeth, module, helix, smallest, largest):
    """Mean transverse backlash [mm] of FVA Workbench, for the stages of its two-stage gearbox of 190 mm (fva-net/rexs-diff)."""
    box = one_stage().change("Stage", center_distance=("mm", 190.0)).change("Output", support_vector=None)
    for name, count, hand in zip(("Pinion [", "Wheel ["), teeth, (1, -1), strict=True):
        box.change(name, number_of_teeth=("none", count), normal_module=("mm", module),
                   helix_angle_reference_diameter=("deg", hand * helix))
    for name in ("Pinion ", "Wheel "):
        for side in ("left", "right"):
            box.change(name + side, addendum_modification_coefficient=None)
    read = gt.read_rexs(box.write(tmp_path / "a.rexs"))
    assert read.meshes[0].backlash == pytest.approx(5e-4 * (smallest + largest), rel=1e-4)


def test_words_that_are_no_series():
    assert mean_thinning(" cd25 ", 0.1) == pytest.approx(90e-6)
    assert [mean_thinning(word, 0.1) for word in ("", "c20", "c31", "x25", "25c", "cc25")] == [None] * 6
    assert mean_thinning("c25", 3.0) is None
