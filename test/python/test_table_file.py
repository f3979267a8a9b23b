"""Trains from tables: CSV and spreadsheets."""

import random
import re
import zipfile

import numpy as np
import pytest
from conftest import ROOT, reducer

import geartrain as gt

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")

REDUCER = """\
part,title,speed_of
train,two-stage reducer,motor

part,name,inertia [kg m^2],torque,balances
# what turns
body,motor,0.02,90,
body,pinion 1,,,
body,wheel 1,,,
body,pinion 2,,,
body,wheel 2,,,
body,load,1.5,,yes
part,between,diameter [mm],length [mm],damping_ratio
shaft,motor - pinion 1,30,150,0.01
shaft,wheel 1 - pinion 2,40,120,0.01
shaft,wheel 2 - load,60,200,0.01
part,between 1,between 2,teeth 1,teeth 2,normal_module [mm],face_width [mm],helix_angle,backlash [um],damping_ratio,error_cos,\
stiffness_harmonics
mesh,pinion 1,wheel 1,23,71,2.5,40,15,60,0.05,3e-6,3
mesh,pinion 2,wheel 2,19,80,4,70,15,60,0.05,3e-6,3
"""


def test_the_reducer(tmp_path):
    (tmp_path / "a.csv").write_text(REDUCER)
    read, typed = gt.read_table(tmp_path / "a.csv"), reducer()
    # Millimetres and micrometres are rounded once more.
    assert np.allclose(read.natural_frequencies(), typed.natural_frequencies(), rtol=1e-14)
    assert read.meshes[0].teeth == (23.0, 71.0) and read.shaft_labels == typed.shaft_labels and read.title == typed.title


@pytest.mark.parametrize(("delimiter", "comma"), [(";", ","), ("\t", ".")])
def test_other_tables(tmp_path, delimiter, comma):
    """Semicolons with decimal commas, tabs, a mark of the encoding, ends of lines of other systems."""
    text = REDUCER.replace(",", delimiter).replace(".", comma).replace("\n", "\r\n")
    (tmp_path / "a.csv").write_text("\ufeff" + text, encoding="utf-8", newline="")
    (tmp_path / "b.csv").write_text(REDUCER)
    assert gt.read_table(tmp_path / "a.csv").namelist() == gt.read_table(tmp_path / "b.csv").namelist()


def test_a_point_beside_decimal_commas(tmp_path):
    text = REDUCER.replace(",", ";").replace(".", ",")
    number = re.search(r";(\d+),\d+;", text)
    assert number
    thousands = text[:number.start() + 1] + "1.500" + text[number.end() - 1:]
    (tmp_path / "a.csv").write_text(thousands)
    with pytest.raises(gt.InputError, match="must be 1500 or 1,500: beside decimal commas a point may separate thousands"):
        gt.read_table(tmp_path / "a.csv")


@pytest.mark.parametrize(("own", "other"), [("kg m^2", "kgm\N{SUPERSCRIPT TWO}"), ("um", "\N{MICRO SIGN}m")])
def test_units_as_they_are_written(tmp_path, own, other):
    (tmp_path / "a.csv").write_text(REDUCER)
    text = REDUCER.replace(f"[{own}]", f"[{other}]")
    assert text != REDUCER
    (tmp_path / "b.csv").write_text(text, encoding="utf-8")
    assert gt.read_table(tmp_path / "a.csv").namelist() == gt.read_table(tmp_path / "b.csv").namelist()


