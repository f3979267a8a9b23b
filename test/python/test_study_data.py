"""The folder of a study is data: whatever its files hold, nothing of it is run, named or believed that was not written there."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest
from conftest import single_pair

import geartrain as gt
from geartrain._core.sealed import DamagedError, seal, unseal
from geartrain.studies.study_command import main
from geartrain.studies.study_plan import Plan
from geartrain.studies.study_store import Store

pytestmark = pytest.mark.full


def study(points=6):
    return gt.Study(single_pair(0.4, stiffness_cos=[0.3]), gt.Space({"input_torque": np.linspace(0.3, 0.5, points)}),
                    keep=["damped_frequency"], modes={})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with all points, and what they are."""
    folder = tmp_path_factory.mktemp("data") / "runs"
    return folder, study().run(folder)


@pytest.fixture
def folder(whole, tmp_path):
    shutil.copytree(whole[0], tmp_path / "runs")
    return tmp_path / "runs"


def call(folder, directory, *arguments):
    return subprocess.run(
        [sys.executable, "-c", "import sys; sys.path[:] = filter(None, sys.path); "
         "from geartrain.studies.study_command import main; sys.exit(main(sys.argv[1:]))", folder, *arguments],
        cwd=directory, capture_output=True, text=True, check=False,
    )


def test_every_flipped_bit_of_a_batch_is_found(folder, times, seed):
    path = Store(folder).paths()[0]
    text = path.read_bytes()
    draw = np.random.default_rng([seed, 1])
    bits = 8 * len(text)
    for bit in draw.choice(bits, min(bits, times(20000)), replace=False).tolist():
        flipped = bytearray(text)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(DamagedError):
            unseal(bytes(flipped))
    path.write_bytes(flipped)
    with pytest.warns(UserWarning, match="is damaged"):
        found = study().dataset(folder)
    assert "missing" in found.status.values


def test_every_flipped_bit_of_a_plan_is_found(folder, times, seed, capsys):
    path, = (folder / "plans").iterdir()
    text = path.read_bytes()
    draw = np.random.default_rng([seed, 2])
    for bit in draw.choice(8 * len(text), times(20000)).tolist():
        flipped = bytearray(text)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(DamagedError):
            Plan.load(bytes(flipped))
    path.write_bytes(flipped)
    assert main([str(folder)]) == 4 and "is damaged" in capsys.readouterr().err


def test_sealed_nonsense_is_refused(folder, capsys):
    """Somebody who can write the checksum too: other types, lengths, names; objects; packed arrays."""
    path, = (folder / "plans").iterdir()
    plan = path.read_bytes()
    arrays = unseal(plan)
    told = json.loads(arrays["about"].item())

    def about(**changes):
        return {**arrays, "about": np.array(json.dumps({**told, **changes}))}

    keys = arrays["keys"].copy()
    keys[0] = b"../../precious"
    absolute = arrays["keys"].astype("S64")
    absolute[1] = b"/tmp/precious"
    nonsense = [
        {**arrays, "keys": keys}, {**arrays, "keys": absolute}, {**arrays, "keys": arrays["keys"][1:]},
        {**arrays, "keys": np.arange(6)}, about(call="page"), about(call="_ask"), about(call=["modes"]), about(targets=[[1, 2]]),
        about(targets=7), about(axes=[["x"]]), about(batch=0), about(batch="many"), about(settings=3), about(keep=None),
        about(case=""), about(case="&gear"), about(case=5), about(case="&train"),
        {"about": np.array("[]")}, {"about": np.array("{")}, {"about": np.array(3)}, {},
        {name: array for name, array in arrays.items() if name != "keys"},
    ]
    for wrong in nonsense:
        path.write_bytes(seal(wrong))
        assert main([str(folder)]) == 4 and "is damaged" in capsys.readouterr().err
    for text in (seal({**arrays, "keys": np.array([{}], object)}), b"", b"x" * 100, plan[:-1], plan + b"x"):
        path.write_bytes(text)
        assert main([str(folder)]) == 4 and "is damaged" in capsys.readouterr().err


def test_a_key_never_names_another_file(folder, tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("kept")
    path, = (folder / "plans").iterdir()
    arrays = unseal(path.read_bytes())
    arrays["keys"] = np.array([str(precious).encode()] * len(arrays["keys"]))
    path.write_bytes(seal(arrays))
    assert main([str(folder), "--retry"]) == 4
    assert precious.read_text() == "kept"
    claims = Store(folder).claims
    claim = {"host": socket.gethostname()[:60], "process": 2**22 - 1, "id": "x"}
    before = precious.stat().st_mtime_ns
    name = Store(folder).paths()[0].name[:39]
    (claims / name).write_bytes(json.dumps(claim).ljust(160).encode() + str(precious).encode())
    with Store(folder).claim(name) as own:
        assert own is not None  # its owner is dead
    assert precious.stat().st_mtime_ns == before and not any(Store(folder).suspects.iterdir())


@pytest.mark.parametrize("text", [
    b"", b"\0" * 200, b"{}", b"[]", b"null", b"\xff" * 300, b'{"host": 1, "process": "x"}', b'{"host": "HOST", "process": 1e400}',
    b'{"host": "HOST", "process": "1"}', b'{"host": "HOST", "process": 99999999999999999999}',
    b'{"host": "elsewhere", "process": 1}',
])
def test_what_is_no_claim_is_in_nobodys_way_for_long(folder, text):
    store = Store(folder)
    path = store.claims / "a-batch"
    path.write_bytes(text.replace(b"HOST", socket.gethostname()[:60].encode()))
    with store.claim("a-batch"):
        pass  # no traceback, whoever has it
    for ahead in (-1000, 100000):  # s; of a clock that is wrong, or of a joker
        path.write_bytes(text)
        os.utime(path, (time.time() + ahead,) * 2)
        with store.claim("a-batch") as claim:
            assert claim is not None


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero"), os.mkdir], ids=["pipe", "device", "folder"])
@pytest.mark.parametrize("place", ["plans/x.npz", "batches/x.npz", "claims/x"])
def test_what_is_no_file_is_told_at_once(folder, capsys, make, place):
    """A pipe that nobody writes to, and a device without end, as an archive from elsewhere may hold them."""
    for path in Store(folder).paths():
        path.unlink()
    plan, = (folder / "plans").iterdir()
    place = folder / place.replace("claims/x", f"claims/{plan.stem}-000000")
    if place.parent == plan.parent:
        plan.unlink()  # the latest is read
    make(place)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        status = main([str(folder), "--workers", "1"])
    if place.parent.name == "batches":
        assert status == 0 and next(str(warning.message) for warning in told).startswith(f"{place}: is damaged")
    else:
        assert status == 4 and str(place) in capsys.readouterr().err


def test_a_folder_that_was_removed_is_computed_again(folder, whole):
    assert study().run(folder).identical(whole[1])
    shutil.rmtree(folder)
    assert study().run(folder).identical(whole[1])
    store = Store(folder)
    store.paths()[0].unlink()
    assert study().run(folder).identical(whole[1])


def test_the_working_directory_is_no_program(folder, whole, tmp_path):
    """A folder whose files have the names of modules, with a point that is computed alone."""
    for name in ("geartrain", "numpy", "json", "multiprocessing"):
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text(f"open({str(tmp_path / 'run')!r}, 'w')\nraise SystemExit(0)\n")
    store = Store(folder)
    for workers in ("1", "2") if sys.version_info >= (3, 11) else ("1",):  # Python 3.10 starts its processes in the directory
        for path in store.paths():
            path.unlink()
        (store.suspects / store.plan().key(0).decode()).touch()
        done = call(".", folder, "--workers", workers)
        assert done.returncode == 0, done
        assert not (tmp_path / "run").exists()
    assert study().dataset(folder).identical(whole[1])


def test_nothing_is_told_of_a_whole_folder(folder, whole):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert study().dataset(folder).identical(whole[1])
