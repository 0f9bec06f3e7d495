"""Content of an OSI trace as JSON, read by ASAM's own `osi3`: run as a program, with its packages on the path."""

import json
import math
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from osi3 import osi_groundtruth_pb2, osi_sensordata_pb2, osi_trafficupdate_pb2

TYPES = {
    "osi3.GroundTruth": osi_groundtruth_pb2.GroundTruth,
    "osi3.SensorData": osi_sensordata_pb2.SensorData,
    "osi3.TrafficUpdate": osi_trafficupdate_pb2.TrafficUpdate,
}


def read(path):
    """Return metadata, channels, and the messages by topic, parsed both by `osi3` and by the schemas of the file."""
    with open(path, "rb") as stream:  # noqa: PTH123
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = {"metadata": [[record.name, record.metadata] for record in reader.iter_metadata()], "messages": {}}
        summary = reader.get_summary()
        found["chunks"] = len(summary.chunk_indexes)
        found["channels"] = {
            channel.topic: [
                summary.schemas[channel.schema_id].name, summary.schemas[channel.schema_id].encoding,
                channel.message_encoding, channel.metadata,
            ]
            for channel in summary.channels.values()
        }  # fmt: skip
        for schema, channel, record, by_schema in reader.iter_decoded_messages():
            message = TYPES[schema.name].FromString(record.data)
            assert message.SerializeToString() == by_schema.SerializeToString()
            found["messages"].setdefault(channel.topic, []).append(
                {"time": record.log_time, "publish": record.publish_time, **shown(schema.name, message)}
            )
    return found


def shown(name, message):
    stamp = message.timestamp
    out = {"stamp": stamp.seconds * 10**9 + stamp.nanos, "version": message.version.version_minor}
    if name == "osi3.GroundTruth":
        out["host"] = message.host_vehicle_id.value
        out["moving"] = [[m.id.value, m.type, *base(m.base), *more(m.base)] for m in message.moving_object]
        out["kinds"] = [list(m.source_reference[0].identifier) for m in message.moving_object]
        out["stationary"] = [
            [s.id.value, *base(s.base), s.base.dimension.height, s.base.position.z] for s in message.stationary_object
        ]
        rear = next(m for m in message.moving_object if m.id.value == out["host"]).vehicle_attributes.bbcenter_to_rear
        out["rear"] = [rear.x, rear.y, rear.z]
    elif name == "osi3.TrafficUpdate":
        (moving,) = message.update
        out["update"] = [moving.id.value, *base(moving.base), *velocity(moving.base)]
    else:
        at = message.mounting_position
        out["mounting"] = [at.position.x, at.position.y, at.position.z, at.orientation.yaw, at.orientation.pitch,
                           at.orientation.roll]  # fmt: skip
        out["tracks"] = [[m.header.tracking_id.value, *base(m.base), *velocity(m.base)] for m in message.moving_object]
        out["points"] = [
            [d.position.distance, d.position.azimuth, d.position.elevation, d.beam_id.value,
             d.echo_pulse_width, d.object_id.value, d.HasField("object_id")]
            for lidar in message.feature_data.lidar_sensor for d in lidar.detection
        ]  # fmt: skip
    return out


def base(found):
    size, at, turn = found.dimension, found.position, found.orientation
    return [at.x, at.y, turn.yaw, size.length, size.width]


def velocity(found):
    return [found.velocity.x, found.velocity.y] if found.HasField("velocity") else [math.nan, math.nan]


def more(found):
    return [*velocity(found), found.acceleration.x, found.acceleration.y, found.orientation_rate.yaw,
            found.dimension.height, found.position.z]  # fmt: skip


if __name__ == "__main__":
    json.dump(read(sys.argv[1]), sys.stdout)
