"""Names, units and meanings of the metrics of truth and tracks in files."""

from typing import NamedTuple


class Definition(NamedTuple):
    """A metric of files: name, unit and meaning in one line."""

    name: str
    unit: str
    meaning: str


SCORES = (
    Definition("track.hota", "1", "higher order tracking accuracy"),
    Definition("track.deta", "1", "detection accuracy of HOTA"),
    Definition("track.assa", "1", "association accuracy of HOTA"),
    Definition("track.loca", "1", "localisation accuracy of HOTA: mean overlap of matched pairs"),
    Definition("track.mota", "1", "CLEAR multiple object tracking accuracy"),
    Definition("track.motp", "1", "CLEAR multiple object tracking precision: mean overlap of the hits"),
    Definition("track.idf1", "1", "F1 score of identities"),
    Definition("track.id_switches", "count", "changes of the track that hits an object (CLEAR)"),
    Definition("track.fragments", "count", "interruptions of an object's track (CLEAR)"),
    Definition("track.missed", "count", "true boxes without a track, summed over frames (CLEAR)"),
    Definition("track.false", "count", "tracks that hit no true box, summed over frames (CLEAR)"),
)
GOSPA = (
    Definition("track.gospa_m", "m", "GOSPA (p = 2, alpha = 2), mean over frames"),
    Definition("track.gospa_localisation_m2", "m^2", "part of squared GOSPA by distances of located objects"),
    Definition("track.gospa_missed_m2", "m^2", "part of squared GOSPA by missed objects"),
    Definition("track.gospa_false_m2", "m^2", "part of squared GOSPA by false tracks"),
)
AVERAGES = (
    Definition("track.amota", "1", "MOTAR of nuScenes, averaged over recalls, then over classes"),
    Definition("track.amotp_m", "m", "distance of the pairs, averaged over recalls, then over classes"),
)
ERRORS = (
    Definition("track.position_abs_mean_m", "m", "mean distance of the centres of pairs"),
    Definition("track.iou_mean", "1", "mean bird's-eye intersection over union of pairs"),
    Definition("track.heading_abs_mean_deg", "deg", "mean absolute heading error modulo 360 of pairs"),
    Definition("track.velocity_abs_mean_mps", "m/s", "mean norm of the velocity error of pairs"),
    Definition("track.length_abs_mean_m", "m", "mean absolute error of the length of pairs"),
    Definition("track.width_abs_mean_m", "m", "mean absolute error of the width of pairs"),
    Definition("track.height_abs_mean_m", "m", "mean absolute error of the height of pairs"),
)
DEFINITIONS = {one.name: one for one in (*SCORES, *GOSPA, *AVERAGES, *ERRORS)}
