"""Measured pitch errors from tables, as measuring machines write them: what is read, and what is refused."""

import re
from math import cos, pi, radians

import numpy as np
import pytest
from conftest import run
from rexs_files import one_stage, planetary, said, scripts, two_stages

import geartrain as gt
from geartrain.files.rexs import case_of_rexs
from geartrain.files.rexs_command import main

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")

#: Of the helix angle of the first stage.
COSINE = cos(radians(15))


def test_pitch_errors_of_a_table(tmp_path):
    """The same train as with values worked out by hand: a helical gear, from the reference circle to the line of action."""
    file = two_stages().write(tmp_path / "gearbox.rexs")
    microns = np.round(5 * np.sin(2 * pi * np.arange(23) / 23) + 0.4 * np.cos(9 * np.arange(23)), 2)
    singles = np.round(np.diff(microns, prepend=microns[-1]), 2)
    cosine = COSINE / np.hypot(COSINE, np.tan(radians(20)))  # of the transverse pressure angle
    expected = gt.read_rexs(file).with_values({"mesh 1 driving_pitch_error": 1e-6 * cosine * microns})
    teeth = range(1, 24)
    tables = {
        "plain.txt": "\n".join(map(str, microns)),
        "numbered.csv": "# Pinion 1 [11]\ntooth,error [mm]\n" + "".join(f"{t},{x / 1000}\n" for t, x in zip(teeth, microns)),
        "machine.txt": "Protokoll;\nZähnezahl;23\nModul [mm];2,5\n\nZahn;f_p [\N{MICRO SIGN}m];F_p [\N{MICRO SIGN}m]\n" +
            "".join(f"{t};{x};{y}\n" for t, x, y in zip(teeth, singles, microns)).replace(".", ",") + "\nFp;12,5\nfp max;2,1\n",
        "module.txt": "# Modul mn = 2.500 [mm]\n# Breite [mm]: 42\nZahn;fp;Fp\n" +
            "".join(f"{t};{x};{y}\n" for t, x, y in zip(teeth, singles, microns)),
        "paged.txt": "".join(("Zahn fp/um Fp/um\n" if t in (1, 12) else "") + f"{t} {x} {y}\n"
                             for t, x, y in zip(teeth, singles, microns)),
        "quoted.csv": '"Tooth","fp","Fp"\n' +
            "".join(f'"{t}","{x}","{y}"\n' for t, x, y in zip(teeth, singles, microns)).replace(".", ","),
        "comma.csv": "tooth;F_p [\N{MICRO SIGN}m]\n" + "".join(f"{t};{x}\n" for t, x in zip(teeth, microns)).replace(".", ","),
    }
    for name, text in tables.items():
        encoding = {"machine.txt": "cp1252", "numbered.csv": "utf-16"}.get(name, "utf-8")
        (tmp_path / name).write_text(text, encoding=encoding)
        for gear in ("mesh 1 driving", "Pinion 1 [11]", "Pinion 1"):
            train = gt.read_rexs(file, pitch_errors={gear: tmp_path / name})
            # Seven digits are written.
            assert np.allclose(train.meshes[0].driving_pitch_error, expected.meshes[0].driving_pitch_error, rtol=0, atol=5e-13)
            assert not train.meshes[0].driven_pitch_error and not train.meshes[1].driving_pitch_error
            notes = [note for note in train.notes if name in note]
            count = {"plain.txt": 3, "numbered.csv": 2, "module.txt": 2, "quoted.csv": 2}.get(name, 1)
            assert len(notes) == count and f"times {cosine:.5f}" in notes[0]
    for heading in ("fp [um]\n", "# single pitch errors\ntooth\terror [um]\n"):
        rows = (f"{t}\t{x}\n" if "\t" in heading else f"{x}\n" for t, x in zip(teeth, singles))
        (tmp_path / "single.txt").write_text(heading + "".join(rows))
        train = gt.read_rexs(file, pitch_errors={"mesh 1 driving": tmp_path / "single.txt"})
        assert np.allclose(train.meshes[0].driving_pitch_error, 1e-6 * cosine * np.cumsum(singles), rtol=0, atol=5e-13)
        assert said(train.notes, "assumed", "single pitch errors, summed")
    flanks = "Tooth;fp left;Fp left;Fp pinion right\nNr.;mm;mm;mm\n" + "".join(
        f"{t};{y / 1000};{x / 1000};{-x / 1000}\n" for t, x, y in zip(teeth, microns, singles))
    (tmp_path / "flanks.csv").write_text(flanks.replace("-", "\N{MINUS SIGN}"), encoding="utf-8")
    for column, sign in (("Fp left", 1), ("Fp pinion", -1)):
        train = gt.read_rexs(file, pitch_errors={"mesh 1 driving": f"{tmp_path}/flanks.csv#{column}"})
        assert np.allclose(train.meshes[0].driving_pitch_error, sign * 1e-6 * cosine * microns, rtol=0, atol=5e-13)
    lines = list(zip(teeth, singles, microns, -microns))
    grouped = "Tooth;Left;;Right;\n;fp;Fp;fp;Fp\n" + "".join(f"{t};{x};{y};{x};{z}\n" for t, x, y, z in lines)
    printed = "          Linke Flanke          Rechte Flanke\nZahn-Nr.    fp    Fp     fp    Fp\n------------\n" + "".join(
        f"  {t:3d}   {x:8.2f} {y:8.2f}  {x:8.2f} {z:8.2f}\n" for t, x, y, z in lines)
    barred = "Tooth  fp left  Fp left | fp right  Fp right\n" + "".join(f"{t} {x} {y} | {x} {z}\n" for t, x, y, z in lines)
    marked = "| Tooth | Cumulative pitch error (left) |\n| ---: | ---: |\n" + "".join(f"| {t} | {y} |\n" for t, x, y, z in lines)
    asked = ((grouped, "#3"), (grouped, "#Left Fp"), (printed, "#Linke Flanke Fp"), (barred, "#Fp left"), (marked, ""))
    for text, column in asked:
        (tmp_path / "print.txt").write_text(text, encoding="utf-8")
        train = gt.read_rexs(file, pitch_errors={"mesh 1 driving": f"{tmp_path}/print.txt{column}"})
        assert np.allclose(train.meshes[0].driving_pitch_error, 1e-6 * cosine * microns, rtol=0, atol=5e-13), text
    for factor, told in ((1, False), (-1, True)):
        (tmp_path / "both.txt").write_text("tooth fp Fp\n" + "".join(f"{t} {factor * x} {y}\n" for t, x, y, _ in lines))
        notes = gt.read_rexs(file, pitch_errors={"mesh 1 driving": tmp_path / "both.txt"}).notes
        assert bool(said(notes, "assumed", "Fp holds, though the single errors beside it are not its differences")) == told
    (tmp_path / "wheel.txt").write_text("0.5\n" * 71, encoding="utf-8")
    train = gt.read_rexs(file, pitch_errors={"mesh 1 driving": tmp_path / "plain.txt", "Wheel 1 [14]": tmp_path / "wheel.txt"})
    assert train.meshes[0].driving_pitch_error and train.meshes[0].driven_pitch_error == pytest.approx([0.5e-6 * cosine] * 71)


