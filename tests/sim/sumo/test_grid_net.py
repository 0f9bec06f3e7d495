"""Grids of the benchmarks against netgenerate's net of the same size."""

import importlib.util
import lzma
import re
import xml.etree.ElementTree as ET

import pytest
from support.paths import ROOT

BENCHMARKS = ROOT / "benchmarks"
RIGHT_OF_WAY = re.compile(r'(response|cont)="[01]+"')


@pytest.mark.slow
def test_a_grid_of_twenty_columns_has_the_elements_of_netgenerate(tmp_path):
    """The city of 1520 edges was built by netgenerate; the right of way of equal roads depends on their names."""
    grid_net = module("grid_net")
    grid_net.write_grid(tmp_path / "grid.net.xml", 20)
    built = ET.fromstring(lzma.decompress((BENCHMARKS / "city.net.xml.xz").read_bytes()))

    mine, theirs = elements(ET.parse(tmp_path / "grid.net.xml").getroot()), elements(built)

    assert len(theirs) > 1520
    assert mine == theirs


def elements(net):
    texts = (ET.canonicalize(ET.tostring(element), strip_text=True) for element in net if element.tag != "location")
    return sorted(RIGHT_OF_WAY.sub("", text) for text in texts)


def module(name):
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded
