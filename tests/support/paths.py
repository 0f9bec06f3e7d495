"""Folders of the checkout, for tests that read its files."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
EXAMPLES = DOCS / "examples"
CATALOG = ROOT / "scenarios" / "catalog"
TESTS = ROOT / "tests"
NETS = TESTS / "nets"


def without_checkouts(entries: list[str]) -> list[str]:
    """Return the entries of a Python path that are no checkout: its folders have former names of luxloop's packages."""
    return [entry for entry in entries if not Path(entry, "tracker", "tracker.py").is_file()]
