"""Prints AMOTA and AMOTP of nuScenes' development kit on the drives of `support.box_files`, as JSON by seed.

The kit cannot be installed beside numpy 2, so this runs in an environment of its own, with `tests` on the path:
Python 3.11, nuscenes-devkit 1.2.0 (without its dependencies), motmetrics 1.4.0, numpy 1.26.4, pandas 1.5.3, and
pyquaternion, tqdm, scikit-learn, matplotlib, shapely, cachetools and opencv-python-headless, which the kit imports.
`tests/scenarios/exchange/test_published_examples.py` has the numbers.
"""

import json
from collections import defaultdict

import numpy as np
from support.box_files import Box, drive

FRAMES, CARS, SEEDS = 20, 6, 6


def tracking_boxes(rows: list[Box], kind: type, *, scored: bool) -> dict:
    """Return boxes as the kit's loader does: each has the mean score of its track."""
    scores = defaultdict(list)
    for box in rows:
        scores[box.id].append(box.score)
    frames = {frame: [] for frame in range(FRAMES)}
    for box in rows:
        made = kind(
            sample_token=str(box.frame), translation=(box.x, box.y, 0.0), size=(box.width, box.length, 1.5),
            rotation=(1, 0, 0, 0), velocity=(0, 0), tracking_id=box.id, tracking_name=box.kind,
            tracking_score=float(np.mean(scores[box.id])) if scored else -1.0,
        )  # fmt: skip
        frames[box.frame].append(made)
    return {"scene": frames}


def main() -> None:
    """Evaluate all drives with the kit's classes and the averaging of its `evaluate.py`."""
    from nuscenes.eval.common.config import config_factory
    from nuscenes.eval.tracking.algo import TrackingEvaluation
    from nuscenes.eval.tracking.constants import AVG_METRIC_MAP
    from nuscenes.eval.tracking.data_classes import TrackingBox, TrackingMetricData

    config, found = config_factory("tracking_nips_2019"), {}
    for seed in range(SEEDS):
        truth, tracks = drive(seed, FRAMES, CARS)
        curve = TrackingEvaluation(
            tracking_boxes(truth, TrackingBox, scored=False), tracking_boxes(tracks, TrackingBox, scored=True), "car",
            config.dist_fcn_callable, config.dist_th_tp, config.min_recall, num_thresholds=TrackingMetricData.nelem,
            metric_worst=config.metric_worst, verbose=False,
        ).accumulate()  # fmt: skip
        found[seed] = []
        for average, metric in AVG_METRIC_MAP.items():
            values = np.array(curve.get_metric(metric))
            values[np.isnan(values)] = config.metric_worst[average]
            found[seed].append(float(values.mean()))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
