"""Mutated scenario files: each runs, or is refused with one clear line and without partial output."""

import json
import re
import signal
import warnings
from contextlib import contextmanager
from pathlib import Path

import pytest
from support import mutants, short_run
from support.paths import EXAMPLES, ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.files.expect import RunVerdict
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run import device, loop, progress, run_folder
from luxloop.scenarios.run.warm_up import STATUS

TIMEOUT_S = 60.0
"""Timeout, far above the second that two frames take, for busy machines and compilation."""
LONGEST_LINE = 1050
COMPILATION = re.escape(STATUS.activity)
"""Notice before an answer: a mutant may need a kernel that no run before it has compiled."""
OUT = Path("out")
FAST, SLOW, ALL = 12, 300, 1000
"""Numbers of mutants of `make test`, of these and `make slow`, and of all with `make soak`."""
NUMBERS = [
    *range(FAST),
    *(pytest.param(number, marks=pytest.mark.slow) for number in range(FAST, SLOW)),
    *(pytest.param(number, marks=pytest.mark.soak) for number in range(SLOW, ALL)),
]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """A copy of the folders of the scenarios, without the scenarios. Kernels are compiled before any timeout runs."""
    short_run.result()
    paper = Scenario.load(EXAMPLES / "paper-variant.toml", {"duration_s": mutants.SHORT_S})
    loop.run(paper, device.load(device.SHIPPED))
    root = tmp_path_factory.mktemp("library")
    for original in mutants.ORIGINALS:
        folder = root / original.parent.relative_to(ROOT)
        folder.mkdir(parents=True, exist_ok=True)
        for beside in original.parent.iterdir():
            if beside.suffix != ".toml" and not (folder / beside.name).exists():
                (folder / beside.name).symlink_to(beside)
    return root


@pytest.mark.parametrize("number", NUMBERS)
def test_a_mutant_runs_or_is_refused_in_one_line(number, library, tmp_path, monkeypatch, capfd):
    mutant = mutants.mutant(number)
    file = library / mutant.original.parent.relative_to(ROOT) / f"mutant-{number}.toml"
    file.write_bytes(mutant.content)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(progress, "SILENCE_S", TIMEOUT_S)  # a slow machine would name what it waits for
    with time_limit(TIMEOUT_S), warnings.catch_warnings():
        warnings.simplefilter("error")  # a printed warning would be a second line
        code = main(["run", str(file), "--no-recording", "--json", "--out", str(OUT)])
    out, err = capfd.readouterr()
    err = re.sub(rf".*{COMPILATION}.*\n", "", err)
    if OUT.exists():
        assert_complete(code, out, err)
    else:
        assert_refused(code, out, err, file, mutant)
    assert [path.name for path in Path().iterdir()] in ([], [OUT.name])


def assert_complete(code: int, out: str, err: str):
    """Check that the folder holds a run, and that standard output agrees with it."""
    document = json.loads(out)
    verdict: RunVerdict = document["verdict"]
    assert run_folder.read(OUT).trace_hash == document["trace_hash"]
    incomplete = 3 if document["simulator_failed"] else 1
    assert code == {"passed": 0, "no limits": 0, "failed": 1, "incomplete": incomplete}[verdict]
    assert err.count("\n") == (verdict == "incomplete")


def assert_refused(code: int, out: str, err: str, file: Path, mutant: mutants.Mutant):
    """Check that one line names the file and the key."""
    assert code in (2, 3), mutant.how
    assert out == ""
    assert err.startswith(f"luxloop: error: {file}: ")
    assert err.count("\n") == 1
    assert len(err) < LONGEST_LINE
    assert err[:-1].isprintable()
    assert not mutant.keys or any(key in err for key in mutant.keys), mutant.how


@contextmanager
def time_limit(seconds: float):
    """Raise an error that no handler catches, and repeat it every second: some callbacks drop exceptions."""

    def give_up(*_):
        raise HangError(f"after {seconds} s")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


class HangError(BaseException):
    """The time limit is exceeded."""


def test_mutants_cover_every_mutation_and_every_file():
    """Without variety of the mutants, the test above would show nothing."""
    some = [mutants.mutant(number) for number in range(SLOW)]
    assert {mutant.original for mutant in some} == set(mutants.ORIGINALS)
    assert len({mutant.content for mutant in some[:FAST]}) == FAST
    assert mutants.mutant(3) == some[3]
    for how in (*mutants.OF_KEYS, *mutants.OF_TEXT):
        assert any(how.__name__ in mutant.how for mutant in (mutants.mutant(number) for number in range(ALL)))
