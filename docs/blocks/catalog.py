"""The blocks of all pages: what makes each, by which command a reader repeats it, and which runs date it."""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module

from blocks import studies
from blocks.reference import definitions
from blocks.stamps import CATALOG

FAMILIES = ("highway", "urban", "occlusion", "faults", "noise", "fitting", "adversary")
CROSSING = ("sumo-crossing",)
REAL = "LUXLOOP_REAL_DATA=DIR python docs/figures.py"


@dataclass(frozen=True)
class Block:
    """A generated part of pages."""

    maker: str
    """`MODULE:FUNCTION` below blocks; it gets the name of the block and returns its text, or None for new pictures."""
    command: str = ""
    """Command by which a reader gets the same."""
    runs: tuple[str, ...] = ()
    """Scenarios of the catalog whose trace hashes date the block, or `CATALOG`; none for what code determines."""
    cheap: bool = False
    """A check makes the block again and compares."""
    checked: bool = False
    """Its figures are of these runs, so that other hashes in its stamp are an error, not only old."""

    def make(self, name: str) -> str | None:
        """Return the text of the block, or None if only its pictures are new."""
        module, _, function = self.maker.partition(":")
        made: str | None = getattr(import_module(f"blocks.{module}"), function)(name)
        return made


def of_code() -> Iterator[tuple[str, Block]]:
    """Yield the blocks of code and committed files, which a check makes again, in less than a minute together."""
    for name in definitions():
        yield f"keys of {name}", Block("reference:keys", cheap=True)
    for name in FAMILIES:
        yield f"scenarios of {name}", Block("reference:scenarios", cheap=True)
    yield "known failures", Block("reference:known_failures", cheap=True)
    yield "nearest", Block("reference:nearest", cheap=True)
    yield "tuned", Block("reference:tuned", "python docs/tune_league.py FOLDER", cheap=True)
    yield "first run", Block("reference:printed", "python docs/examples/first_run.py", cheap=True)
    for name in ("seeds", "differences"):
        yield name, Block("coverage:table", f"python docs/figures.py {name}", cheap=True)
    yield "output", Block("reference:printed", "python docs/examples/track_csv.py docs/examples/points.csv", cheap=True)


def of_catalog_runs() -> Iterator[tuple[str, Block]]:
    """Yield the blocks that show runs of the catalog with their own seeds."""
    for name in ("report", "figures"):
        yield name, Block(f"screens:{name}", "luxloop run sumo-crossing", CROSSING, checked=True)
    yield "blame", Block("oracles:blame", "luxloop blame sumo-crossing", CROSSING, checked=True)
    for name in ("verdict", *(f"table {number}" for number in range(1, 5))):
        yield name, Block(f"paper:{name.split()[0]}", "luxloop paper", ("paper-campus",), checked=True)
    yield "vehicles", Block("coverage:table", "python docs/figures.py vehicles", (CATALOG,), checked=True)
    yield "crossing", Block("crossing:draw", "luxloop run sumo-crossing", CROSSING, checked=True)
    yield (
        "report picture",
        Block("screenshots:report", "luxloop report runs/sumo-crossing-seed1", CROSSING, checked=True),
    )
    yield "recording", Block("screenshots:recording", "luxloop view runs/sumo-crossing-seed1", CROSSING, checked=True)
    yield "scan", Block("scan:draw", "luxloop run ring", ("ring",), checked=True)


def of_other_runs() -> Iterator[tuple[str, Block]]:
    """Yield the blocks of studies, other seeds, benchmarks and real data: old when the catalog's runs change."""
    whole = (CATALOG,)
    for name in studies.FIGURES:
        yield name, Block("studies:picture", studies.command(name), whole)
    yield "survival", Block("studies:survival", studies.sweep("occlusion"), whole)
    yield "emergence", Block("studies:emergence", ", ".join(map(studies.sweep, studies.EMERGENCE)), whole)
    yield "sensor_beams", Block("beams:draw", "python docs/figures.py sensor_beams", whole)
    yield "bodies", Block("bodies:draw", "python docs/figures.py bodies", whole)
    yield "ceiling", Block("oracles:ceiling", "luxloop ceiling sumo-crossing --seeds 11-13", whole)
    yield "trackers", Block("screens:trackers", "luxloop run docs/examples/my-first.toml", whole)
    yield "league", Block("league:tables", "luxloop league", whole)
    yield "league picture", Block("league:picture", "luxloop league", whole)
    yield "alone", Block("ablation:table", "python docs/figures.py alone", whole)
    for name in ("stages", "scaling"):
        yield name, Block(f"performance:{name}", "make bench", whole)
    yield "performance", Block("performance:picture", "make bench", whole)
    yield from of_real_data(whole)


def of_real_data(whole: tuple[str, ...]) -> Iterator[tuple[str, Block]]:
    """Yield the blocks that need recordings of real vehicles."""
    makers = {
        "gap": "paper_gap:table",
        "real cars": "real_cars:table", "realism_real_cars": "real_cars:picture",
        "twin counts": "real_cars:counts", "twin headings": "real_cars:headings",
        "street": "realism:block",
        **{f"realism_{name}": "realism:picture" for name in ("distributions", "vehicles")},
    }  # fmt: skip
    for name, maker in makers.items():
        yield name, Block(maker, f"{REAL} '{name}'", whole)
    yield "labelled fits", Block("fitting:table", "luxloop fits street crossing campus", whole)


BLOCKS: dict[str, Block] = dict([*of_code(), *of_catalog_runs(), *of_other_runs()])
"""All blocks by their names on the pages."""
