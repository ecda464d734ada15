"""The script that runs the tests as on other processors: its settings take effect, and it counts
what ended.
"""

import json
import platform
from pathlib import Path

import llvmlite.binding as llvm
import pytest

from tests.benchmarks import processors
from tests.benchmarks.processors import Matrix, Outcome, environment, settings, table
from tests.typed import python

ROOT = Path(__file__).parents[2]
of_x86 = pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="settings are of x86-64 processors"
)
HOST = {name for name, on in llvm.get_host_cpu_features().items() if on}
TESTS = """
import os, signal

def test_first(): pass
def test_second(): assert False
def test_third(): __import__("pytest").skip("a reason")
def test_fourth(): %s
def test_fifth(): pass
"""


def instructions(name, folder):
    """Those of a process of a setting, with a store of its own."""
    here = environment({"CLEARANCE_STORE": str(folder)} | settings()[name], folder)
    return json.loads(python("-m", "tests.instructions", cwd=ROOT, env=here).stdout)


def numbers(words, kind):
    """Registers of a kind, by their numbers."""
    return {int(w.removeprefix(f"%{kind}")) for w in words if w.startswith(f"%{kind}")}


@of_x86
@pytest.mark.slow
def test_AVX2_takes_effect(tmp_path):
    """No register of AVX-512 in a kernel, a function of numba and lanes, and none of its loops;
    products are summed in one operation where the processor can.
    """
    report = instructions("AVX2", tmp_path)
    for words in report["code"].values():
        assert not numbers(words, "zmm") | numbers(words, "k")
        assert max(numbers(words, "xmm") | numbers(words, "ymm")) < 16
        assert any("fmadd" in w for w in words) == ("fma" in HOST)
    assert report["lanes"] == (4 if {"avx2", "fma"} <= HOST else 1)
    assert {*report["kernels"]} <= {"Haswell"}
    assert not {"X86_V4", "AVX512_SKX", "AVX512_ICL", "AVX512_SPR"} & {*report["loops"]}


@of_x86
@pytest.mark.slow
def test_SSE2_takes_effect(tmp_path):
    """Instructions of SSE2 alone, one lane, kernels of OpenBLAS for processors without more, no
    loops of numpy but those that each processor gets; the C library rounds otherwise than with FMA.
    """
    report = instructions("SSE2", tmp_path)
    for words in report["code"].values():
        assert numbers(words, "xmm") <= {*range(16)}
        assert "mulsd" in words
        assert "fma" not in words  # twenty times as slow as the C library's sine
        later = ("v", "%y", "%z", "%k", "hadd", "round", "blend", "pshufb", "ptest", "popcnt")
        assert not [w for w in words if w.startswith(later)]
    assert report["lanes"] == 1
    assert {*report["kernels"]} <= {"Prescott", "Katmai"}
    assert not {"X86_V3", "X86_V4", "AVX512_SKX", "AVX512_ICL", "AVX512_SPR"} & {*report["loops"]}
    if platform.libc_ver()[0] == "glibc" and "fma" in HOST:
        assert report["rounding"] != rounding_here()


def rounding_here():
    """The digest of the C library as this processor has it."""
    code = "from tests.instructions import rounding; print(rounding())"
    free = {k: v for k, v in environment({}, "").items() if k != "GLIBC_TUNABLES"}
    return python("-c", code, cwd=ROOT, env=free).stdout.strip()


@pytest.fixture
def tried(tmp_path):
    """Runs a file of tests whose fourth one has this body; the matrix after it."""

    def run(fourth, **others):
        path = tmp_path / "test_five.py"
        path.write_text(TESTS % fourth)
        matrix = Matrix(str(tmp_path), others.get("minutes", 60.0), str(tmp_path / "journal"))
        matrix.run([(str(path), name) for name in ("one lane", "this processor")], 2)
        return matrix

    return run


def test_ends_are_counted(tried, tmp_path):
    """Each test by its end, under each setting; a file that went well is not run again."""
    (one, other) = sorted(tried("pass").outcomes, key=lambda o: o.setting)
    assert (one.setting, other.setting) == ("one lane", "this processor")
    for outcome in (one, other):
        assert outcome.ends == {"passed": 3, "failed": 1, "skipped": 1}
        assert [f.rpartition("::")[2] for f in outcome.failed] == ["test_second"]
    (tmp_path / "journal").write_text(json.dumps(vars(one) | {"failed": []}) + "\n")
    again = tried("pass").outcomes
    assert [(o.setting, len(o.failed)) for o in again] == [("one lane", 0), ("this processor", 1)]


def test_what_ended_before_the_end_stays_counted(tried):
    """A file whose process is killed: its first three tests. Where the end of the time killed it,
    it is cut; else its end is a failure of its own, unless a test failed before.
    """
    for outcome in tried("os.kill(os.getpid(), signal.SIGKILL)").outcomes:
        assert outcome.ends == {"passed": 1, "failed": 1, "skipped": 1}
        assert len(outcome.failed) == 1
    printed = "tests/test_a.py::test_b[1 2] PASSED [ 50%]\ntests/test_a.py::test_c "
    cut, ended = Outcome("AVX2", "a.py", cut=True), Outcome("AVX2", "a.py")
    for outcome in (cut, ended):
        outcome.take(printed, -9)
        assert outcome.ends == {"passed": 1}
    assert (cut.failed, ended.failed) == ([], ["a.py: exit status -9"])
    assert table([cut, ended], ["AVX2"])[-1] == "| AVX2 | 2 | 1 | 2 | 0 | 1 |"


def test_nothing_begins_after_the_end(tried):
    """Without time left no file is run."""
    assert tried("pass", minutes=-1.0).outcomes == []


def test_lanes_concern_few_files():
    """A setting of lanes alone is for files that name lanes or what runs in them."""
    one, all_else = settings()["one lane"], settings()["SSE2"]
    assert processors.concerned("tests/sweeping/test_together.py", one)
    assert not processors.concerned("tests/stepping/test_tableaus.py", one)
    assert processors.concerned("tests/stepping/test_tableaus.py", all_else)


def test_exit_status(tmp_path, monkeypatch, capsys):
    """1 where a test failed, with its name below the table; 0 otherwise."""
    path = tmp_path / "test_one.py"
    for body, status in (("pass", 0), ("assert False", 1)):
        path.write_text(f"def test_it(): {body}\n")
        words = ["processors.py", "--settings", "one lane", "--workers", "1", str(path)]
        monkeypatch.setattr("sys.argv", words)
        assert processors.main() == status
        assert ("one lane: " in capsys.readouterr().out) == bool(status)
