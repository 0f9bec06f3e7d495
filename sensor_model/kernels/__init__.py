"""Hot loops of the sensor, compiled by numba: plain arrays in and out, without configuration or state."""
