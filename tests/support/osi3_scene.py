"""A scene with a turning ego, a moving car, a parked truck, a wall and a house."""

from support import short_run

MOVING = 'ego = { motion = [{ kind = "arc", speed_mps = 3.0, radius_m = 12.0 }] }'
HOUSE = """
[[traffic.obstacle]]
corners_m = [[-12, -20], [-12, -14], [-4, -14], [-4, -20]]
height_m = 6
"""
TEXT = short_run.TEXT.replace('kind = "scripted"', f'kind = "scripted"\n{MOVING}') + HOUSE
