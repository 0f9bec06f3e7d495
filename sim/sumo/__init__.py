"""Traffic by SUMO, run through libsumo, which only `luxloop.sim.sumo.sumo_source` imports."""
