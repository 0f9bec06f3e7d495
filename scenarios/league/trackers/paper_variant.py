"""The paper's own steps: the settings of `docs/examples/paper-variant.toml`."""

from dataclasses import replace

from luxloop.tracker.tracker import Tracker, TrackerConfig


def paper_variant(config: TrackerConfig) -> Tracker:
    """Return the shipped tracker with the paper's method in every stage that departs from it by choice."""
    return Tracker(
        replace(
            config,
            linkage=replace(config.linkage, variant="paper"),
            rectangles=replace(config.rectangles, halvings=0),
            selection=replace(config.selection, variant="paper"),
            association=replace(config.association, shape_cost_max=0.0, view_std_m=0.0),
            filters=replace(config.filters, heading="paper"),
            mma=replace(config.mma, method="paper", tail_dof=1e6),
            small=replace(config.small, enabled=False),
            corner=replace(config.corner, known_std_m=0.0, unseen_fraction=0.0),
        )
    )
