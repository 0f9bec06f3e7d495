"""The hint of every extra names packages and versions of the metadata, as pip reads them."""

import re
import shlex
import tomllib
from importlib.metadata import PackageNotFoundError

import pytest
from packaging.requirements import Requirement
from support.paths import ROOT

from luxloop.sim import optional_packages
from luxloop.sim.optional_packages import install_command

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]


def flat(extra):
    """Return the requirements of an extra in pyproject.toml, also of the extras that it includes."""
    found = set()
    for line in EXTRAS[extra]:
        included = re.fullmatch(r"luxloop\[(.*)\]", line)
        found |= set().union(*map(flat, included[1].split(","))) if included else {Requirement(line)}
    return found


@pytest.mark.parametrize("extra", sorted(EXTRAS))
def test_the_command_installs_the_packages_of_the_extra(extra, monkeypatch):
    monkeypatch.setattr(optional_packages, "requires", lambda _: metadata())
    program, action, *packages = shlex.split(install_command(extra))
    assert (program, action) == ("pip", "install")
    assert {Requirement(package) for package in packages} == flat(extra)


def metadata():
    """Return the requirements as a build of this checkout writes them."""
    return ["numpy>=2", *(f"{package}; extra == '{extra}'" for extra in EXTRAS for package in flat(extra))]


def test_the_installed_metadata_has_the_packages():
    assert re.fullmatch(r"pip install 'dask>=\S+' 'distributed>=\S+' 'fsspec>=\S+'", install_command("sweeps"))


def test_a_checkout_without_metadata_is_installed_from_its_folder(monkeypatch):
    def absent(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(optional_packages, "requires", absent)
    assert install_command("osi") == "pip install -e '.[osi]' in the checkout"
