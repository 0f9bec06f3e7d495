"""Traffic by SUMO, run through libsumo; only `sim.sumo.source` imports it."""
