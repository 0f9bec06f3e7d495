"""A signal in any line of an atomic write: no temporary file stays, and the earlier or the new content is whole."""

import inspect
import sys
from pathlib import Path

import pytest

from luxloop.scenarios.files import atomic_file, atomic_folder

FILES = set(map(str, Path(atomic_file.__file__).parent.glob("*.py")))


class InterruptAt:
    """Raises a KeyboardInterrupt, as a signal does, at the event `number` of the traced files: a line or a return."""

    def __init__(self, number: int) -> None:
        self.left = number

    def __call__(self, frame, event, _):
        if frame.f_code.co_filename not in FILES:
            return None
        generator = frame.f_code.co_flags & inspect.CO_GENERATOR  # an error at its yield would skip its handlers
        if event == "line" or (event == "return" and not generator):
            self.left -= 1
            if self.left == 0:
                sys.settrace(None)
                raise KeyboardInterrupt
        return self


def write_folder(out: Path) -> None:
    with atomic_folder.create(out, "--out", lambda _: None) as temporary:
        for name in ("a", "b"):
            (temporary / name).write_text("new")


def write_file(out: Path) -> None:
    with atomic_file.create(out) as temporary:
        temporary.write_text("new")


def interrupted(write, out: Path, number: int) -> bool:
    """Return True if the write was interrupted, False if it had fewer events."""
    tracer = sys.gettrace()
    sys.settrace(InterruptAt(number))
    try:
        write(out)
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(tracer)
    return False


def content(out: Path) -> list[str]:
    return [path.read_text() for path in sorted(out.iterdir())] if out.is_dir() else [out.read_text()]


@pytest.mark.parametrize("earlier", [True, False])
@pytest.mark.parametrize("write", [write_folder, write_file])
def test_an_interrupt_in_any_line_leaves_no_temporary_file(write, earlier, tmp_path):
    whole, number = (["new", "new"] if write is write_folder else ["new"]), 0
    while True:
        number += 1
        folder = tmp_path / str(number)
        out = folder / "out"
        folder.mkdir()
        if earlier and write is write_folder:
            out.mkdir()
            (out / "old").write_text("old")
        elif earlier:
            out.write_text("old")
        more = interrupted(write, out, number)
        left = [path.name for path in folder.iterdir() if path != out] if folder.exists() else []
        assert left == [], number
        if earlier or not more:
            assert content(out) in ([whole, ["old"]] if more else [whole]), number
        if not more:
            break
    assert number > 20
