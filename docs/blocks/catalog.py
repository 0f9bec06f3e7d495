"""The blocks of all pages: what makes each, by which command a reader repeats it, and which runs date it."""

from dataclasses import dataclass
from importlib import import_module

from blocks import studies
from blocks.reference import definitions
from blocks.stamps import CATALOG

FAMILIES = ("highway", "urban", "occlusion", "faults", "noise", "fitting", "adversary")


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


def _code(maker: str, command: str = "") -> Block:
    """Return a block of code and committed files; a check makes all of them again, in less than a minute together."""
    return Block(maker, command, cheap=True)


def _run(maker: str, command: str, scenario: str = "sumo-crossing") -> Block:
    """Return a block that shows a run of the catalog with its own seed."""
    return Block(maker, command, (scenario,), checked=True)


def _other(maker: str, command: str) -> Block:
    """Return a block of studies, other seeds, benchmarks or pictures: old when the catalog's runs change."""
    return Block(maker, command, (CATALOG,))


def _drawn(name: str, maker: str) -> Block:
    """Return such a block that only this repository makes."""
    return _other(maker, f"python docs/figures.py {name}")


def _real(name: str, maker: str) -> Block:
    """Return such a block that needs recordings of real vehicles."""
    return _other(maker, f"LUXLOOP_REAL_DATA=DIR python docs/figures.py '{name}'")


BLOCKS: dict[str, Block] = {
    **{f"keys of {name}": _code("reference:keys") for name in definitions()},
    **{f"scenarios of {name}": _code("reference:scenarios") for name in FAMILIES},
    "known failures": _code("reference:known_failures"),
    "nearest": _code("reference:nearest"),
    "first run": _code("reference:printed", "python docs/examples/first_run.py"),
    "output": _code("reference:printed", "python docs/examples/track_csv.py docs/examples/points.csv"),
    **{name: _code("coverage:table", f"python docs/figures.py {name}") for name in ("seeds", "differences")},
    **{name: _run(f"screens:{name}", "luxloop run sumo-crossing") for name in ("report", "figures")},
    "blame": _run("oracles:blame", "luxloop blame sumo-crossing"),
    "crossing": _run("crossing:draw", "luxloop run sumo-crossing"),
    "report picture": _run("screenshots:report", "luxloop report runs/sumo-crossing-seed1"),
    "recording": _run("screenshots:recording", "luxloop view runs/sumo-crossing-seed1"),
    "verdict": _run("paper:verdict", "luxloop paper", "paper-campus"),
    **{f"table {n}": _run("paper:table", "luxloop paper", "paper-campus") for n in range(1, 5)},
    "vehicles": _run("coverage:table", "python docs/figures.py vehicles", CATALOG),
    **{name: _other("studies:picture", studies.command(name)) for name in studies.FIGURES},
    "survival": _other("studies:survival", studies.sweep("occlusion")),
    "emergence": _other("studies:emergence", ", ".join(map(studies.sweep, studies.EMERGENCE))),
    "sensor_beams": _drawn("sensor_beams", "beams:draw"),
    "bodies": _drawn("bodies", "bodies:draw"),
    "alone": _drawn("alone", "ablation:table"),
    "ceiling": _other("oracles:ceiling", "luxloop ceiling sumo-crossing --seeds 11-13"),
    "trackers": _other("screens:trackers", "luxloop run docs/examples/my-first.toml"),
    "league": _other("league:tables", "luxloop league"),
    "league picture": _other("league:picture", "luxloop league"),
    "stages": _other("performance:stages", "make bench"),
    "scaling": _other("performance:scaling", "make bench"),
    "gap": _real("gap", "paper_gap:table"),
    "real cars": _real("real cars", "real_cars:table"),
    "realism_real_cars": _real("realism_real_cars", "real_cars:picture"),
    "twin counts": _real("twin counts", "real_cars:counts"),
    "twin headings": _real("twin headings", "real_cars:headings"),
    "street": _real("street", "realism:block"),
    "realism_distributions": _real("realism_distributions", "realism:picture"),
    "realism_vehicles": _real("realism_vehicles", "realism:picture"),
    "labelled fits": _other("fitting:table", "luxloop fits street crossing campus"),
}
"""All blocks by their names on the pages."""
