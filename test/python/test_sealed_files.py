"""Results files with a seal that fits and a content that geartrain never writes: each is refused with what, where and how much."""

import lzma
import pathlib
import random
import re
import resource
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from conftest import ROOT, run

import geartrain as gt

MARK = b"geartrain sealed"
SEAL = len(MARK) + 16
QUICK = "&modes /\n&response from = 0.2, to = 0.5, harmonics = 2 /\n&integration from = 0.6, to = 0.7, points = 2 /\n"


def crc64(content):
    """The checksum that xz puts before the index and the footer of its file."""
    packed = lzma.compress(content, check=lzma.CHECK_CRC64, preset=0)
    index = 4 * (int.from_bytes(packed[-8:-4], "little") + 1)
    return packed[-12 - index - 8 : -12 - index]


def seal(path):
    """Seal the content of a file as geartrain does."""
    content = path.read_bytes()
    path.write_bytes(content + MARK + len(content).to_bytes(8, "little") + crc64(content))


@pytest.fixture(scope="module")
def whole(executable, tmp_path_factory):
    """The bytes of a results file, without the seal."""
    folder = tmp_path_factory.mktemp("whole")
    case = folder / "case.nml"
    case.write_text((ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0] + QUICK)
    done = run(executable, case, "--output", folder / "case.h5")
    assert done.returncode == 0, done.stderr
    return (folder / "case.h5").read_bytes()[:-SEAL]


@pytest.fixture
def forged(whole, tmp_path):
    """A function that changes a copy of the file with h5py, and seals it."""

    def forge(change):
        path = tmp_path / "forged.h5"
        path.write_bytes(whole)
        with h5py.File(path, "r+") as file:
            change(file)
        seal(path)
        return path

    return forge


def replace(file, name, *arguments, **keywords):
    del file[name]
    return file.create_dataset(name, *arguments, **keywords)


def test_a_sealed_copy_is_read(forged):
    """What the tests below change is refused for the change alone."""
    assert len(gt.read_results(forged(lambda file: None)).response.frequency) > 2


def circle(file):
    for number in range(40):
        file[f"response/again{number}"] = file["/"]


def nest(file):
    group = file["response"]
    for _ in range(3000):
        group = group.create_group("g")


def late(file, shape, kind=float, **keywords):
    """An array that is never written, so that it takes no bytes."""
    return replace(file, "response/rms", shape, kind, **keywords)


def long_texts(file):
    """A million texts that are one and the same text of a megabyte in the file: a terabyte."""
    kind = h5py.string_dtype()
    texts = replace(file, "integration/direction", (20000,), kind)
    texts[:] = "x"
    texts[0] = "y" * 1_000_000
    file.flush()
    content = np.empty(20000, dtype="V16")
    place = texts.id.get_offset()
    name = file.filename
    file.close()
    with open(name, "r+b") as raw:
        raw.seek(place)
        content[:] = np.frombuffer(raw.read(16), dtype="V16")[0]
        raw.seek(place)
        raw.write(content.tobytes())


def negative(file):
    """An extent whose highest bit is set, which h5py does not write."""
    late(file, (2**40 + 12345, 0))
    name = file.filename
    file.close()
    content = pathlib.Path(name).read_bytes()
    before, after = ((2**place + 12345).to_bytes(8, "little") for place in (40, 63))
    assert content.count(before) >= 1
    pathlib.Path(name).write_bytes(content.replace(before, after))


def external(file):
    replace(file, "response/rms", (4, 2), float, external=[("/dev/zero", 0, h5py.h5f.UNLIMITED)])


def virtual(file):
    layout = h5py.VirtualLayout((40000, 40000), float)
    layout[:] = h5py.VirtualSource(".", "response/frequency", (40000, 40000))
    del file["response/rms"]
    file.create_virtual_dataset("response/rms", layout)


def wide(file):
    file["response"].attrs.create("harmonics", np.zeros(3000))


