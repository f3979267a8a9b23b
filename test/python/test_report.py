"""The report: the same words from the executable and from Python, and in them the numbers of the results file."""

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, paper_train, run

import geartrain as gt

PEAK = re.compile(r"Mesh (\d+)[^:]*: largest force (\S+) N(?: \(error [^)]*\))?, (\S+) times the mean, at (?:Lambda )?([\d.]+)")


def flat(text):
    return " ".join(text.split())


def section(text, name):
    """Lines of a section."""
    lines = text.splitlines()
    first = lines.index(name) + 1
    last = next((place for place in range(first, len(lines)) if not lines[place].startswith(" ")), len(lines))
    return lines[first:last]


def digits(value):
    """A number as it is printed."""
    return float(f"{value:.3e}")


@pytest.fixture(scope="module")
def told(executable, tmp_path_factory):
    """The report of figure 3 and its results."""
    folder = tmp_path_factory.mktemp("report")
    done = run(executable, ROOT / "namelists" / "fig03.nml", "--output", folder / "fig03.h5", cwd=folder)
    assert done.returncode == 0, done
    return done.stdout, gt.read_results(folder / "fig03.h5")


def test_executable_and_python_say_the_same(told):
    """But for the time of the run and the file, which results do not know."""
    printed, results = told
    lines = [line for line in printed.split("FILES\n")[0].splitlines() if not line.startswith("Time: ")]
    assert str(results).splitlines() == results.report().splitlines() == lines
    assert str(gt.read_case(ROOT / "namelists" / "fig03.nml").run()).splitlines() == lines
    written, following, more = section(printed, "FILES")
    assert written.startswith("  Written: ") and "geartrain-page" in following and "--verbose" in more


def test_a_branch_prints_its_part(told):
    printed, results = told
    own = str(results.response)
    assert own == results.response.report() and "Integration" not in own and len(own.splitlines()) <= 45
    for name in ("MODES", "RESONANCES"):
        assert section(own, name) == section(printed, name)
    assert repr(results.response) == "<Branch of 149 points: reached Lambda = 2.6>"


def test_a_sweep_prints_its_part(told):
    """The sentences and torques of the executable on time integration, and the forces as arrays."""
    printed, results = told
    sweep = results.integration
    own = str(sweep)
    assert own == sweep.report() and "Response" not in own
    sentence = re.compile(r"Time integration, motions.*?(?= The torque|$)")
    assert sentence.search(flat("\n".join(section(own, "RESULT")))).group() in flat(printed)
    assert "Integration: all 242 motions settled." in section(own, "QUALITY")[0]
    assert section(own, "MODES") == section(printed, "MODES")
    row = section(own, "SHAFTS")[2].split()
    assert float(row[3]) == digits(sweep.shaft_torque_minimum[:, 1].min())
    assert float(row[6]) == digits(sweep.shaft_torque_maximum[:, 1].max())
    assert sweep.mesh_force_maximum.shape == (242, 2) and repr(sweep).startswith("<Sweep of 242 motions")
    one = sweep[0].train.sweep(start=0.9, stop=0.9, points=1)
    assert "Time integration: Lambda 0.9, 1 motion" in str(one)
    assert str(gt.Sweep([])) == repr(gt.Sweep([]))


def test_sections_stand_in_their_order(told):
    printed, _ = told
    found = [line for line in printed.splitlines() if re.fullmatch("[A-Z-]+", line)]
    assert found == ["RESULT", "MODES", "RESONANCES", "SHAFTS", "QUALITY", "FILES"]
    assert printed.splitlines()[0] == results_title(printed) and max(map(len, printed.split("FILES")[0].splitlines())) < 110


def results_title(printed):
    assert printed.splitlines()[1] == "Load: input torque 150 N m; mean mesh forces 3000, 6000 N"
    return "Al-shyyab and Kahraman 2007, figure 3"


def test_forces_are_those_of_the_file(told):
    printed, results = told
    rows = PEAK.findall(flat(printed))
    assert len(rows) == 4
    for branch, own in ((results.response, rows[:2]), (results.integration, rows[2:])):
        if branch is results.response:
            force, factor, at = (
                values[branch.stable] for values in (branch.mesh_force_maximum, branch.dynamic_factor, branch.frequency)
            )
        else:
            force, factor = (
                np.array([getattr(motion, name) for motion in branch]) for name in ("mesh_force_maximum", "dynamic_factor")
            )
            at = np.array([motion.frequency for motion in branch])
        for mesh, largest, times, frequency in own:
            place = force[:, int(mesh) - 1].argmax()
            assert float(largest) == digits(force[place, int(mesh) - 1])
            assert float(times) == digits(factor[place, int(mesh) - 1])
            assert float(frequency) == pytest.approx(at[place], abs=6e-5)