@pytest.mark.full  # three commands, of which two start Python
def test_from_rexs_to_a_report_with_sidebands(executable, tmp_path):
    one_stage().write(tmp_path / "gearbox.rexs")
    np.savetxt(tmp_path / "pinion.txt", 20 * np.cos(2 * pi * 9 * np.arange(23) / 23))
    done = run("geartrain-rexs", "gearbox.rexs", "--pitch-errors", "Pinion [8]", "pinion.txt", cwd=tmp_path, env=scripts())
    assert (done.returncode, done.stderr) == (0, "")
    # A narrow range with a peak is as good a test as the range of the file.
    (tmp_path / "case.nml").write_text(done.stdout.replace("from = 300.0", "from = 1675.0").replace("to = 1800.0", "to = 1650.0"))
    assert run(executable, "case.nml", cwd=tmp_path).returncode == 0
    assert run("geartrain-report", "case.h5", "-o", "report.html", cwd=tmp_path, env=scripts()).returncode == 0
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Orders and sidebands" in report and "mesh 1 - 9 x Pinion [8]" in report
    cells = r"1 x mesh 1</td><td>Pinion \[8\]</td><td>N</td>(<td>[\d.e-]+</td>){7}"
    assert re.search(r"sidebands of.*-1.*\+1.*" + cells, report, re.DOTALL)
    # The case offers the other form in its own line.
    smooth = done.stdout.replace("pitch_error_form = 'steps'", "pitch_error_form = 'polynomial'")
    (tmp_path / "smooth.nml").write_text(smooth)
    assert smooth != done.stdout and run(executable, "--check", "smooth.nml", cwd=tmp_path).returncode == 0


@pytest.mark.parametrize(("gears", "asked"), [(("Pinion 1 [11]", "Wheel 1 [14]"), "response"), ((
    "Pinion 1 [11]", "Wheel 1 [14]", "Pinion 2 [17]", "Wheel 2 [20]"), "integration")])
def test_a_case_with_errors_asks_for_what_can_be_had(executable, tmp_path, gears, asked):
    """Errors of all gears repeat themselves too late for a response."""
    two_stages().write(tmp_path / "gearbox.rexs")
    tables = {}
    for gear, teeth in zip(gears, (23, 71, 19, 80), strict=False):
        np.savetxt(tmp_path / f"{teeth}.txt", 20 * np.cos(2 * pi * 3 * np.arange(teeth) / teeth))
        tables[gear] = tmp_path / f"{teeth}.txt"
    text = case_of_rexs(tmp_path / "gearbox.rexs", pitch_errors=tables)
    assert f"&{asked}" in text and text.count("from = 300.0") == 1
    (tmp_path / "case.nml").write_text(text)
    assert run(executable, "--check", "case.nml", cwd=tmp_path).returncode == 0


