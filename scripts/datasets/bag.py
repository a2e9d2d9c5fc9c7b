# SPDX-License-Identifier: BSD-3-Clause
"""Frames -> messages -> rosbag, with the topics and frame ids of a RealSense camera."""
import os

import genpy
import numpy as np
import rosbag
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

from .frames import DatasetError, read_color, read_uint16
from .rotation import to_quaternion

WORLD_FRAME = "world"
CAMERA_FRAME = "camera_color_optical_frame"
COLOR_TOPIC = "/camera/color/image_raw"
INFO_TOPIC = "/camera/color/camera_info"
DEPTH_TOPIC = "/camera/aligned_depth_to_color/image_raw"
SEGMENTATION_TOPIC = "/segmentation"
# ROS reads time 0 as "not set" or "latest": sequences that start before 1 s are moved by this much.
START_OFFSET_NS = 1000000000
# Messages of one frame are recorded this far apart, so that every player keeps their order.
RECORDING_STEP_NS = 100000


def offset_ns(frames):
    return START_OFFSET_NS if frames[0].stamp_ns < START_OFFSET_NS else 0


def to_time(stamp_ns):
    return genpy.Time(stamp_ns // 1000000000, stamp_ns % 1000000000)


def to_image(header, pixels, encoding):
    message = Image(header=header, height=pixels.shape[0], width=pixels.shape[1], encoding=encoding)
    message.is_bigendian = 0
    message.step = pixels.strides[0]
    message.data = pixels.tobytes()
    return message


def to_depth_image(header, raw, units_per_m):
    """Millimetres stay 16UC1 (65535, 7-Scenes' invalid, becomes 0); else 32FC1 metres, lossless."""
    if units_per_m == 1000.0:
        return to_image(header, np.where(raw == 65535, 0, raw).astype("<u2"), "16UC1")
    return to_image(header, (raw / units_per_m).astype("<f4"), "32FC1")


def to_camera_info(header, camera, shape):
    message = CameraInfo(header=header, height=shape[0], width=shape[1])
    message.distortion_model = "plumb_bob"
    message.D = [0.0] * 5
    fx, fy, cx, cy = camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px
    message.K = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
    message.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    message.P = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return message


def to_transform(stamp, T_world_camera):
    message = TransformStamped(child_frame_id=CAMERA_FRAME)
    message.header.stamp = stamp
    message.header.frame_id = WORLD_FRAME
    place, turn = message.transform.translation, message.transform.rotation
    place.x, place.y, place.z = (float(v) for v in T_world_camera[:3, 3])
    turn.x, turn.y, turn.z, turn.w = (float(v) for v in to_quaternion(T_world_camera[:3, :3]))
    return TFMessage(transforms=[message])


def segmentation_class():
    """Only label images need this package's own messages; everything else works before a build."""
    try:
        from task_scene_graph.msg import Segmentation
    except ImportError:
        raise DatasetError("task_scene_graph/Segmentation: message class absent, expected this "
                           "package to be built first (scripts/build)")
    return Segmentation


def to_segmentation(header, labels, embeddings, image_embedding):
    Segmentation = segmentation_class()
    message = Segmentation(header=header, labels=to_image(header, labels.astype("<u2"), "16UC1"))
    message.embedding_size = embeddings.shape[1]
    message.embeddings = embeddings.ravel().tolist()
    message.confidences = [1.0] * embeddings.shape[0]
    message.image_embedding = image_embedding.tolist()
    return message


def frame_messages(sequence, frame, stamp_ns, segmentation):
    """[(topic, message)] in the order in which they are recorded: pose first, segments last."""
    color, raw_depth = read_color(frame.color_path), read_uint16(frame.depth_path)
    if color.shape[:2] != raw_depth.shape:
        raise DatasetError(f"{frame.depth_path}: {raw_depth.shape[1]}x{raw_depth.shape[0]} pixels, "
                           f"expected the colour image's {color.shape[1]}x{color.shape[0]}")
    tf = to_transform(to_time(stamp_ns), frame.T_world_camera)
    header = Image().header
    header.stamp, header.frame_id = to_time(stamp_ns), CAMERA_FRAME
    messages = [("/tf", tf),
                (INFO_TOPIC, to_camera_info(header, sequence.camera, color.shape)),
                (DEPTH_TOPIC, to_depth_image(header, raw_depth, sequence.depth_units_per_m)),
                (COLOR_TOPIC, to_image(header, color, "rgb8"))]
    if segmentation and frame.labels_path:
        messages.append((SEGMENTATION_TOPIC, to_segmentation(header, *segmentation.segment(frame))))
    return messages


def write_bag(path, sequence, frames, segmentation, report):
    """Writes to a temporary name and renames; calls report(done, total) after each frame."""
    temporary = path + ".part"
    shift_ns = offset_ns(sequence.frames)
    if segmentation:
        segmentation_class()
    try:
        with rosbag.Bag(temporary, "w") as bag:
            for done, frame in enumerate(frames, 1):
                stamp_ns = frame.stamp_ns + shift_ns
                messages = frame_messages(sequence, frame, stamp_ns, segmentation)
                for step, (topic, message) in enumerate(messages):
                    bag.write(topic, message, to_time(stamp_ns + step * RECORDING_STEP_NS))
                report(done, len(frames))
        os.replace(temporary, path)
    finally:
        if os.path.exists(temporary):
            os.remove(temporary)