def test_torques_are_those_of_the_file(told):
    printed, results = told
    branch = results.response
    low = [branch.others["shaft_torque_minimum"][branch.stable]]
    high = [branch.others["shaft_torque_maximum"][branch.stable]]
    low.append([motion.shaft_torque_minimum for motion in results.integration])
    high.append([motion.shaft_torque_maximum for motion in results.integration])
    rows = section(printed, "SHAFTS")[1:]
    assert len(rows) == 3
    for number, row in enumerate(rows):
        words = row.split()
        assert words[:2] == ["shaft", str(number + 1)]
        assert float(words[3]) == digits(np.concatenate(low)[:, number].min())
        assert float(words[6]) == digits(np.concatenate(high)[:, number].max())


def test_modes_are_those_of_the_file(told):
    printed, results = told
    hertz = results.response.train.characteristic_frequency / (2 * np.pi)
    for number, row in enumerate(section(printed, "MODES")[1:]):
        values = [float(word) for word in row.split()[:4]]
        natural = results.modes.natural_frequency[number]
        assert values == [number + 1, digits(natural), digits(natural * hertz), digits(100 * results.modes.damping_ratio[number])]


def test_resonances_are_peaks_with_their_forces(told):
    """Each at a peak of a mesh, with the force amplitude of a point of the file; the orders are those that make the peaks."""
    printed, results = told
    branch = results.response
    mean = branch.mesh_force_maximum / branch.dynamic_factor
    amplitudes = [{digits(value) for value in column} for column in (branch.mesh_force_maximum - mean).T]
    peaks = {round(peak.frequency, 4) for peak in branch.peaks()}
    rows = [
        re.match(r" +([\d.]+) +(\d+) +[\d.]+  (\d(?: \(.*?\))?|-) +([\d.]+) +([\d.]+)  (.*)", row)
        for row in section(printed, "RESONANCES")[1:]
    ]
    rows = [row.groups() for row in rows if row]
    assert len(rows) == 6
    for at, _, _, first, second, _ in rows:
        assert float(at) in peaks and float(first) in amplitudes[0] and float(second) in amplitudes[1]
    found = {at: (order, mode, source) for at, order, mode, _, _, source in rows}
    assert found["0.7307"] == ("1", "1 (-24 %)", "meshes 1, 2")
    assert found["0.9073"] == ("2", "2 (-3 %)", "2 x meshes 1, 2 (indirectly)")
    assert found["1.5505"] == ("1", "2 (-17 %)", "meshes 1, 2")


def test_quality_counts_what_the_file_marks(told):
    printed, results = told
    branch = results.response
    words = flat("\n".join(section(printed, "QUALITY")))
    bad = branch.error_estimate > 1e-3
    worst = branch.error_estimate.argmax()
    assert (
        f"{bad.sum()} of {len(branch)} motions are less accurate than 0.001 (estimate; worst {branch.error_estimate.max():.4g} "
        f"at Lambda {branch.frequency[worst]:.4f}), torques of {(branch.reading_error_estimate > 0.01).sum()} than 0.01 "
        f"(worst {branch.reading_error_estimate.max():.4g}): 6 harmonics are too few, use harmonics = 0"
    ) in words
    assert f"the stability of {branch.undecided.sum()} motions is undecided" in words
    assert f"all {len(results.integration)} motions settled" in words


def test_jumps_and_bands_are_sentences(told):
    printed, results = told
    words = flat(printed)
    assert "speed up: at Lambda 0.7923 jump up, mesh 2 from 0.4904 to 0.9881" in words
    assert "speed up: at Lambda 1.7492 vibration switches to half the mesh frequency" in words
    assert "At Lambda 1.7492 to 2.0439 no motion of period 1 is stable" in words
    shown = len(re.findall(r"speed (?:up|down): at", words))
    assert f"and {len(results.response.jumps) - shown} more with smaller amplitudes (2 undecided)" in words
    everything = results.report(verbose=True)
    assert len(re.findall(r"speed (?:up|down): at", flat(everything))) == len(results.response.jumps)
    assert len(re.findall(r"^ +mesh \d +[\d.]+ +[\d.]+ +[\d.]+ +[\d.]+  (?:un|st)", everything, re.MULTILINE)) == len(
        results.response.peaks()
    )


