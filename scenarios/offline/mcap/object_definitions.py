"""Message definitions of detected and tracked objects: vision_msgs 4 (ROS 2) and autoware_perception_msgs 1."""

OBJECT_FIELDS = {
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose, float64[36] covariance",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear, geometry_msgs/Vector3 angular",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist, float64[36] covariance",
    "geometry_msgs/Accel": "geometry_msgs/Vector3 linear, geometry_msgs/Vector3 angular",
    "geometry_msgs/AccelWithCovariance": "geometry_msgs/Accel accel, float64[36] covariance",
    "geometry_msgs/Point32": "float32 x, float32 y, float32 z",
    "geometry_msgs/Polygon": "geometry_msgs/Point32[] points",
    "unique_identifier_msgs/UUID": "uint8[16] uuid",
    "vision_msgs/ObjectHypothesis": "string class_id, float64 score",
    "vision_msgs/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis, geometry_msgs/PoseWithCovariance pose"
    ),
    "vision_msgs/BoundingBox3D": "geometry_msgs/Pose center, geometry_msgs/Vector3 size",
    "vision_msgs/Detection3D": (
        "std_msgs/Header header, vision_msgs/ObjectHypothesisWithPose[] results, vision_msgs/BoundingBox3D bbox, "
        "string id"
    ),
    "vision_msgs/Detection3DArray": "std_msgs/Header header, vision_msgs/Detection3D[] detections",
    "autoware_perception_msgs/ObjectClassification": "uint8 label, float32 probability",
    "autoware_perception_msgs/Shape": ("uint8 type, geometry_msgs/Polygon footprint, geometry_msgs/Vector3 dimensions"),
    "autoware_perception_msgs/TrackedObjectKinematics": (
        "geometry_msgs/PoseWithCovariance pose_with_covariance, "
        "geometry_msgs/TwistWithCovariance twist_with_covariance, "
        "geometry_msgs/AccelWithCovariance acceleration_with_covariance, uint8 orientation_availability, "
        "bool is_stationary"
    ),
    "autoware_perception_msgs/TrackedObject": (
        "unique_identifier_msgs/UUID object_id, float32 existence_probability, "
        "autoware_perception_msgs/ObjectClassification[] classification, "
        "autoware_perception_msgs/TrackedObjectKinematics kinematics, autoware_perception_msgs/Shape shape"
    ),
    "autoware_perception_msgs/TrackedObjects": (
        "std_msgs/Header header, autoware_perception_msgs/TrackedObject[] objects"
    ),
}