@pytest.mark.parametrize(("gear", "text", "words"), [
    ("mesh 1 driving", "0.5\n" * 22, [":22: error: has 22 pitch errors", "has 23 teeth"]),
    ("mesh 1 driving", "0.5\nhigh\n0.7\n", [":2: error: 'high': stands between lines of numbers"]),
    ("mesh 1 driving", "0.5\nnan\n", [":2: error: 'nan': must be a pitch error"]),
    ("mesh 1 driving", "1 0.5 7\n", [":1: error: '1 0.5 7': must be a pitch error", "a heading 'Fp' (cumul"]),
    ("mesh 1 driving", "1;0.5\n2;\n3;0.7\n", [":2: error: '2;': a number is missing"]),
    ("mesh 1 driving", "1;0.5;\n2;;\n", [":2: error: '2;;': a number is missing"]),
    ("mesh 1 driving", "1 0.5\n2\n", [":2: error: '2': has 1 numbers, and line 1 has 2"]),
    ("mesh 1 driving", "1;0.5\n2;n/a\n", [":2: error: '2;n/a': must be a pitch error"]),
    ("mesh 1 driving", "tooth;Fp left;Fp right\n1;1;1\n", [":1: error: 'Fp left' and 'Fp right': must be one column", "#Fp left"]),
    ("mesh 1 driving", "tooth;fp\n1;1\n2;2\n", ["single pitch errors sum to 3: must be 0 round the revolution"]),
    ("mesh 1 driving", "1 0.5\n3 0.5\n", [":2: error: tooth '3': must be 2"]),
    ("mesh 1 driving", "0 0.5\n2 0.5\n", [":1: error: tooth '0': must be 1"]),
    ("mesh 1 driving", "1,5\n0,25\n0,5", ["has 3 pitch errors"]),
    ("mesh 1 driving", "0.5\n1500\n", [":2: error: '1500' um: must be at most 1 mm; a heading"]),
    ("mesh 1 driving", "error [m]\n5\n", [":2: error: '5' m: must be at most 1 mm"]),
    ("mesh 1 driving", "0\n0.019\n-0.002\n", ["error: the errors differ by 0.021 um: must be at least 0.5 um; a heading"]),
    ("mesh 1 driving", "error [inch]\n5\n", [":1: error: unit 'inch': must be um, mm, nm or m"]),
    *(("mesh 1 driving", f"tooth;{heading}\n1;5\n", [f":1: error: unit {unit!r}"]) for heading, unit in (
        ("error in inch", "inch"), ("Fp (mils)", "mils"), ("Fp (0.0001 in)", "0.0001 in"), ("Fp [0.1 um]", "0.1 um"), ("Fp/3", "3"),
        ('Fp (")', '"'), ("Fp in Winkelsekunden", "Winkelsekunden"), ("Fp (urad)", "urad"))),
    *(("mesh 1 driving", f"tooth;{heading} [um]\n1;5\n", [f":1: error: heading '{heading} [um]': {word!r}: must say pitch errors"])
      for heading, word in (("Fpt", "Fpt"), ("FP", "FP"), ("Fpk", "Fpk"), ("Fr", "Fr"), ("fu", "fu"), ("Rundlauf", "Rundlauf"),
                            ("Total profile deviation", "profile"), ("Gesamtprofilabweichung", "Gesamtprofilabweichung"),
                            ("Einzelprofil", "Einzelprofil"))),
    ("mesh 1 driving", "Tooth No. fp [mm]\n1 5\n", [":1: error: 'Tooth No. fp [mm]': must have a heading for each of 2 columns"]),
    ("mesh 1 driving#Fr", "tooth;Fp;fp\n1;5;5\n", ["column 'Fr': must be the number of a column, 2 to 3, or the heading of one of "
                                                     "'Fp', 'fp'"]),
    ("mesh 1 driving", "tooth Fp Fp\n1 1 1\n", ["'Fp' and 'Fp': must be one column", "table.txt#2 names one"]),
    ("mesh 1 driving", "left\n1;1\nright\n1;1\n", [":3: error: 'right': stands between lines of numbers: must be one table"]),
    ("mesh 1 driving", "tooth;Abw. Fp\n1;1\n", ["'Abw.': must say pitch errors", "TABLE#HEADING takes a column by its heading"]),
    ("mesh 1 driving", "unit: mm\ntooth;Fp [um]\n1;1\n", [":1: error: unit 'mm': another line has 'um'"]),
    ("mesh 1 driving", "# [um]\n# [mm]\ntooth;Fp\n1;5\n", [":2: error: unit 'mm': another line has 'um'"]),
    ("mesh 1 driving", "# [0.1 um]\ntooth;Fp\n1;5\n", [":1: error: unit '0.1 um'"]),
    *(("mesh 1 driving", f"Report: all values in {unit}\ntooth;Fp\n1;5\n", [f":1: error: unit '{unit}'"])
      for unit in ("0.1 um", "1/10 um", "microinches")),
    ("mesh 1 driving", "\n# nothing\n", ["table.txt: error: has no numbers"]),
    ("mesh 1 driving", b"0.5\n\x81\n", [":2: error: no text in UTF-8, UTF-16 or Windows-1252"]),
    ("mesh 1 driving", b"0.5\n\0\n", [":2: error: no text in UTF-8, UTF-16 or Windows-1252"]),
    ("mesh 3 driving", "0.5\n", ["there is no such gear", "mesh 1 driving or driven (Pinion 1 [11], Wheel 1 [14])"]),
    ("Pinion", "0.5\n", ["there is no such gear (did you mean 'Pinion 1 [11]'?)"]),
])
def test_a_table_of_pitch_errors_that_cannot_be(tmp_path, gear, text, words):
    path = tmp_path / "table.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    file = two_stages().write(tmp_path / "gearbox.rexs")
    gear, _, column = gear.partition("#")
    path = f"{path}#{column}" if column else path
    with pytest.raises(gt.InputError) as caught:
        gt.read_rexs(file, pitch_errors={gear: path})
    assert [word for word in words if word not in str(caught.value)] == [], str(caught.value)


