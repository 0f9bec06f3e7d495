"""The lock files: complete, one within the other, the same versions under every Python, no address of a registry."""

import re
import tomllib

import pytest
from support.paths import ROOT

LOCKS = sorted(path.name for path in ROOT.glob("constraints*.txt"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RESULTS = {"numpy", "scipy", "numba", "llvmlite", "filterpy", "pandas", "pyarrow", "libsumo", "highway-env"}
"""Packages that can change a result."""
APART = {"ouster-sdk", "osi-python"}
"""Packages that exclude versions of others; `support.separate_packages` installs them."""


def pins(name):
    """Versions by package; more than one where they depend on the Python."""
    found = {}
    for package, version in re.findall(r"^([\w-]+)==([\w.]+)", (ROOT / name).read_text("utf-8"), re.MULTILINE):
        found.setdefault(package, set()).add(version)
    return found


def required(*names):
    return {re.match(r"[\w-]+", requirement)[0] for name in names for requirement in name}


def test_the_run_time_is_part_of_the_development_environment_in_the_same_versions():
    run_time, development = pins("constraints.txt"), pins("constraints-dev.txt")
    assert run_time.items() <= development.items()
    assert required(PROJECT["dependencies"]) <= run_time.keys()
    assert all(len(development[package]) == 1 for package in RESULTS)


def test_the_run_time_has_no_package_of_an_extra():
    extras = {name: listed for name, listed in PROJECT["optional-dependencies"].items() if name not in ("all", "dev")}
    assert (required(*extras.values()) - {"luxloop"}).isdisjoint(pins("constraints.txt"))
    assert {"trackeval", "opencv-python", "protobuf"}.isdisjoint(pins("constraints.txt"))
    assert APART.isdisjoint(pins("constraints-dev.txt"))


@pytest.mark.parametrize("name", LOCKS)
def test_every_pin_has_hashes_and_no_address(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    entries = re.split(r"^(?=[\w-]+==)", text, flags=re.MULTILINE)[1:]
    assert len(entries) == sum(map(len, pins(name).values()))
    assert all("--hash=sha256:" in entry for entry in entries)
    assert not re.search(r"://|^-", text, re.MULTILINE)  # neither an address nor an option of pip
