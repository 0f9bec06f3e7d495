"""Make the measured figures, tables and pictures of the pages, and check that they are today's.

    python docs/figures.py                 # all blocks that are older than the baseline; hours, resumable
    python docs/figures.py report stages   # these blocks
    python docs/figures.py --list          # every block with its command, its pages and its state
    python docs/figures.py --check         # a minute: fails where a page shows something else than today's luxloop

A block of a page is a generated part between `<!-- NAME | command | stamp | claims -->` and `<!-- end -->`.
`blocks/catalog.py` lists the blocks. The stamp has the version of luxloop, the trace hashes of the runs that the block
shows, and a digest of its text and pictures, so that a change by hand is found. A claim is a conclusion that the prose
draws from a table, such as `[fit][HOTA] > [size][HOTA]`: row and column in brackets.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from blocks import stamps
from blocks.catalog import BLOCKS
from blocks.claims import broken
from blocks.page import Part, pages, parts, write

ROOT = Path(__file__).parents[1]


def main() -> None:
    """Make or check blocks; the exit code of a check is 1 if a page is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="blocks to make, also those of today")
    parser.add_argument("--check", action="store_true", help="change nothing, fail where a page is wrong")
    parser.add_argument("--list", action="store_true", help="list all blocks")
    given = parser.parse_args()
    unknown = [name for name in given.names if name not in BLOCKS]
    if unknown:
        parser.error(f"{unknown[0]}: no such block; --list shows all")
    found = [part for page in pages(ROOT) for part in parts(page)]
    if given.list:
        print("\n".join(f"{part.page.name}: {part.name}: {part.command}: {state(part)}" for part in found))
    elif given.check:
        fresh = {name: block.make(name) for name, block in BLOCKS.items() if block.cheap}
        wrong = [*faults(found, fresh), *(f"{name}: is on no page" for name in BLOCKS.keys() - {p.name for p in found})]
        print("\n".join(wrong) or "all blocks are today's")
        sys.exit(bool(wrong))
    else:
        make(given.names or list(dict.fromkeys(part.name for part in found if state(part) != "today's")))


def state(part: Part) -> str:
    """Return whether a part shows today's figures, by the trace hashes of its stamp."""
    if part.name not in BLOCKS:
        return "no such block in docs/blocks/catalog.py"
    today = stamps.runs(BLOCKS[part.name].runs)
    return "today's" if not today or today in part.stamp else f"not of {today}"


def make(names: list[str]) -> None:
    """Make blocks one after the other; each page is written at once, so that an interrupted call loses one block."""
    for name in names:
        print(f"{name} ...", flush=True)
        try:
            text = BLOCKS[name].make(name)
        except Exception as error:  # the other blocks follow, in hours without supervision
            print(f"{name}: left as it is: {type(error).__name__}: {error}", flush=True)
            continue
        for page in pages(ROOT):
            write(page, name, text, stamps.runs(BLOCKS[name].runs))
            for fault in faults([part for part in parts(page) if part.name == name], {}):
                print(fault, flush=True)


def faults(found: list[Part], fresh: dict[str, str | None]) -> Iterator[str]:
    """Yield what is wrong with parts of the pages, a line each; `fresh` has the text of blocks that were made again."""
    for part in found:
        where, again = f"{part.page.name}: {part.name}", f"python docs/figures.py '{part.name}'"
        if part.name not in BLOCKS:
            yield f"{where}: {state(part)}"
            continue
        if part.name in fresh and fresh[part.name] != part.text:
            yield f"{where}: is not what luxloop gives today; {again}"
        if state(part) != "today's" and BLOCKS[part.name].checked:
            yield f"{where}: shows runs that are {state(part)}; {again}"
        if part.digest and part.digest != stamps.digest(part.page, part.text):
            yield f"{where}: was changed by hand; {again}"
        for claim in broken(part.claims, part.text):
            yield f"{where}: the text says {claim}; correct the text and the claim"


if __name__ == "__main__":
    main()
