"""REXS files that are damaged, hostile, or of gearboxes that are not read: each ends in InputError with a sentence."""

import json
import random
import zipfile

import pytest
from rexs_files import Gearbox, one_stage, planetary, two_stages

import geartrain as gt
from geartrain.errors import plain
from geartrain.files import rexs_file
from geartrain.files.rexs import case_of_rexs

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")


def refused(path, *words):
    """The message of a file that is not read."""
    with pytest.raises(gt.InputError) as caught:
        gt.read_rexs(path)
    assert [word for word in words if word not in str(caught.value)] == [], str(caught.value)
    return str(caught.value)


# Gearboxes that are not read.

@pytest.mark.parametrize(("name", "attributes", "words"), [
    ("Pinion 1 [", {"number_of_teeth": None}, ["number_of_teeth: is missing"]),
    ("Pinion 1 [", {"number_of_teeth": ("none", 1e9)}, ["must be a whole number from 3 on"]),
    ("Pinion 1 [", {"number_of_teeth": ("none", "many")}, ["number_of_teeth = 'many': must be a number"]),
    ("Pinion 1 [", {"normal_module": ("mm", 3.0)}, ["differ in module or helix angle: 3 mm and 2.5 mm"]),
    ("Pinion 1 ", {"normal_pressure_angle": ("deg", 17.5)},
     ["stage Stage 1", "differ in normal pressure angle: 17.5 and 20 degrees"]),
    ("Pinion 1 [", {"normal_module": ("mm", -3.0)}, ["must be above 0"]),
    ("Pinion 1 [", {"normal_module": ("furlong", 3.0)}, ["unit 'furlong': must be mm or mum or m"]),
    ("Pinion 1 [", {"normal_module": ("m", 2.5)}, ["normal_module = 2500 mm: must be 0.02 to 200 mm"]),
    ("Stage 1", {"center_distance": ("m", 122.0)}, ["a centre distance of 122000 mm", "touch at 121.645 mm"]),
    ("Output [", {"u_axis_vector": ("mm", [1.0, 0.0])}, ["u_axis_vector = ['1.0', '0.0']: must be three numbers"]),
    ("Motor", {"torque_around_u_axis": ("N m", "193,6")}, ["torque_around_u_axis = '193,6': must be a number"]),
    ("Motor", {"torque_around_u_axis": ("N cm", 9000.0)}, ["torque_around_u_axis: unit 'N cm': must be N m or N mm or kN m"]),
    ("Motor", {"torque_around_u_axis": ("mm", 90.0)}, ["torque_around_u_axis: unit 'mm': must be N m"]),
    ("Motor", {"torque_around_u_axis": ("N m", "INF")}, ["torque_around_u_axis = 'INF': must be a number"]),
    ("Motor", {"torque_around_u_axis": None, "power": ("kW", "ten")}, ["power = 'ten': must be a number"]),
    ("Motor", {"defines_torque": ("none", "ja")}, ["defines_torque = 'ja': must be true or false"]),
    ("Input [", {"rotational_speed": ("1 / min", "1480,0")}, ["rotational_speed = '1480,0': must be a number"]),
    ("Input [", {"rotational_speed": ("rpm", 1480.0)}, ["rotational_speed: unit 'rpm': must be 1 / min or 1 / s or rad / s"]),
    ("Input [", {"defines_speed": ("none", "maybe")}, ["defines_speed = 'maybe': must be true or false"]),
    ("Pinion 1 [", {"helix_angle_reference_diameter": ("deg", -15.0)}, ["of the same hand"]),
    ("Pinion 1 [", {"helix_angle_reference_diameter": ("deg", 88.0)}, ["must be at most 60"]),
    ("Pinion 1 [", {"face_width": ("mm", float("nan"))}, ["face_width", "must be a number"]),
    ("Output [", {"u_axis_vector": ("mm", [0.0, 1.0, 0.0])}, ["is not parallel to the others"]),
    ("Output [", {"data_source": ("none", "shafts.rexs")}, ["refers to another file"]),
    ("section", {"inner_diameter_begin": ("mm", 400.0)}, ["400 mm", "leave no wall"]),
    ("section", {"length": ("mm", -40.0)}, ["length = -40 mm: must be above 0"]),
    ("section", {"length": ("mm", 400.0)}, ["mm of its shaft, within section [", "which ends at 400 mm"]),
    ("section", {"length": None}, ["has no section all the way from", "]: without length"]),
    ("Motor", {"transmits_torque": ("none", False)}, ["is the only external load"]),
    ("Machine", {"torque_around_u_axis": ("N m", 1.0), "defines_torque": ("none", True), "transmits_torque": ("none", False)},
     ["external loads that can balance"]),
])
def test_a_gearbox_that_cannot_be_read(tmp_path, name, attributes, words):
    box = two_stages().change(name, **attributes)
    told = refused(box.write(tmp_path / "gearbox.rexs"), "gearbox.rexs", "error: ", *words)
    lined = not any(word in told for word in ("is not parallel", "external load"))
    assert not lined or told.partition("gearbox.rexs:")[2].partition(":")[0].isdigit(), told