def test_a_spreadsheet(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for number, block in enumerate(re.split(r"(?m)^(?=part)", REDUCER)[1:]):
        sheet = book.create_sheet(f"sheet {number}")
        for row in block.splitlines():
            sheet.append([float(cell) if re.fullmatch(r"[\d.e+-]+", cell) else cell or None for cell in row.split(",")])
    book.save(tmp_path / "a.xlsx")
    (tmp_path / "b.csv").write_text(REDUCER)
    assert gt.read_table(tmp_path / "a.xlsx").namelist() == gt.read_table(tmp_path / "b.csv").namelist()


def test_the_table_of_the_page(tmp_path):
    """The example of docs/python.md, with spaces after the commas."""
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    (tmp_path / "a.csv").write_text(re.search(r"```\n(part, .*?)```", page, re.DOTALL)[1])
    train = gt.read_table(tmp_path / "a.csv")
    assert train.body_labels == ("motor", "pinion", "wheel") and train.meshes[0].normal_module == 2.5e-3


@pytest.mark.parametrize(("old", "new", "words"), [
    ("body,motor", "boddy,motor", [":6: error: 'boddy': must be one of", "did you mean 'body'?"]),
    ("torque,balances", "torqe,balances", [":6: error: column 4: 'torqe' is no variable of &body", "did you mean 'torque'?"]),
    ("0.02,90", "0.02,much", [":6: error: column 4: torque = 'much': must be a number"]),
    ("1.5,,yes", "1.5,,perhaps", [":11: error: column 5: balances = 'perhaps': must be yes or no"]),
    ("normal_module [mm]", "normal_module [inch]", [":17: error: column 6: normal_module [inch]: must be in m, mm, um, cm"]),
    ("teeth 2", "teeth 3", ["teeth: has 1, 3: must begin with 1"]),
    ("0.02,90", "0.02 3,90", ["inertia = '0.02 3': must be one number"]),
    ("0.02,90", "nan,90", ["must be a number"]),
    ("0.02,90", "-0.02,90", [":6: error: &body 1: inertia = -0.02: must be >= 0"]),
    ("body,load", "body,loads", ["error: &shaft ", "'load': is the name of no &body", "did you mean 'loads'?"]),
    ("body,load,1.5,,yes", "body,load,1.5,,yes,more", ["column 6: '' is no variable of &body: the column has no heading"]),
    ("part,title,speed_of\n", "", [":1: error: begins with 'train': the first row must have headings"]),
    ("body,load", "body,motor", ["motor"]),
    ("body,motor", '"body,motor', ["error: "]),
])
def test_words_of_tables(tmp_path, old, new, words):
    assert old in REDUCER
    (tmp_path / "a.csv").write_text(REDUCER.replace(old, new, 1))
    with pytest.raises(gt.InputError) as caught:
        gt.read_table(tmp_path / "a.csv")
    assert [word for word in words if word not in str(caught.value)] == [], str(caught.value)


def test_what_is_no_table(tmp_path):
    path = tmp_path / "a.csv"
    for data, words in ((b"", "no row below a heading 'part'"), (b"part,name\n", "no row below"),
                        (b"\xff\xfe\n", "no text in UTF-8"), (b"PK\x03\x04 no archive", "is no spreadsheet"),
                        (b"part\n" + b"body\n" * 20001, "more than 20000 rows"),
                        (b"x" * (16 * 2**20 + 1), "more than 16 MB")):
        path.write_bytes(data)
        with pytest.raises(gt.InputError, match=words):
            gt.read_table(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/workbook.xml", " " * (17 * 2**20))
    with pytest.raises(gt.InputError, match="unpacks to more than"):
        gt.read_table(path)


def test_damaged_tables(tmp_path, times):
    draw, seen = random.Random(43), set()
    for _ in range(times(300)):
        data = bytearray(REDUCER.encode())
        for _ in range(draw.choice((1, 2, 10))):
            place = draw.randrange(len(data))
            if draw.random() < 0.5:
                data[place] = draw.randrange(256)
            else:
                del data[place:place + draw.choice((1, 4, 40))]
        (tmp_path / "a.csv").write_bytes(bytes(data))
        try:
            gt.read_table(tmp_path / "a.csv")
            seen.add("read")
        except gt.InputError:
            seen.add("refused")
    assert seen == {"read", "refused"}
