"""Run a scenario from Python, read its metrics and tables, and compare two settings of the tracker.

python docs/examples/first_run.py
"""

import luxloop

SCENARIO, DURATION_S = "truck-shadow-1s", 6.0

mma = luxloop.run(SCENARIO, duration_s=DURATION_S)
print(f"{mma.scenario}, seed {mma.seed}, {mma.frames} frames: {mma.verdict}")
for name in ("track.hota", "track.id_switches", "fit.heading_abs_mean_deg"):
    metric = mma.metrics[name]
    value = "n/a, " + metric.reason if metric.value is None else f"{metric.value:.3f}"
    print(f"  {name:30} {value} [{metric.unit}]")

fits = mma.tables["fits"]
best = fits[fits["best"]]
print("Heading error of the fits [deg], by the visible sides:")
print(best["heading_error_deg"].abs().groupby(best["view"], observed=True).mean().round(3).to_string())

imm = luxloop.run(SCENARIO, duration_s=DURATION_S, settings={"tracker.mma.method": "imm"})
comparison = luxloop.compare(mma, imm)
print(f"Filters with an interacting multiple model instead: {comparison.verdict}")
