"""Traffic by SUMO, run through libsumo, which only `sim.sumo.sumo_source` imports."""