@pytest.mark.parametrize("harmonics", [4, 6])
def test_errors_of_the_largest_forces_hold(harmonics):
    """Against the refined branch, whose motions are exact; over eight trains the error is up to 1.8 times the estimate."""
    asked = {"start": 0.85, "stop": 1.4, "harmonics": harmonics}
    branch, refined = (paper_train().response(**asked, refine=refine) for refine in (False, True))
    found = re.findall(r"Mesh (\d)[^:]*: largest force \S+ N \(error (?:below )?(\S+) %", flat(str(branch)))
    assert [int(mesh) for mesh, _ in found] == [1, 2] and len(branch) == len(refined)
    for mesh, percent in found:
        force = branch.mesh_force_maximum[:, int(mesh) - 1]
        at = np.where(branch.stable, force, 0).argmax()
        exact = refined.mesh_force_maximum[at, int(mesh) - 1]
        assert refined.correction[at] >= 0
        assert abs(force[at] / exact - 1) < 2 * float(percent) / 100
    assert "(error" not in str(refined)


def test_a_force_that_a_sweep_does_not_reach_says_so():
    """Mesh 1 of figure 3 at Lambda 1.59, and mesh 2 at the fold of 0.732: by sweeps in time."""
    train = paper_train()
    words = flat(str(train.response(start=0.5, stop=1.8)))
    assert re.search(r"Mesh 1: largest force 883\d N [^;]* at Lambda 1\.59\d+ \(not reached by a rising sweep\);", words)
    up, down = (train.sweep(start=1.5, stop=1.7, points=21, direction=way) for way in ("up", "down"))
    largest = [max(motion.mesh_force_maximum[0] for motion in sweep if motion.frequency < 1.62) for sweep in (up, down)]
    assert largest[0] < 5000 and largest[1] > 8800
    words = flat(str(train.response(start=0.5, stop=0.8)))
    assert re.search(r"Mesh 2: largest force 388\d+ N [^;]* at Lambda 0\.7320 \(not reached by a falling sweep\);", words)
    falling = train.sweep(start=0.5, stop=0.9, points=41, direction="down")
    assert max(motion.mesh_force_maximum[1] for motion in falling) < 31000
    # With one harmonic the fold has an error of 0.34, and may not exist.
    coarse = flat(str(train.response(start=0.5, stop=0.8, harmonics=1)))
    assert "at Lambda 0.7073" in coarse and "not reached" not in coarse
    # A linear train has one motion at each speed.
    assert "not reached" not in str(paper_train(half_backlash=0.0).response(start=0.5, stop=1.8))


def test_the_report_of_a_branch_has_its_further_branches_beside_it():
    """And not in place of it: the executable's report of the same case."""
    branch = paper_train().response(start=1.6, stop=2.1, harmonics=6, period_doublings=1)
    assert len(branch.branches) > 0
    words = flat(str(branch))
    assert "Response: Lambda 1.6 to 2.1" in words and "Response, stable motions: Mesh 1: largest force" in words
    assert "Branch 1, period 2: period doubling of the response" in words and "RESONANCES" in words


@pytest.mark.parametrize("torque", [150.0, -150.0])
def test_the_load_may_be_on_either_flank(torque):
    """A train with symmetric teeth is its own mirror image: the same ranges, told of the other flanks."""
    branch = paper_train(input_torque=torque).response(start=0.5, stop=0.8)
    words = flat(str(branch))
    loaded, other = ("drive", "coast") if torque > 0 else ("coast", "drive")
    assert f"its {other} flanks hit at Lambda 0.5656 to 0.7320" in words and f"its {loaded} flanks" not in words
    assert ("on the coast flanks of all meshes" in words) == (torque < 0)
    mesh, force, factor, _ = PEAK.findall(words)[1]
    assert (mesh, float(force), float(factor)) == ("2", 38810.0, 6.468)
    row = next(row for row in section(str(branch), "SHAFTS") if row.startswith("  shaft 2")).split()
    assert float(row[2]) == pytest.approx(2 * torque) and float(row[3]) * float(row[6]) < 0


