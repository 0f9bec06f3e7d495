"""Kernels of a wheel are found; those of a read-only installation without a home go to the temporary folder."""

import os
import subprocess
import sys
import tempfile

import numba
import pytest

from luxloop import kernel_folder
from luxloop.scenarios.exit_codes import ExitCode, explain


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return an empty temporary folder of a process without a writable home."""
    monkeypatch.delenv(kernel_folder.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null/none")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


# A path below a file can be written by nobody, not even by root.
READ_ONLY = "/dev/null/luxloop"


def test_a_read_only_installation_has_a_folder_of_the_user_alone(temporary):
    kernel_folder.choose(kernel_folder.Path(READ_ONLY))
    folder = temporary / f"luxloop-kernels-{os.getuid()}"
    assert os.environ.pop(kernel_folder.VARIABLE) == str(folder)
    assert folder.stat().st_mode & 0o777 == 0o700


def test_a_user_without_a_home_has_it_too(temporary, monkeypatch):
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(kernel_folder.os.path, "expanduser", lambda path: path)
    kernel_folder.choose(kernel_folder.Path(READ_ONLY))
    assert os.environ.pop(kernel_folder.VARIABLE).startswith(str(temporary))


def test_a_folder_that_others_can_write_is_not_used(temporary):
    (temporary / f"luxloop-kernels-{os.getuid()}").mkdir()
    (temporary / f"luxloop-kernels-{os.getuid()}").chmod(0o777)
    kernel_folder.choose(kernel_folder.Path(READ_ONLY))
    assert kernel_folder.VARIABLE not in os.environ


@pytest.mark.parametrize("writable", ["package", "home", "variable"])
def test_where_something_is_writable_nothing_changes(writable, temporary, monkeypatch):
    if writable == "home":
        monkeypatch.setenv("XDG_CACHE_HOME", str(temporary / "a" / "b"))
    if writable == "variable":
        monkeypatch.setenv(kernel_folder.VARIABLE, "/kept")
    kernel_folder.choose(temporary if writable == "package" else kernel_folder.Path(READ_ONLY))
    assert os.environ.get(kernel_folder.VARIABLE) == ("/kept" if writable == "variable" else None)
    assert not list(temporary.iterdir())


@pytest.fixture
def wheel(tmp_path, monkeypatch):
    """Return an installed package with kernels, in a process without variables of numba and without numba itself."""
    for name in (kernel_folder.VARIABLE, *kernel_folder.PROCESSOR):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.delitem(sys.modules, "numba")
    monkeypatch.setattr(kernel_folder, "_flags", lambda: kernel_folder.FLAGS | {"fpu"})
    (tmp_path / kernel_folder.SHIPPED).write_text(numba.__version__)
    return tmp_path


def chosen(package):
    """Return the variables that `use_shipped` sets."""
    kernel_folder.use_shipped(package)
    return {name: value for name in kernel_folder.PROCESSOR if (value := os.environ.pop(name, None)) is not None}


def test_kernels_of_a_wheel_select_their_processor(wheel):
    assert chosen(wheel) == {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}


@pytest.mark.parametrize("reason", ["source", "numba", "processor", "read-only", "folder", "user", "imported"])
def test_kernels_that_cannot_be_found_select_nothing(reason, wheel, monkeypatch):
    if reason == "source":
        (wheel / kernel_folder.SHIPPED).unlink()
    elif reason == "numba":
        (wheel / kernel_folder.SHIPPED).write_text("0.1")
    elif reason == "processor":
        monkeypatch.setattr(kernel_folder, "_flags", lambda: kernel_folder.FLAGS - {"avx2"})
    elif reason == "read-only":
        monkeypatch.setattr(kernel_folder.os, "access", lambda *_: False)
    elif reason == "folder":
        monkeypatch.setenv(kernel_folder.VARIABLE, "/kept")
    elif reason == "user":
        monkeypatch.setenv("NUMBA_CPU_FEATURES", "+avx")
    else:
        monkeypatch.setitem(sys.modules, "numba", numba)
    assert chosen(wheel) == ({"NUMBA_CPU_FEATURES": "+avx"} if reason == "user" else {})


def test_the_flags_of_this_processor_are_read():
    if sys.platform == "linux" and os.uname().machine == "x86_64":
        assert "sse2" in kernel_folder._flags()


def test_the_package_chooses_before_numba_is_imported():
    program = "import sys, luxloop; print('luxloop.kernel_folder' in sys.modules, 'numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "False"]


def test_without_any_folder_one_line_names_the_variable():
    """The error is that of numba itself, for a function without a file and so without a folder."""
    names = {}
    exec(compile("def function(): pass", "<no file>", "exec"), names)
    with pytest.raises(RuntimeError) as error:
        numba.njit(cache=True)(names["function"])
    code, line = explain(error.value)
    assert (code, "NUMBA_CACHE_DIR" in line) == (ExitCode.BAD_INPUT, True)
    assert explain(RuntimeError("another"))[0] == ExitCode.INTERNAL
