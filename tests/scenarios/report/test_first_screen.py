"""First screen of a run: at most 20 lines, the verdict first, the worst limits, possible intervals, next commands."""

from dataclasses import replace
from pathlib import Path

import pytest
from support import short_run

from luxloop.scenarios.files.expect import Check, Limit, exit_code, unmet, verdict
from luxloop.scenarios.report import first_screen
from luxloop.scenarios.report.cells import exceeded
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.rerun_log.viewer import frame_to_show
from luxloop.scenarios.result import Metric
from luxloop.scenarios.run import run_folder

CAUSE = "the rear of the lorry is one point wide, so that its heading follows the noise of a single layer"
COMMANDS = first_screen.commands_of(Path("runs/short-seed4"), recorded=True)
widths = pytest.mark.parametrize("columns", [80, 120])


def check_of(name, value, limit, unit="1", **rest):
    return Check(name, limit, Metric(value, unit, 9), **rest)


def known(name, value, figure=None):
    text = CAUSE if figure is None else f"{figure}: {CAUSE}"
    return check_of(name, value, Limit(min=0.9, known_failure=text))


def screen(checks=(), columns=80, **changes):
    result = replace(short_run.result(), **changes)
    return [line.plain for line in first_screen.screen(result, checks, COMMANDS, "runs/x/report.txt", columns)]


@widths
@pytest.mark.parametrize("count", [0, 1, 2, 3, 5, 8, 30])
def test_any_number_of_limits_fits_into_twenty_lines(count, columns):
    names = list(short_run.result().metrics)[:count]
    lines = screen([known(name, 0.5) for name in names], columns)
    assert len(lines) <= 20
    assert max(map(len, lines)) <= columns
    assert lines[-2:] == [
        "luxloop view runs/short-seed4     the recording, at the worst frame",
        "luxloop report runs/short-seed4   a page with pictures and all results",
    ]
    shown = sum(line.strip().startswith(tuple(names)) for line in lines if names and " < 0.9" in line)
    more = [line for line in lines if line.startswith("  and ")]
    assert more == ([f"  and {count - shown} more: runs/x/report.txt"] if shown < count else [])
    assert shown == count or shown >= 3


def test_unexpected_failures_come_first_then_the_largest_excess():
    checks = [
        known("track.assa", 0.8),
        known("track.deta", 0.5),
        check_of("track.hota", 0.89, Limit(min=0.9, need="the goal")),
        check_of("track.mota", 0.95, Limit(min=0.9)),
        check_of("track.missed", 5.0, Limit(max=4.0), "count"),
    ]
    lines = screen(checks)
    assert lines[0] == "FAILED  short, seed 4: 1 of 5 expectations hold, 2 failed, 2 known failures"
    title = lines.index("4 limits do not hold, 2 known failures among them")
    shown = [line.split()[:4] for line in lines[title + 1 :] if " < " in line or " > " in line]
    assert shown == [
        ["track.hota", "0.890", "<", "0.9"],
        ["track.missed", "5", ">", "4"],
        ["track.deta", "0.500", "<", "0.9"],
        ["track.assa", "0.800", "<", "0.9"],
    ]
    assert [check.name for check in unmet(checks)] == [name for name, *_ in shown]


def test_a_single_limit_has_its_whole_cause_and_many_have_the_beginning():
    alone = screen([known("track.hota", 0.5)])
    title = alone.index("1 limit does not hold, a known failure")
    text = " ".join(" ".join(line.split()) for line in alone[title + 1 : title + 4])
    assert text.startswith("track.hota 0.500 < 0.9 " + CAUSE)
    among = screen([known(name, 0.5) for name in list(short_run.result().metrics)[:9]], 120)
    assert sum(line.endswith(" ...") and CAUSE[:30] in line for line in among) >= 3


