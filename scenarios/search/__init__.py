"""Adversarial search: finds the smallest disturbance that makes the tracker fail, and reduces it to a scenario file."""