NASTY = {
    "a product beyond 32 bits": (
        lambda f: late(f, (65537, 65536)), "response/rms in it has 65537 x 65536 values: must be 2147483647"),
    "a product beyond 64 bits": (lambda f: late(f, (2**40, 2**40)), "1099511627776 x 1099511627776 values"),
    "an extent beyond 32 bits": (lambda f: late(f, (2**33, 0)), "8589934592 x 0 values"),
    "an extent that is negative in 64 bits": (negative, "-9223372036854763463 x 0 values|rms is not in it"),
    "never written": (lambda f: late(f, (60000, 30000)), "60000 x 30000 values of 8 bytes each, of which the file has 0 bytes"),
    "never written, of bytes": (lambda f: late(f, (30000, 30000), np.int8), "30000 x 30000 values of 1 bytes each"),
    "never written texts": (lambda f: late(f, (30000, 30000), h5py.string_dtype()), "30000 x 30000 values of 16 bytes each"),
    "compressed": (lambda f: late(f, (30000, 30000), compression="gzip"), "is chunked, compressed or in another file"),
    "chunked": (lambda f: late(f, (30000, 30000), chunks=(10000, 10000)), "is chunked, compressed or in another file"),
    "in another file": (external, "is chunked, compressed or in another file"),
    "virtual": (virtual, "is chunked, compressed or in another file"),
    "eight dimensions": (lambda f: late(f, (1,) * 8), "has 8 dimensions: must have 7 at most"),
    "an attribute with dimensions": (wide, "response/harmonics in it has 1 dimensions: must have 0"),
    "an attribute without a value": (
        lambda f: f["response"].attrs.create("harmonics", h5py.Empty("i4")), "response/harmonics in it has no value"),
    "more harmonics than there is memory for": (
        lambda f: f["response"].attrs.create("harmonics", np.int32(2**31 - 1)), "/response/harmonics in it"),
    "a period longer than any": (
        lambda f: f["response"].attrs.create("subharmonic", np.int32(2**31 - 1)), "/response/subharmonic in it"),
    "groups in a circle": (circle, "must be in 7 at most|linked in a circle"),
    "a group in itself": (lambda f: f.__setitem__("response/again", f["response"]), "must be in 7 at most|linked in a circle"),
    "a deep nest": (nest, "is a group in 8 others: must be in 7 at most"),
    "an array linked again and again": (
        lambda f: [f.__setitem__(f"response/again{i}", f["response/coefficients"]) for i in range(3000)], "linked in a circle"),
    "a soft link": (lambda f: f.__setitem__("response/again", h5py.SoftLink("/response")), "is a link to another place"),
    "an external link": (
        lambda f: f.__setitem__("response/again", h5py.ExternalLink("/dev/stdin", "/")), "is a link to another place"),
    "a long name": (lambda f: f["response"].create_group("n" * 10000), "is a name of 10000 characters: must have 64 at most"),
    "one text again and again": (long_texts, "has texts of more characters than the file has bytes"),
}


def read_with_little(path, error):
    """Read the results in a process that may have 2 GB of memory, and print the expected error."""
    code = (
        "import sys, resource\nimport geartrain as gt\nresource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31))\n"
        f"try:\n    gt.read_results(sys.argv[1])\nexcept {error} as error:\n    print(error)\n")
    return subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("kind", NASTY)
def test_what_cannot_be_is_refused(forged, executable, kind):
    """By Python and, as a checkpoint, by the executable: at once, and with little memory, so that nothing large was begun."""
    change, told = NASTY[kind]
    path = forged(change)
    begin = time.monotonic()
    with pytest.raises(OSError, match=rf"forged\.h5: error: cannot be read as results: .*({told})"):
        gt.read_results(path)
    assert time.monotonic() - begin < 5
    done = read_with_little(path, "OSError")
    assert done.returncode == 0 and re.search(told, done.stdout), done
    case = path.with_name("case.nml")
    case.write_text((ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0] + QUICK)
    content = path.rename(path.with_name("out.h5.partial")).read_bytes()
    done = run(executable, case, "--output", path.with_name("out.h5"), "--resume",
               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30)))
    assert done.returncode == 4 and "out.h5.partial: error: cannot be resumed" in done.stderr, done
    assert path.with_name("out.h5.partial").read_bytes() == content