def test_a_drawing_has_its_units(tmp_path):
    """rpm, um and the true root mean square; nothing of Lambda, nor of the rms of the paper."""
    text = (ROOT / "namelists" / "reducer.nml").read_text().split("&modes")[0]
    (tmp_path / "case.nml").write_text(text + "&response from = 1660.0, to = 1680.0, harmonics = 0, tolerance = 1e-2 /\n")
    branch = gt.read_case(tmp_path / "case.nml").run().response
    words = str(branch)
    assert "Lambda" not in words and "paper" not in words and "true rms [um]" in words
    jump = max(branch.jumps, key=lambda jump: abs(jump.after - jump.before).max())
    mesh = abs(jump.after - jump.before).argmax()
    before, after = (f"{value[mesh] / np.sqrt(2):.4g}" for value in (jump.before, jump.after))
    assert f"mesh {mesh + 1} from {before} to {after}" in flat(words)
    # The first mesh at 23 per turn of the motor and the third mode.
    assert re.search(r"^ +16\d\d\.\d +23 +6\d\d\.?\d* +3 ", words, re.MULTILINE)


def test_twists_of_couplings_have_their_unit():
    """A twist of 1 mrad where a mesh has 1 um; largest force and torque; the names of what is told."""
    shafts = gt.Train(
        bodies=[gt.Body(name="motor", inertia=2e-3, torque=20.0, revolution_torque_cos=[0.0, 12.0]),
                gt.Body(name="pinion", inertia=2e-3), gt.Body(name="wheel", inertia=0.03, balances=True)],
        couplings=[gt.Coupling(between=["motor", "pinion"], stiffness=4e4, half_play=4e-3, damping_ratio=0.02)],
        meshes=[gt.Mesh(between=["pinion", "wheel"], teeth=[19, 61], normal_module=2.5e-3, helix_angle=25.0, face_width=0.025,
                        backlash=80e-6, damping_ratio=0.05, stiffness_harmonics=1)])
    branch = shafts.response(start=18500.0, stop=19500.0, unit="rpm", harmonics=0)
    assert len(branch.jumps) > 0
    words = str(branch)
    assert "Jumps (true rms [um, mrad], mesh with the largest change)" in flat(words)
    assert "of mesh 1 and coupling 1 is at the end of the range" in flat(words)
    twist = shafts.integrate(19500.0)
    peak = branch.peaks()[-1]
    ends = str(branch.peaks())
    assert peak.mesh == 1 and "rms of the paper [um, mrad]" in ends and "largest force [N, of couplings N m]" in ends
    assert "coupling 1" in ends and ", coupling 1" in str(list(branch.jumps.to_dataframe().columns))
    # The largest twist of a spring with a play is the play and the torque over the stiffness.
    rad = 1e-3 * twist.maximum[1]
    assert rad == pytest.approx(4e-3 + twist.coupling_torque_maximum[0] / 4e4, rel=1e-2)


def test_a_transmission_error_without_phase_is_told(told):
    """Amplitudes of error_cos alone say nothing of the phase; a sine, or a stiffness that does not vary, settles it."""
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    told_of = "The transmission error of {} has no phase against the stiffness"
    first, second = train.meshes
    for meshes, words in (
        ((first, second), "meshes 1, 2"),
        ((first, replace(second, error_sin=[1e-7])), "mesh 1"),
        ((replace(first, error_cos=None), second), "mesh 2"),
        ((replace(first, error_cos=None), replace(second, stiffness_cos=[0.0])), ""),
    ):
        changed = replace(train, meshes=meshes)
        asked = {"start": 1500, "stop": 1500, "unit": "rpm", "points": 1}
        report = flat(str(changed.sweep(**asked))) if words == "meshes 1, 2" else ""
        explained = str(changed.explain())
        assert explained.count("its phase against the stiffness is open") == {"": 0, "meshes 1, 2": 2}.get(words, 1)
        assert not report or told_of.format(words) in report, report
    assert "phase against" not in told[0]


