"""Folders of the checkout, for tests that read its files."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
EXAMPLES = DOCS / "examples"
CATALOG = ROOT / "scenarios" / "catalog"
TESTS = ROOT / "tests"
NETS = TESTS / "nets"
