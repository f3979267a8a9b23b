"""What wheels rest on: Fourier transforms of our own, two HDF5 libraries in one process, and, where scripts/wheel has told
``GEARTRAIN_WHEEL``, the wheel that is installed."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import distribution
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import ROOT, run, write_case

from geartrain import _geartrain

in_wheel = pytest.mark.skipif("GEARTRAIN_WHEEL" not in os.environ, reason="scripts/wheel tests it")

# What every system has for a wheel, by PEP 600.
SYSTEM = re.compile(r"/(ld-linux[^/]*|lib(c|m|mvec|dl|pthread|rt|gcc_s))\.so[.0-9]*$")

TRANSFORMS = """
program transforms
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_fftw, only: transform_type
   implicit none (type, external)
   type(transform_type) :: transform
   integer :: n, status

   do
      read (*, *, iostat=status) n
      if (status /= 0) exit
      call transform%plan(n)
      read (*, *) transform%sample
      call transform%to_coefficients()
      write (*, '(2es26.17)') transform%coefficient
      ! What a real motion cannot have must not matter.
      transform%coefficient(1) = transform%coefficient(1) + (0.0_dp, 3.0_dp)
      if (mod(n, 2) == 0) transform%coefficient(n/2 + 1) = transform%coefficient(n/2 + 1) + (0.0_dp, 2.0_dp)
      call transform%to_samples()
      write (*, '(es26.17)') transform%sample
   end do
end program transforms
"""


@pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran")
def test_our_transforms_against_those_of_numpy(tmp_path):
    # Every length up to 40, those that we take, large factors that are primes; and from one plan to the next.
    lengths = [*range(1, 41), 64, 80, 96, 128, 192, 320, 1009, 1024, 1280, 1536, 31**2, 2 * 31**2, 5**4, 8]
    (tmp_path / "transforms.f90").write_text(TRANSFORMS)
    sources = [ROOT / "src/geartrain/base/kinds.f90", ROOT / "python/fft.f90", ROOT / "python/fft_kernels.c", "transforms.f90"]
    subprocess.run(["gfortran", "-O1", "-fcheck=all,no-array-temps", *sources, "-o", "transforms"], cwd=tmp_path, check=True)
    rng = np.random.default_rng(1)
    samples = [rng.uniform(-0.3, 0.7, length) for length in lengths]
    told = "".join(f"{len(x)}\n" + "".join(f"{value!r}\n" for value in x.tolist()) for x in samples)
    values = np.array(run(tmp_path / "transforms", input=told, check=True).stdout.split(), dtype=float)
    for x in samples:
        n = len(x)
        coefficients, values = values[:2 * (n // 2 + 1)].reshape(-1, 2) @ [1, 1j], values[2 * (n // 2 + 1):]
        expected = np.fft.rfft(x)
        # Measured against sums in quadruple precision: 4e-15 at most, 7e-15 for the prime 1009; NumPy's are as exact.
        assert np.abs(coefficients - expected).max() < 2e-14 * np.sqrt(np.mean(np.abs(expected) ** 2)), n
        assert np.abs(values[:n] / n - x).max() < 1e-14, n
        values = values[n:]
    assert values.size == 0


BOTH = """
from threading import Thread
import numpy as np

case = gt.read_case("case.nml")
results = case.run()
table = np.arange(20000.0).reshape(100, 200)
wrong = []

def geartrain_side():
    for k in range(20):
        results.write("ours.h5")
        again = gt.read_results("ours.h5")
        if not np.array_equal(again.response.rms, results.response.rms):
            wrong.append(("geartrain", k))

def h5py_side():
    for k in range(20):
        with h5py.File("theirs.h5", "w") as file:
            file["table"] = table
            file.create_dataset("packed", data=table, compression="gzip")
        with h5py.File("theirs.h5") as file:
            if not (np.array_equal(file["table"], table) and np.array_equal(file["packed"], table)):
                wrong.append(("h5py", k))

with h5py.File("open.h5", "w") as file:
    file["before"] = table
    threads = [Thread(target=geartrain_side), Thread(target=h5py_side)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    file["after"] = table
with h5py.File("ours.h5") as ours, h5py.File("open.h5") as theirs:
    again = gt.read_results("ours.h5")
    assert np.array_equal(theirs["before"], theirs["after"])
    assert "damping_ratio" in ours.attrs["input"]
    assert np.array_equal(again.response.rms, results.response.rms)
try:
    gt.read_results("theirs.h5")
except OSError as error:
    print(error)
assert not wrong, wrong
"""


@pytest.mark.parametrize("imports", ["import h5py, geartrain as gt", "import geartrain as gt, h5py"])
def test_two_hdf5_libraries_in_one_process(imports, tmp_path):
    write_case(tmp_path, "&response from = 0.5, to = 0.9, harmonics = 3 /\n")
    done = run(sys.executable, "-X", "faulthandler", "-c", imports + BOTH, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "theirs.h5" in done.stdout
    assert done.stderr == "", "HDF5 tells its errors by itself"


@in_wheel
def test_wheel_is_small_and_says_its_licences():
    wheel = Path(os.environ["GEARTRAIN_WHEEL"])
    assert wheel.stat().st_size < 15e6
    assert "manylinux" in wheel.name
    licence = distribution("geartrain").metadata["License-Expression"]
    terms = {"BSD-3-Clause", "BSD-3-Clause-Open-MPI", "HDF5", "BSD-3-Clause-LBNL", "GPL-3.0-or-later WITH GCC-exception-3.1",
             "LGPL-2.1-or-later"}
    assert set(licence.split(" AND ")) == terms
    with zipfile.ZipFile(wheel) as file:
        names = {Path(name).name for name in file.namelist() if "/licenses/" in name}
    assert {"LICENSE", "HDF5.txt", "LAPACK.txt", "GCC.txt"} <= names


@in_wheel
def test_wheel_brings_all_that_it_needs():
    folder = Path(_geartrain.__file__).parent
    for path in (_geartrain.__file__, folder / "bin" / "geartrain"):
        needed = run("ldd", path, check=True).stdout
        assert "not found" not in needed
        loaded = [os.path.realpath(name) for name in re.findall(r"(/\S+) \(", needed)]
        inside = str(folder.parent.resolve() / "geartrain.libs") + "/"
        assert any(name.startswith(inside) for name in loaded)
        assert [name for name in loaded if not name.startswith(inside) and not SYSTEM.search(name)] == []


@in_wheel
@pytest.mark.skipif(not shutil.which("nm"), reason="no nm")
def test_wheel_shows_no_library_inside():
    symbols = run("nm", "-D", _geartrain.__file__, check=True).stdout
    assert not re.search(r"\b(H5\w+|h5\w+|fftw\w+|d(gemm|getrf|geev)_)", symbols)


@in_wheel
def test_wheel_has_the_command(tmp_path):
    command = shutil.which("geartrain")
    assert command and Path(command).samefile(Path(sys.executable).parent / "geartrain")
    (tmp_path / "t.nml").write_text(run(command, "--template", check=True).stdout)
    done = run(command, "t.nml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (results,) = tmp_path.rglob("*.h5")
    with h5py.File(results) as file:
        assert "response" in file
    assert run(command, "no-such.nml", cwd=tmp_path).returncode == 2
