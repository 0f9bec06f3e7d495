import math
import subprocess
import sys

import numpy as np
import pytest

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.metrics.definitions import find_metric, standard_names

# Names that users' scenario files, reports and CI depend on.
STABLE_NAMES = [
    "fit.heading_abs_mean_deg{method=area}",
    "fit.within_1deg{method=tlinkage}",
    "fit.within_5deg{method=oracle}",
    "fit.heading_std_deg",
    "fit.position_abs_mean_m",
    "fit.iou_mean",
    "fit.regret_deg",
    "fit.heading_abs_std_deg{method=variance,view=l_shape}",
    "fit.heading_mean_deg{method=closeness,view=rear}",
    "outliers.precision{cause=mirror}",
    "outliers.recall{cause=layer_overlap}",
    "segmentation.over_rate",
    "segmentation.under_rate",
    "segmentation.missed_rate",
    "mma.x_abs_mean_m{model=stationary,target=standing}",
    "mma.y_abs_std_m{model=cv,target=moving}",
    "mma.x_abs_mean_m{target=moving}",
    "mma.mode_accuracy",
    "mma.switch_latency_frames",
    "mma.nees_in_band",
    *(f"track.{name}" for name in ("hota", "mota", "idf1", "id_switches", "fragments", "missed", "false")),
    "track.occlusion_survival",
    "perf.tracker_ms_p99",
    "perf.realtime_factor",
]


@pytest.mark.parametrize("name", STABLE_NAMES)
def test_stable_names_are_metrics(name):
    assert find_metric(name).name == name


def test_units_follow_the_names():
    ends = {"_deg": "deg", "_m": "m", "_rate": "1", "_p50": "ms"}
    for name in standard_names():
        base = find_metric(name).definition.name
        for end, expected in ends.items():
            if base.endswith(end) and ".within_" not in base:
                assert find_metric(name).unit == expected, name
    assert find_metric("fit.within_2deg").unit == "1"


def test_metric_names_import_neither_pandas_nor_scipy():
    code = (
        "import sys, luxloop.scenarios.metrics.definitions, luxloop.scenarios.grading.grading_config;"
        "slow = {'pandas', 'scipy', 'shapely'} & set(sys.modules); assert not slow, slow"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_sheet_accepts_known_names_once_and_finite_values():
    sheet = MetricSheet()
    with pytest.raises(ValueError, match="unknown metric"):
        sheet.write("track.hotta", 1.0, 1, "")
    sheet.write("track.hota", 0.5, 3, "")
    with pytest.raises(ValueError, match="already"):
        sheet.write("track.hota", 0.5, 3, "")
    with pytest.raises(ValueError, match="nan"):
        sheet.write("track.mota", math.nan, 3, "")


def test_metric_without_observations_is_none_with_a_reason():
    sheet = MetricSheet()
    sheet.mean("track.mota", np.empty(0), "no vehicle")
    sheet.rate("outliers.recall{cause=mirror}", 0, 0, "no mirror")
    sheet.write("track.id_switches", 0.0, 0, "no vehicle")
    assert [(m.value, m.n) for m in sheet.metrics.values()] == [(None, 0)] * 3
    assert [m.reason for m in sheet.metrics.values()] == ["no vehicle", "no mirror", "no vehicle"]


@pytest.mark.parametrize(
    "wrong",
    [
        {"range_max_m": -1.0},
        {"points_min": 0},
        {"match_iou_min": 0.0},
        {"owner_share_min": 0.4},
        {"nees_confidence": 1.0},
        {"memory_s": math.nan},
        {"hidden_fraction_max": 1.0},
    ],
)
def test_limits_out_of_range_are_refused_with_their_name(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        GradingConfig(**wrong)