def test_a_number_in_another_unit_is_in_the_report():
    """A shaft 32 m thick: the warning stands in the report, which outlives the terminal; the orders are those of the motor."""
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    shaft = replace(train.shafts[2], diameter=[32.0])
    with pytest.warns(gt.DrawingWarning):
        slip = replace(train, shafts=[*train.shafts[:2], shaft])
    stiff = slip.response(start=1500, stop=1501, unit="rpm", harmonics=0, tolerance=1e-1, stability=False)
    quality = flat("\n".join(section(str(stiff), "QUALITY")))
    assert "Warning: &shaft 3: diameter = 32.0: the unit is the metre (30 mm are 0.03)" in quality
    branch = train.response(start=1650, stop=1690, unit="rpm", harmonics=0, tolerance=1e-2)
    assert "Warning" not in str(branch) and "order: per revolution of motor" in flat(str(branch))


def test_one_of_a_kind_is_singular(told):
    printed, results = told
    train = results.response.train
    single = replace(train, shafts=train.shafts[:2], meshes=train.meshes[:1])
    texts = [printed, str(single.response(start=0.9, stop=0.9001)), results.report(verbose=True)]
    for text in texts:
        assert not re.search(r"\b1 (motions|points|meshes|shafts|ranges|harmonics|periods|modes)\b", text), text


def test_a_killed_run_says_how_to_go_on(executable, tmp_path):
    """--resume, --force or another file; --force removes what is left of a run, but nothing else."""
    case = tmp_path / "case.nml"
    case.write_text(paper_train().namelist(response={"start": 0.8, "stop": 0.9}))
    assert run(executable, case, cwd=tmp_path).returncode == 0
    (tmp_path / "case.h5").rename(tmp_path / "case.h5.partial")
    done = run(executable, case, cwd=tmp_path)
    assert done.returncode == 2 and all(word in done.stderr for word in ("--resume", "--force", "--output"))
    assert run(executable, case, "--force", "--resume", cwd=tmp_path).returncode == 2
    assert run(executable, case, "--force", cwd=tmp_path).returncode == 0
    assert not (tmp_path / "case.h5.partial").exists()
    (tmp_path / "case.h5.partial").write_text("precious")
    assert run(executable, case, "--force", cwd=tmp_path).returncode == 4
    assert (tmp_path / "case.h5.partial").read_text() == "precious"


def test_tables_are_dataframes():
    """Numbers of the tables are those of the branch, a column for each mesh; text would hide digits."""
    branch = paper_train().response(start=0.2, stop=2.6, harmonics=6)
    points = branch.to_dataframe()
    assert len(points) == len(branch) and (points["rms, mesh 2"].values == branch.rms[:, 1]).all()
    assert (points["stable"].values == branch.stable).all()
    for rows in (branch.peaks(1), branch.jumps, branch.special_points):
        frame = rows.to_dataframe()
        assert len(frame) == len(rows) > 0
        text = str(rows).splitlines()[1].split()
        assert f"{frame.select_dtypes('number').iloc[0, 0]:.6g}" in text


def test_forces_and_torques_where_stability_is_lost():
    """Between the last stable point and the period doubling they grow: the report has them there, as the motion there has them."""
    train = gt.read_case(ROOT / "namelists" / "fig03.nml").train
    branch = train.response(start=2.03, stop=2.3, harmonics=8)
    [change] = [special for special in branch.special_points if special.kind == "period doubling"]
    [edge] = branch.at(change.frequency)
    stable = branch.shaft_torque_maximum[branch.stable, 1], branch.mesh_force_maximum[branch.stable, 0]
    assert edge.shaft_torque_maximum[1] > stable[0].max() and edge.mesh_force_maximum[0] > 1.003 * stable[1].max()
    shafts = section(branch.report(), "SHAFTS")
    assert shafts[2].count("*") == 2 and "*" not in shafts[1] + shafts[3]
    assert "Where stability is lost, interpolated between two motions" in flat("\n".join(shafts))
    low, high = re.findall(r"([\d.]+)\* Lambda 2\.0439", shafts[2])
    np.testing.assert_allclose([float(low), float(high)], [edge.shaft_torque_minimum[1], edge.shaft_torque_maximum[1]], rtol=5e-4)
    [force] = re.findall(r"\(up to (\d+) N where stability is lost, at Lambda 2\.0439\)", flat(branch.report()))
    np.testing.assert_allclose(float(force), edge.mesh_force_maximum[0], rtol=5e-4)
    beyond = train.response(start=1.7, stop=1.8, harmonics=8).report()
    assert "*" not in "".join(section(beyond, "SHAFTS")) and "where stability is lost" not in flat(beyond)
