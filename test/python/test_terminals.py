"""Characters that act on a terminal, such as escape sequences: no message, warning or report holds one, whoever wrote it."""

import os
import sys
import unicodedata

import h5py
import numpy as np
import pytest
from conftest import ROOT, paper_train, run

import geartrain as gt
from geartrain.errors import plain, shown
from geartrain.pages.page_command import main as make_page
from geartrain.studies.study_command import main as run_study

#: Clears the screen, C1's beginning of a sequence, next line, override of direction, isolate, line separator, tag.
ACTING = ("\x1b[2J", "\x9b31m", "\x85", "\u202e", "\u2067", "\u2028", "\U000e0041")
SOURCE = (ROOT / "namelists" / "branched.nml").read_text().split("&modes")[0]
#: Where a case has a text, and what messages call it; each is replaced by the text with the character in it.
PLACES = {
    "'Power split": "title", "'pinion',  inertia": "name", "'motor', 'pinion'": "between", "'pinion', 'wheel 1'": "between",
    "&shaft": "&", "4.6e-3": "", "2.5e8, damping": "", "&train\n": "", "= 9870.0": "",
}
POLYNOMIAL = 0xC96C5795D7870F42


def acts(character):
    """By the classes of Unicode: control characters, separators of lines, and what changes the direction until it is ended."""
    lines = unicodedata.category(character) in ("Cc", "Zl", "Zp")
    return lines or unicodedata.bidirectional(character) in ("LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI")


def is_clean(text):
    return not any(acts(character) for character in text.replace("\n", ""))


def test_fortran_and_python_have_the_same_list(tmp_path):
    path = tmp_path / "case.nml"
    small = (ROOT / "namelists" / "single_pair.nml").read_text()

    def is_refused(title):
        path.write_text(small.replace("A single gear pair with backlash", title), encoding="utf-8", newline="")
        try:
            return gt.read_case(path).train.title != title
        except gt.InputError as error:
            return "without control characters" in str(error)

    # A file with a 0 is binary, and a line ends the text.
    characters = [chr(code) for code in range(sys.maxunicode + 1) if not 0xD800 <= code < 0xE000 and chr(code) not in "\0\n'"]
    shown = [plain(character) for character in characters]
    refused = [character for character, words in zip(characters, shown, strict=True) if words != character]
    assert all(map(is_refused, (f"a{character}b" for character in refused)))
    allowed = [character for character, words in zip(characters, shown, strict=True) if words == character]
    assert {*filter(acts, characters)} <= {*refused} and len(refused) < 300
    chunks = ["".join(allowed[first:first + 5000]) for first in range(0, len(allowed), 5000)]
    assert not any(map(is_refused, chunks)) and len(chunks) > 200


@pytest.mark.parametrize("character", ACTING)
def test_no_message_of_the_executable_holds_one(executable, tmp_path, character):
    path = tmp_path / "case.nml"
    for begin, name in PLACES.items():
        text = SOURCE.replace(begin, begin[:3] + character + begin[3:], 1)
        assert text != SOURCE
        path.write_text(text, encoding="utf-8")
        for option in ("--check", "--explain", "--audit"):
            done = run(executable, option, path, encoding="utf-8")
            assert done.returncode == 2 and name in done.stderr and is_clean(done.stdout + done.stderr), (begin, done.stderr)
            assert plain(character)[:4] in done.stderr, (begin, done.stderr)
        with pytest.raises(gt.InputError) as caught:
            gt.read_case(path)
        assert is_clean(str(caught.value))


@pytest.mark.parametrize("character", [*ACTING, "\n"])
def test_names_of_files(executable, tmp_path, character):
    """The file of a case, an option and a name of results may hold any character but 0; what is told of them is plain."""
    odd = tmp_path / f"a{character}b.nml"
    code = plain(character)
    odd.write_text(SOURCE + "&modes /\n", encoding="utf-8")
    told = [run(executable, *arguments, cwd=tmp_path, encoding="utf-8") for arguments in (
        (odd,), ("--check", odd), ("--explain", odd, odd), ("--audit", odd), ("--new", odd), ("--new", f"n{odd.name}"),
        (f"--{character}",), (f"no{character}.nml",), (odd, "-o", f"{odd}/x"), ("--resume", odd))]
    for done in told:
        assert done.stderr + done.stdout and code in done.stderr + done.stdout
        assert is_clean(done.stdout + done.stderr), done
        assert character == "\n" or done.returncode in (0, 2, 3, 4)
    if character == "\n":
        assert not any("\nb.nml" in done.stdout + done.stderr for done in told)


