"""Traffic by SUMO, run through libsumo; only `sim.sumo.sumo_source` imports it."""