def test_the_line_is_that_of_the_attribute(tmp_path):
    """In XML that of the attribute, in JSON that of its component."""
    box = two_stages().change("Pinion 1 [", number_of_teeth=("none", "many"))
    for ending, word in ((".rexs", 'id="number_of_teeth" unit="none">many'), (".rexsj", "{")):
        path = box.write(tmp_path / ("gearbox" + ending))
        line = int(refused(path).partition(f"gearbox{ending}:")[2].partition(":")[0])
        assert word in path.read_text().splitlines()[line - 1]
    assert '"name": "Pinion 1 [' in path.read_text().splitlines()[line + 2]


@pytest.mark.parametrize("kind", ["bevel_stage", "worm_stage"])
def test_stages_of_another_geometry(tmp_path, kind):
    box = two_stages()
    box.add(kind, "Bevel set")
    refused(box.write(tmp_path / "gearbox.rexs"), kind, "only cylindrical and planetary stages are read")


def test_relations_that_contradict(tmp_path):
    """A second one of the same place is not read as if it were not there."""
    for kind, roles, words in (
        ("assembly", {"assembly": "Output", "part": "Pinion 1 ["},
         "cylindrical_gear Pinion 1 [11]: is on 2 shafts: Input [4], Output"),
        ("assembly", {"assembly": "Output", "part": "Motor"}, "external_load Motor [25]: is on 2 shafts: Input [4], Output"),
        ("reference", {"origin": "Wheel 1 [", "referenced": "Cast"},
         "cylindrical_gear Wheel 1 [14]: has 2 materials: Steel [3], Cast"),
        ("stage", {"stage": "Stage 1", "gear_1": "Pinion 2 [", "gear_2": "Wheel 2 ["}, "Stage 1 [23]: has 2 relations to gears"),
    ):
        box = two_stages()
        box.add("material", "Cast", elastic_modulus=("N / mm^2", 170000.0))
        box.relate(kind, **{role: box.number(name) for role, name in roles.items()})
        refused(box.write(tmp_path / "a.rexs"), words)
    box = two_stages()
    same = next(roles for kind, roles in box.relations if kind == "stage")
    box.relate("stage", **same)
    assert gt.read_rexs(box.write(tmp_path / "a.rexs")).bodies[0].name == "Motor [25]"


def test_couplings_load_cases_and_versions_that_cannot_be(tmp_path):
    box = two_stages()
    box.couple("coupling", "Hub", box.number("Input"), box.number("Output"), -1e6, u_coordinate_on_shaft_inner_side=("mm", 5.0),
               u_coordinate_on_shaft_outer_side=("mm", 5.0))
    refused(box.write(tmp_path / "a.rexs"), "coupling Hub [", "rotational_stiffness = -1000 N m/rad: must be 0 (open) or above")
    speed = {"rotational_speed": ("1 / min", 800.0)}
    for part, words in (((1, "gear_unit", "", {"operating_time_fraction": ("%", 165.0)}), "_fraction = 165 %: must be 0 to 100 %"),
                        ((999, "shaft", "", speed), "load case: shaft 999 is no component of the file"),
                        ((1, "shaft", "", speed), "load case: shaft 1 is a gear_unit")):
        box = two_stages(torque=False)
        box.load_cases.append([part])
        for ending in (".rexs", ".rexsj"):
            refused(box.write(tmp_path / f"a{ending}"), words)
    refused(two_stages("2.1").write(tmp_path / "a.rexs"), "version '2.1': must be 1.0 to 2.0 of REXS")
    word = '<attribute id="{}" unit="{}">'
    twice = two_stages().xml().replace(word.format("normal_module", "mm"), word.format("number_of_teeth", "none"), 1)
    (tmp_path / "a.rexs").write_text(twice)
    refused(tmp_path / "a.rexs", "cylindrical_gear Pinion 1 [", "number_of_teeth stands in it twice")


def test_many_components_take_no_longer_each(tmp_path):
    """Notes of 20,000 components: the time of each must not grow with their number (a minute, where it does)."""
    box = two_stages()
    for _ in range(20000):
        box.shaft("Idle", [(30.0, 0.0, 200.0)])
    notes = gt.read_rexs(box.write(tmp_path / "a.rexs")).notes
    assert any("and 19997 more" in note for note in notes)


