# SPDX-License-Identifier: BSD-3-Clause
"""Frames -> messages -> rosbag, with the topics and frame ids of a RealSense camera."""
from typing import NamedTuple, Tuple

import genpy
import numpy as np
import rosbag
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

from .frames import BrokenFile, DatasetError
from .images import NO_READING
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


def to_depth_image(header, raw, scale):
    """Integer millimetres stay 16UC1 (65535 becomes 0); else 32FC1 metres, lossless."""
    if scale.is_millimetres and raw.dtype == np.uint16:
        return to_image(header, np.where(raw == NO_READING, 0, raw).astype("<u2"), "16UC1")
    return to_image(header, scale.to_metres(raw).astype("<f4"), "32FC1")


def to_camera_info(header, camera, shape):
    message = CameraInfo(header=header, height=shape[0], width=shape[1])
    message.distortion_model = "plumb_bob"
    message.D = (list(camera.distortion) + [0.0] * 5)[:5]
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


def frame_messages(frame, stamp_ns, loader, segmentation):
    """[(topic, message)] in the order in which they are recorded: pose first, segments last."""
    images = loader.load(frame, segmentation is not None)
    header = Image().header
    header.stamp, header.frame_id = to_time(stamp_ns), CAMERA_FRAME
    info = to_camera_info(header, loader.match.camera, images.color.shape)
    messages = [("/tf", to_transform(to_time(stamp_ns), frame.T_world_camera)),
                (INFO_TOPIC, info),
                (DEPTH_TOPIC, to_depth_image(header, images.depth, loader.scale)),
                (COLOR_TOPIC, to_image(header, images.color, "rgb8"))]
    if images.labels is not None:
        segments = segmentation.segment(images.labels, frame.index)
        messages.append((SEGMENTATION_TOPIC, to_segmentation(header, *segments)))
    return messages


class Written(NamedTuple):
    num_frames: int
    duration_s: float  # from the first frame's stamp to the last one's
    topics: Tuple[str, ...]


def write_bag(path, frames, loader, segmentation, broken, report):
    """Calls report(done, total) after each frame. Frames that cannot be read go to `broken`."""
    shift_ns = offset_ns(frames)
    if segmentation:
        segmentation_class()
    stamps_ns, topics = [], {}
    with rosbag.Bag(path, "w") as bag:
        for done, frame in enumerate(frames, 1):
            stamp_ns = frame.stamp_ns + shift_ns
            try:
                messages = frame_messages(frame, stamp_ns, loader, segmentation)
            except BrokenFile as error:
                broken.add(error)
                messages = []
            for step, (topic, message) in enumerate(messages):
                bag.write(topic, message, to_time(stamp_ns + step * RECORDING_STEP_NS))
                topics[topic] = None
            stamps_ns += [stamp_ns] if messages else []
            report(done, len(frames))
    duration_s = (stamps_ns[-1] - stamps_ns[0]) / 1e9 if stamps_ns else 0.0
    return Written(len(stamps_ns), duration_s, tuple(topics))