def test_names_that_are_no_utf_8(executable, tmp_path):
    odd = os.fsencode(tmp_path) + b"/a\x9b\xff.nml"
    done = run(executable, odd, text=False)
    assert done.returncode == 2 and rb"a\x9b\xff.nml: error" in done.stderr


@pytest.mark.parametrize("character", ACTING)
def test_no_message_of_python_holds_one(train, branch, tmp_path, character, capsys):
    odd = f"x{character}"
    results = branch.at(0.5)[0]
    for call in (
        lambda: paper_train(title=odd), lambda: gt.Train(bodies=[gt.Body(name=odd, inertia=1.0)]),
        lambda: gt.read_case(tmp_path / odd), lambda: gt.read_results(tmp_path / odd),
        lambda: train.response(start=0.2, stop=odd), lambda: train.response(start=0.2, stop=1.0, unit=odd),
        lambda: train.response(start=0.2, stop=1.0, parameter=odd), lambda: branch.at(odd), lambda: results.plot(odd),
        lambda: gt.Space(train, [odd]), lambda: branch.plot(odd), lambda: gt.page(odd), lambda: gt.read_study(tmp_path / odd),
        lambda: train.explain()[odd],
    ):
        with pytest.raises((gt.InputError, OSError, KeyError, TypeError)) as caught:
            call()
        assert is_clean(str(caught.value)), str(caught.value)
    for error in (gt.InputError(odd), gt.SolverError(odd), gt.Interrupted(odd), gt.DrawingWarning(odd),
                  gt.NotDifferentiableWarning({odd: odd})):
        assert is_clean(str(error)) and plain(character) in str(error)
    assert is_clean(shown(type(odd, (), {"__repr__": lambda _: odd})()))
    assert run_study([str(tmp_path / odd)]) == 4
    assert make_page([str(tmp_path / odd)]) == 4
    for command in (run_study, make_page):
        with pytest.raises(SystemExit):
            command([str(tmp_path), odd])
    told = capsys.readouterr()
    assert told.err and is_clean(told.err + told.out), told


def crc64(content):
    """As checksum.f90 has it."""
    table = np.arange(256, dtype=np.uint64)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ POLYNOMIAL, table >> 1)
    table, checksum = table.tolist(), 2**64 - 1
    for byte in content:
        checksum = table[(checksum ^ byte) & 255] ^ (checksum >> 8)
    return checksum ^ (2**64 - 1)


def test_texts_of_a_results_file_are_escaped(executable, tmp_path):
    """A file that others have sealed, or that an older version wrote, may hold any text."""
    assert crc64(b"123456789") == 0x995DC9BBDF1939FA
    case, path = tmp_path / "case.nml", tmp_path / "case.h5"
    case.write_text(SOURCE.replace("Power split", "Power xyz split") + "&response from = 0.3, to = 0.4, max_points = 5 /\n")
    assert run(executable, case, cwd=tmp_path).returncode == 3
    with h5py.File(path, "r+") as file:
        file.attrs["input"] = file.attrs["input"].replace("xyz", "\x1b[2J\u202e")
        file["response"].attrs["ended"] = "\x1b]0;x\x07"
    content = path.read_bytes()
    content = content[:content.index(b"geartrain sealed")] if b"geartrain sealed" in content else content
    seal = len(content).to_bytes(8, "little") + crc64(content).to_bytes(8, "little")
    path.write_bytes(content + b"geartrain sealed" + seal)
    results = gt.read_results(path)
    assert results.response.ended == r"\x1b]0;x\x07"
    assert r"Power \x1b[2J\u202e split" in results.text
    for text in (repr(results), repr(results.response), results.text, results.ended, results.page().html):
        assert is_clean(text.replace("\t", "")), text[:200]