def test_a_file_beyond_all_memory(tmp_path):
    """Of 14 GB, of which the disk has none: it is not even read."""
    path = tmp_path / "huge.h5"
    with path.open("wb") as file:
        file.truncate(60000 * 30000 * 8)
    done = read_with_little(path, "MemoryError")
    assert done.returncode == 0 and "there is no memory for its 14400000000 bytes" in done.stdout, done


def test_a_list_beyond_all_memory(whole, tmp_path):
    """30 million motions, of which the file has no more than their numbers."""
    path = tmp_path / "list.h5"
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        replace(file, "integration/point", (30_000_000,), "i1").write_direct(np.ones(30_000_000, "i1"))
    seal(path)
    done = read_with_little(path, "OSError")
    assert done.returncode == 0 and "/integration/point in it has more places than there is memory for" in done.stdout, done


def random_change(chance):
    """A change of one of the kinds above at a random place, with random numbers."""
    extents = (0, 1, 2, 3, 255, 65536, 65537, 2**31 - 1, 2**31, 2**32, 2**32 + 1, 2**62, 2**63, 2**64 - 2)
    kinds = (float, np.float32, np.float16, np.int8, np.uint8, np.int64, np.uint64, ">f8", "S5", "c16", "V3", h5py.string_dtype())

    def change(file):
        names = []
        file.visit(names.append)
        name = chance.choice(names)
        shape = tuple(chance.choice(extents) for _ in range(chance.randrange(9)))
        kind = chance.choice(kinds)
        match chance.randrange(8):
            case 0 | 1 | 2:
                del file[name]
                file.create_dataset(name, shape, kind)
            case 3:
                small = tuple(chance.randrange(5) for _ in shape)
                del file[name]
                file.create_dataset(name, small, kind, chunks=True if small and 0 not in small else None)
            case 4:
                groups = [item for item in (file, *map(file.get, names)) if isinstance(item, h5py.Group)]
                for number in range(chance.randrange(1, 30)):
                    chance.choice(groups)[f"link{number}"] = chance.choice([*groups, file[name]])
            case 5:
                file[name].attrs.create(chance.choice(("subharmonic", "complete", "ended", "harmonics")),
                                        chance.choice((0, -1, 2**31, "x" * 60000, np.zeros(5), h5py.Empty("f8"), float("nan"))))
            case 6:
                group = file.require_group(f"branch_{chance.randrange(1, 4)}")
                for number in range(chance.randrange(200)):
                    group = group.create_group(f"g{number}")
            case _:
                other = chance.choice(names)
                if name != other and not other.startswith(name) and not name.startswith(other):
                    file.move(name, other + "_moved")

    return change


@pytest.mark.nightly
def test_random_forgeries(whole, tmp_path, times, seed):
    """Each in a process with little memory: read, or refused with a reason; never a crash, a hang or the end of the interpreter."""
    chance = random.Random(7 + 1000 * seed)
    code = "import sys, numpy, resource\nimport geartrain as gt\nresource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31))\n" + (
        "for path in sys.argv[1:]:\n    try:\n        gt.read_results(path)\n        print('read')\n"
        "    except OSError as error:\n        print(type(error).__name__, str(error).count('cannot be read as results'))\n")
    counts = {}
    for _ in range(times(3000) // 50):
        paths = []
        for number in range(50):
            path = tmp_path / f"{number}.h5"
            path.write_bytes(whole)
            with h5py.File(path, "r+") as file:
                try:
                    random_change(chance)(file)
                except (ValueError, OSError, TypeError, KeyError, RuntimeError):  # h5py itself refuses some of them
                    pass
            seal(path)
            paths.append(str(path))
        done = subprocess.run([sys.executable, "-c", code, *paths], capture_output=True, text=True, timeout=300, check=False)
        told = done.stdout.splitlines()
        assert done.returncode == 0 and len(told) == len(paths), (done, paths[len(told)])
        for line in told:
            counts[line] = counts.get(line, 0) + 1
    assert set(counts) == {"read", "OSError 1"} and min(counts.values()) > 0.05 * sum(counts.values()), counts
