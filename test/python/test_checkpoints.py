"""Damaged checkpoints of the same case: each is refused and kept, before anything is computed with it."""

import random
import subprocess
import time

import h5py
import pytest
from conftest import assert_equal_files, run, write_case

import geartrain as gt

pytestmark = pytest.mark.full

#: What a run was killed at, each long enough for a checkpoint of it.
CASES = {
    "response": "&response from = 0.2, to = 2.6, step = 0.0003, max_points = 100000 /\n",
    "tolerance": "&response from = 0.2, to = 2.6, harmonics = 0, tolerance = 1e-7, step = 0.003, max_points = 100000 /\n",
    "doublings": "&response from = 1.6, to = 4.2, period_doublings = 2, step = 0.0005, max_points = 100000 /\n",
    "refinement": "&response from = 0.2, to = 2.6, step = 0.01, refine = .true. /\n",
    "integration": "&integration from = 0.2, to = 2.6, points = 250, direction = 'both' /\n",
    "attractors": "&attractors frequency = 0.6, starts = 300 /\n",
    "map": (
        "&stability_map from = 0.4, to = 1.6, points = 40, parameter_from = 0.01, parameter_to = 0.1,\n"
        "   parameter_points = 400 /\n"
    ),
    "run_up": "&run_up from = 0.2, to = 2.6, duration = 12.0, samples = 1 /\n",
}


def stop_at_checkpoint(executable, case, output, kind):
    """Kills a run once its checkpoint holds something of this kind."""
    partial = output.with_name(output.name + ".partial")
    work = subprocess.Popen([executable, case, "--output", output], stdout=subprocess.DEVNULL)
    try:
        while True:
            assert work.poll() is None, f"{kind}: too short for a checkpoint"
            time.sleep(0.01)
            if partial.exists():
                with h5py.File(partial) as file:
                    if holds(file, kind):
                        break
    finally:
        work.kill()
        work.wait()
    return partial


def holds(file, kind):
    if kind == "doublings":
        return "branch_1" in file and len(file["branch_1/point"])
    if kind == "refinement":
        return "correction" in file["response"]
    place = {
        "tolerance": "response/point", "attractors": "attractors/motion", "map": "stability_map/row_done",
        "run_up": "run_up/window",
    }
    name = place.get(kind, f"{kind}/point")
    return name in file and len(file[name]) > 0


@pytest.fixture(scope="module")
def checkpoints(executable, tmp_path_factory):
    """A case and the bytes of a checkpoint of each kind."""
    found = {}
    for kind, analyses in CASES.items():
        folder = tmp_path_factory.mktemp(kind)
        case = write_case(folder, analyses)
        found[kind] = case, stop_at_checkpoint(executable, case, folder / "out.h5", kind).read_bytes()
    return found


def test_a_thousand_flips(executable, checkpoints, times):
    """One bit or one byte anywhere in the file, from its first byte to its last: HDF5's own parts, the results, the state, the
    seal. No file is what was written, so that each is refused; every tenth by the executable as well, which leaves it alone."""
    moments = random.Random(20)
    cases = {kind: gt.read_case(case) for kind, (case, _) in checkpoints.items()}
    for number in range(times(1000)):
        kind = list(checkpoints)[number % len(checkpoints)]
        case, content = checkpoints[kind]
        partial = case.with_name("out.h5.partial")
        damaged = bytearray(content)
        place = moments.choice([moments.randrange(len(content)), moments.randrange(2048), -1 - moments.randrange(64)])
        damaged[place] ^= moments.choice([1 << moments.randrange(8), moments.randrange(1, 256)])
        partial.write_bytes(damaged)
        with pytest.raises(OSError, match="its checksum does not fit"):
            cases[kind].run(resume=partial)
        if number % 10 == 0:
            done = run(executable, "case.nml", "--output", "out.h5", "--resume", cwd=case.parent)
            told = f"{kind}: byte {place} of {len(content)}: {done}"
            assert done.returncode == 4 and "out.h5.partial: error: cannot be resumed" in done.stderr and not done.stdout, told
        assert partial.read_bytes() == damaged and not partial.with_name("out.h5").exists()


@pytest.mark.parametrize("kind", CASES)
def test_python_refuses_and_the_rest_is_whole(checkpoints, kind):
    """The same from Python; the checkpoint as it was is taken."""
    case, content = checkpoints[kind]
    partial = case.with_name("out.h5.partial")
    read = gt.read_case(case)
    for place in (0, len(content) // 2, len(content) - 1):
        damaged = bytearray(content)
        damaged[place] ^= 1
        partial.write_bytes(damaged)
        with pytest.raises(OSError, match="its checksum does not fit"):
            read.run(resume=partial)
    with h5py.File(partial, "w") as file:
        file["state"] = 0
    with pytest.raises(OSError, match="its checksum does not fit"):
        read.run(resume=partial)


@pytest.mark.parametrize(("kind", "analyses"), [
    pytest.param("response", "&response from = 0.2, to = 2.6, step = 0.0006, max_points = 100000 /\n", marks=pytest.mark.nightly),
    pytest.param("doublings", "&response from = 1.6, to = 4.2, period_doublings = 1, step = 0.0005, max_points = 100000 /\n",
                 marks=pytest.mark.nightly),
    pytest.param("attractors", "&attractors frequency = 0.6, starts = 300 /\n", marks=pytest.mark.nightly),
    ("map", "&stability_map from = 0.4, to = 1.6, points = 40, parameter_from = 0.01, parameter_to = 0.1,\n"
            "   parameter_points = 200 /\n"),
    pytest.param("run_up", "&run_up from = 0.2, to = 2.6, duration = 12.0, samples = 1 /\n", marks=pytest.mark.nightly),
])
def test_the_same_bits_from_a_whole_one(executable, tmp_path, kind, analyses):
    """Quick cases of every kind, gone on with from their first checkpoints: what a checkpoint as it was written gives."""
    case = write_case(tmp_path, analyses, f"{kind}.nml")
    whole, output = tmp_path / f"{kind}-whole.h5", tmp_path / f"{kind}.h5"
    assert run(executable, case, "--output", whole).returncode == 0
    stop_at_checkpoint(executable, case, output, kind)
    assert run(executable, case, "--output", output, "--resume").returncode == 0
    assert_equal_files(whole, output)
    assert not output.with_name(output.name + ".partial").exists()