def test_a_cause_is_the_stated_one_or_the_worst_frame():
    result = short_run.result()
    beyond = replace(known("track.hota", 0.5, figure=0.88), limit=Limit(min=0.9, known_failure=f"0.88: {CAUSE}"))
    assert beyond.outcome == "failed"
    failed = check_of("fit.heading_abs_mean_deg", 3.0, Limit(max=1.0), "deg")
    without = Check("mma.switch_latency_frames", Limit(max=3.0), result.metrics["mma.switch_latency_frames"])
    text = " ".join(" ".join(screen([beyond, failed, without], 120)).split())
    assert "FAILED: worse than known; " in text
    assert "fit.heading_abs_mean_deg 3.000 > 1 FAILED: worst in frame " in text
    assert "mma.switch_latency_frames n/a, not <= 3 no followed vehicle changed its mode" in text


def test_the_worst_frame_is_the_one_that_view_opens_at():
    result = short_run.result()
    checks = [check_of("fit.heading_abs_mean_deg", 3.0, Limit(max=1.0), "deg"), known("track.hota", 0.5)]
    text = " ".join(screen(checks, 120))
    assert f"Worst {frame_to_show(result, ['fit.heading_abs_mean_deg'])}"[:60] in text
    assert f"Worst {frame_to_show(result, [])}"[:60] in " ".join(screen([], 120))


def test_main_figures_have_intervals_or_say_why_not():
    metrics = {
        **short_run.result().metrics,
        "track.hota": Metric(0.73, "1", 9, interval=(0.612, 0.829)),
        "track.idf1": Metric(0.9, "1", 9, why_no_interval="too few vehicles"),
        "track.missed_share": Metric(0.16438, "1", 9, interval=(0.068, 0.3116)),
        "fit.heading_abs_mean_deg": Metric(None, "deg", 0, "the tracker does not report fits"),
        "track.gospa_m": Metric(1234.5, "m", 9),
    }
    lines = [line.split() for line in screen(metrics=metrics)]
    assert ["HOTA,", "tracking", "as", "a", "whole", "(1", "is", "best)", "0.730", "0.612-0.829"] in lines
    assert any(line[:1] == ["IDF1,"] and line[-4:] == ["0.900", "too", "few", "vehicles"] for line in lines)
    assert ["vehicles", "in", "view", "without", "a", "track", "16.4", "%", "6.80-31.2"] in lines
    assert not any(line[:3] == ["heading", "error", "of"] and "fits," in line for line in lines)
    title = next(k for k, line in enumerate(lines) if line[:2] == ["Main", "figures"])
    assert all(lines[title + k] for k in range(1, first_screen.MOST_FIGURES + 1))
    assert any(line[-1:] == ["track.hota"] for line in (row.split() for row in screen(columns=120)))


@pytest.mark.parametrize(
    ("value", "limit", "shown"),
    [
        (0.61, Limit(min=0.7), "0.610 < 0.7"),
        (0.69996, Limit(min=0.7), "0.69996 < 0.7"),
        (1.35004, Limit(max=1.35), "1.35004 > 1.35"),
        (0.8, Limit(min=0.5, max=0.7), "0.800 > 0.7"),
        (0.4, Limit(min=0.5, max=0.7), "0.400 < 0.5"),
        (None, Limit(min=0.5), "n/a, not >= 0.5"),
    ],
)
def test_value_and_limit_show_their_difference(value, limit, shown):
    assert exceeded(check_of("track.hota", value, limit)) == shown


def test_a_run_without_limits_neither_passes_nor_fails(tmp_path):
    assert verdict([], complete=True) == "no limits"
    assert [exit_code(one) for one in ("passed", "no limits", "failed", "incomplete")] == [0, 0, 1, 1]
    assert screen()[0] == "NO LIMITS  short, seed 4: nothing in [expect] to pass or fail"
    run_folder.write(tmp_path, short_run.result(), [], "")
    run = ReportedRun.read(tmp_path)
    assert (run.verdict, run.answer.sentence) == ("no limits", "nothing in [expect] to pass or fail")


def test_warnings_of_the_traffic_are_one_line():
    lines = screen(warnings=("the lane 'a' is 0.1 m wide, so that all of its vehicles overlap; widen it " * 3, "b"))
    (warning,) = [line for line in lines if line.startswith("Warning: the lane")]
    assert warning.endswith(" ... (and 1 more)")
    assert len(warning) <= 80