def test_what_turns_is_determined(tmp_path):
    refused(planetary(held=False).write(tmp_path / "a.rexs"), "has 2 independent speeds, and gives 1")
    box = planetary()
    carrier = box.number("Carrier shaft")
    box.couple("coupling", "Lock", carrier, box.casing, u_coordinate_on_shaft_inner_side=("mm", 5.0))
    refused(box.write(tmp_path / "a.rexs"), "nothing can turn")
    refused(Gearbox().write(tmp_path / "a.rexs"), "no gear pair is joined to an external load")


def test_all_problems_at_once(tmp_path):
    box = two_stages().change("Pinion 1 [", number_of_teeth=None).change("Wheel 2 [", normal_module=None)
    assert len(refused(box.write(tmp_path / "gearbox.rexs")).splitlines()) == 2


@pytest.mark.parametrize("character", ["\x1b[2J", "\x9b31m", "\x85", "\u202e", "\u2028", "\ud800", "\n"])
def test_names_that_act_on_a_terminal(tmp_path, character):
    """Whatever a case refuses in a name is escaped, in the train and in the case that the command prints."""
    box = two_stages()
    path = tmp_path / "a.rexsj"
    path.write_text(json.dumps(json.loads(box.json(), object_hook=lambda row: (
        {**row, "name": f"1{character}x {row['name']}"} if row.get("name") else row))))
    text = gt.read_rexs(path).namelist() + case_of_rexs(path)
    assert all(line.isprintable() for line in text.splitlines()), text
    assert plain(" ".join(f"1{character}x".split())) in gt.read_rexs(path).bodies[0].name


# Files that are no gearboxes.

@pytest.mark.parametrize(("text", "words"), [
    ("", ["the file is empty"]),
    ("  \n", ["the file is empty"]),
    ("&train /", [":1: error: no well-formed XML"]),
    ("<html></html>", ["begins with <html>, a REXS file with <model>"]),
    ('<model version="1.4"></model>', ["no components: is this a REXS file?"]),
    ('<model version="3.0"></model>', ["version '3.0': must be 1.0 to 2.0"]),
    ('<model version="1.4"><components><component id="x" type="shaft"/></components></model>',
     ["id = 'x': must be a whole number"]),
    ('<model version="1.4">\n<components><component id="1" type="shaft"/>\n<component id="1" type="shaft"/></components></model>',
     [":3: error: component 1 stands in the file twice"]),
    ('<model version="1.4"><relations><relation id="1" type="assembly"><ref id="7" role="part"/></relation></relations>'
     '<components><component id="1" type="shaft"/></components></model>', ["relation assembly: part 7 is no component"]),
    ('<model version="1.4"><relations><relation id="1" type="assembly"><ref id="1" role="part"/></relation></relations>'
     '<components><component id="1" type="shaft"/></components></model>', ["relation assembly: has no assembly"]),
    ('<model version="1.4"><components><component id="1" type="shaft"><attribute id="support_vector" unit="mm">'
     '<array code="float64">!!!</array></attribute></component></components></model>', ["cannot be decoded"]),
    ('<model version="1.4"><components><component id="1" type="shaft"><attribute id="support_vector" unit="mm"><array code="text">'
     "AA==</array></attribute></component></components></model>", ["must be int32, float32 or float64"]),
    ('<?xml version="1.0"?><!DOCTYPE model [<!ENTITY a SYSTEM "file:///etc/passwd">]><model version="1.4">&a;</model>',
     ["a document type", "is not read"]),
    ('<?xml version="1.0"?><!DOCTYPE model [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><model version="1.4">&b;</model>',
     ["document type"]),
    ("<model version='1.4'>" + "<a>" * 70, ["elements within elements, 64 deep"]),
    ('<?xml version="1.0" encoding="nonsense"?><model version="1.4"/>', ["unknown encoding: nonsense"]),
    ("{", ["no well-formed JSON"]), ("[]", ["begins with no"]), ('{"model": 3}', ["begins with no"]),
    ('{"model": {"version": "1.4", "components": 3}}', ['"components": must be a list of objects']),
    ('{"model": {"version": "1.4", "components": [3]}}', ['"components": must be a list of objects']),
    ('{"model": ' * 100000, ["no well-formed JSON"]),
    ('{"model": {"version": "1.4", "components": [{"id": ' + "9" * 5000 + "}]}}", ["error: "]),
    ('{"model": {"version": "1.4", "components": [{"id": true}]}}', ["id = True: must be a whole number"]),
])
def test_a_file_that_is_no_gearbox(tmp_path, text, words):
    (tmp_path / "a.rexs").write_text(text)
    refused(tmp_path / "a.rexs", *words)