def test_gears_that_take_no_table(tmp_path, capsys):
    path = tmp_path / "table.txt"
    path.write_text("0.5\n" * 23)
    file = planetary().write(tmp_path / "planetary.rexs")
    with pytest.raises(gt.InputError, match="gears of planetary sets take none"):
        gt.read_rexs(file, pitch_errors={"Sun [11]": path})
    file = two_stages().write(tmp_path / "gearbox.rexs")
    with pytest.raises(gt.InputError, match="are given twice"):
        gt.read_rexs(file, pitch_errors={"mesh 1 driving": path, "Pinion 1 [11]": path})
    asked = ["--pitch-errors", "mesh 1 driving", str(path)]
    assert main([str(file), *asked, *asked]) == 2 and "is given twice" in capsys.readouterr().err
    assert main([str(file), "--pitch-errors", "mesh 1 driving", "none.txt"]) == 4
    assert "none.txt: cannot be read: No such file" in capsys.readouterr().err
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("#" * (5 << 20))
    assert main([str(file), *asked]) == 2 and "has more than 4 MB" in capsys.readouterr().err


def test_a_name_of_two_gears(tmp_path):
    """As files write it, without the number; the label with the number is still of one gear."""
    (tmp_path / "table.txt").write_text("0.5\n" * 23)
    file = two_stages().write(tmp_path / "gearbox.rexs")
    text = re.sub(r'name="(\w+ \d) \[\d+\]" type="cylindrical_gear"', r'name="\1" type="cylindrical_gear"', file.read_text())
    file.write_text(text)
    numbers = [gt.read_rexs(file, pitch_errors={gear: tmp_path / "table.txt"}).meshes[0].driving_pitch_error
               for gear in ("Pinion 1", "Pinion 1 [11]")]
    assert numbers[0] and numbers[0] == numbers[1]
    file.write_text(text.replace('name="Pinion 2"', 'name="Pinion 1"'))
    with pytest.raises(gt.InputError, match=r"2 gears have this name: say 'Pinion 1 \[11\]' or 'Pinion 1 \[\d+\]'"):
        gt.read_rexs(file, pitch_errors={"Pinion 1": tmp_path / "table.txt"})
    again = gt.read_rexs(file, pitch_errors={"Pinion 1 [11]": tmp_path / "table.txt"}).meshes[0].driving_pitch_error
    assert again == numbers[0]


def test_an_idler_has_two_flanks(tmp_path):
    """A gear in two meshes is named by its mesh."""
    (tmp_path / "table.txt").write_text("0.5\n")
    box = one_stage()
    third = box.gear(box.shaft("Loose", [(30.0, 0.0, 40.0)], at=(140.0, 244.5, 0.0)), "Third", 30, 2.5, 10.0, 20.0)
    box.stage("Stage 2", box.number("Wheel ["), third, 126.5)
    with pytest.raises(gt.InputError, match="in several meshes, with a flank for each: say mesh 1 driven or mesh 2 driving"):
        gt.read_rexs(box.write(tmp_path / "gearbox.rexs"), pitch_errors={"Wheel [11]": tmp_path / "table.txt"})