def test_text_of_no_encoding(tmp_path):
    (tmp_path / "a.rexs").write_bytes(b'<model version="1.4">\xff\xfe</model>')
    refused(tmp_path / "a.rexs", "no well-formed XML")
    (tmp_path / "a.rexsj").write_bytes(b'{"model": "\xff\xfe"}')
    refused(tmp_path / "a.rexsj", "no readable text")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_marks_of_encodings(tmp_path, encoding):
    box = one_stage()
    (tmp_path / "a.rexs").write_text(box.xml().replace("UTF-8", encoding.removesuffix("-sig").upper()), encoding=encoding)
    (tmp_path / "a.rexsj").write_text(box.json(), encoding=encoding)
    assert gt.read_rexs(tmp_path / "a.rexs").namelist() == gt.read_rexs(tmp_path / "a.rexsj").namelist()


def test_archives(tmp_path, monkeypatch):
    path = tmp_path / "a.rexsz"

    def write(*members, **more):
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, **more) as archive:
            for name, text in members:
                archive.writestr(name, text)

    text = one_stage().xml()
    write(("gde.txt", ""), ("__MACOSX/._a.rexs", "no"), ("model/a.rexs", text))
    assert len(gt.read_rexs(path).bodies) == 4
    write(("a.rexs", text.replace("<relations>", "<relations", 1)))
    refused(path, "a.rexsz/a.rexs:4: error: no well-formed XML")
    write(("a.txt", text))
    refused(path, "must have one file .rexs or .rexsj; it has none")
    write(("a.rexs", text), ("b.rexsj", text))
    refused(path, "it has 'a.rexs', 'b.rexsj'")
    write(*((f"{number}.txt", "") for number in range(1001)))
    refused(path, "an archive of 1001 files")
    path.write_bytes(b"PK\x03\x04 and no more")
    refused(path, "cannot be unpacked")
    monkeypatch.setattr(rexs_file, "LARGEST", 10**6)
    write(("a.rexs", " " * (10**6 + 1)))
    assert path.stat().st_size < 10**4
    refused(path, "unpacks to more than")
    (tmp_path / "a.rexs").write_text(" " * (10**6 + 1))
    refused(tmp_path / "a.rexs", "which no gearbox needs")


# Damage by chance: a train, or InputError.

BOXES = {"two stages": two_stages, "planetary": planetary}


@pytest.mark.parametrize("name", BOXES)
def test_damaged_bytes(tmp_path, times, name):
    draw = random.Random(40)
    box, seen = BOXES[name](), set()
    files = {".rexs": box.xml().encode(), ".rexsj": box.json().encode()}
    for _ in range(times(400)):
        ending = draw.choice(sorted(files))
        data = bytearray(files[ending])
        for _ in range(draw.choice((1, 1, 3, 30))):
            place = draw.randrange(len(data))
            kind = draw.randrange(4)
            if kind == 0:
                data[place] = draw.randrange(256)
            elif kind == 1:
                del data[place:place + draw.choice((1, 5, 200))]
            elif kind == 2:
                data[place:place] = data[draw.randrange(len(data)):][:draw.choice((1, 5, 200))]
            else:
                data[place] = draw.choice(b"0123456789.-e")
        (tmp_path / ("a" + ending)).write_bytes(bytes(data))
        seen.add(outcome(tmp_path / ("a" + ending)))
    assert seen == {"read", "refused"}


@pytest.mark.parametrize("name", BOXES)
def test_damaged_values(tmp_path, times, name):
    """Any number, text, reference and type of another component in place of any."""
    draw = random.Random(41)
    odd = [0, -1, 1e-30, 1e30, -1e30, 1e400, "", "x", None, True, [], [1.0], [0.0, 0.0, 0.0], ["a", "b", "c"],
           {"code": "float64"}, "1e999"]
    text = BOXES[name]().json()
    seen = set()
    for _ in range(times(60)):
        model = json.loads(text)["model"]
        for _ in range(draw.choice((1, 1, 2, 5))):
            component = draw.choice(model["components"])
            relation = draw.choice(model["relations"])
            choice = draw.randrange(6)
            if choice <= 2 and component["attributes"]:
                attribute = draw.choice(component["attributes"])
                key = next(key for key in attribute if key not in ("id", "unit"))
                attribute[key] = draw.choice(odd)
            elif choice == 3:
                component["type"] = draw.choice(model["components"])["type"]
            elif choice == 4:
                draw.choice(relation["refs"])["id"] = draw.choice(model["components"])["id"]
            else:
                model["relations"].remove(relation)
        (tmp_path / "a.rexsj").write_text(json.dumps({"model": model}))
        seen.add(outcome(tmp_path / "a.rexsj"))
    assert "refused" in seen


def outcome(path):
    """Whether a file is read or refused; any other error is the test's."""
    try:
        gt.read_rexs(path)
    except gt.InputError as error:
        assert len(str(error)) > 20 and all(line.isprintable() for line in str(error).splitlines())
        return "refused"
    return "read"
