# SPDX-License-Identifier: BSD-3-Clause
"""Small bags for tests: a camera that moves sideways in a room with two boxes, in closed form."""
import io
import struct

import genpy
import numpy as np
import PIL.Image
import rosbag
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from task_scene_graph.msg import Segmentation
from tf2_msgs.msg import TFMessage

WIDTH, HEIGHT = 160, 120
FX = FY = 120.0
CX, CY = 79.5, 59.5
NUM_FRAMES = 30
COLOR = "/camera/color/image_raw"
DEPTH = "/camera/aligned_depth_to_color/image_raw"
INFO = "/camera/color/camera_info"
CAMERA_FRAME = "camera_color_optical_frame"
# Lower and upper corner, colour, label; the room itself is seen from inside.
BOXES = [((1.2, 0.5, 0.0), (1.8, 1.1, 0.7), (210, 30, 30), 1),
         ((1.2, -1.1, 0.0), (1.8, -0.5, 0.7), (30, 30, 210), 2)]
ROOM = ((-3.0, -3.0, 0.0), (3.0, 3.0, 2.5))
WALL_COLORS = [(200, 190, 170), (170, 190, 200), (120, 120, 110)]


def look_at(eye, target):
    """T_world_camera of an optical frame."""
    forward = np.subtract(target, eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = right, np.cross(forward, right), forward, eye
    return T


def pose_at(index):
    y = -0.6 + 0.04 * index
    return look_at((-1.6, y, 1.3), (1.5, 0.3 * y, 0.2))


def cross_box(origin, rays, lower, upper):
    """Ray parameters at which the rays enter and leave a box, and the axis of the face they leave by."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a = (np.array(lower) - origin) / rays
        b = (np.array(upper) - origin) / rays
    near, far = np.minimum(a, b), np.maximum(a, b)
    return near.max(axis=-1), far.min(axis=-1), far.argmin(axis=-1)


def render(T, width=WIDTH, height=HEIGHT, fx=FX, fy=FY, cx=CX, cy=CY):
    """Colour (H x W x 3), depth in metres, labels."""
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(u.shape)], axis=-1) @ T[:3, :3].T
    _, depth, axis = cross_box(T[:3, 3], rays, *ROOM)
    color = np.array(WALL_COLORS, np.uint8)[axis]
    hit = T[:3, 3] + depth[..., None] * rays
    # A pattern on the walls, so that images tell where they were taken.
    color[(np.floor(hit * 2.0).astype(int).sum(axis=-1) % 2) == 0] -= 40
    labels = np.zeros(u.shape, np.uint16)
    for lower, upper, box_color, label in BOXES:
        enter, leave, _ = cross_box(T[:3, 3], rays, lower, upper)
        is_hit = (enter > 0) & (enter < leave) & (enter < depth)
        depth = np.where(is_hit, enter, depth)
        color[is_hit], labels[is_hit] = box_color, label
    return color, depth, labels


def quaternion(R):
    """x y z w of a rotation."""
    w = np.sqrt(max(0.0, 1.0 + np.trace(R))) / 2.0
    if w > 1e-3:
        return np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 4 * w * w]) / (4 * w)
    x, y, z = (np.sqrt(max(0.0, (R[i, i] + 1.0) / 2.0)) for i in range(3))
    return np.array([x, np.copysign(y, R[0, 1]), np.copysign(z, R[0, 2]), 0.0])


def to_time(seconds):
    return genpy.Time(int(seconds), int(round((seconds - int(seconds)) * 1e9)))


def to_image(header, pixels, encoding):
    message = Image(header=header, height=pixels.shape[0], width=pixels.shape[1], encoding=encoding)
    message.step = pixels.strides[0]
    message.data = np.ascontiguousarray(pixels).tobytes()
    return message


def to_png(pixels):
    data = io.BytesIO()
    PIL.Image.fromarray(pixels).save(data, "PNG")
    return data.getvalue()


def to_compressed_depth(header, raw):
    return CompressedImage(header=header, format="16UC1; compressedDepth",
                           data=struct.pack("<iff", 0, 0.0, 0.0) + to_png(raw))


def to_compressed(header, color):
    return CompressedImage(header=header, format="rgb8; png compressed bgr8", data=to_png(color))


def fill_pose(position, orientation, T):
    position.x, position.y, position.z = T[:3, 3]
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion(T[:3, :3])


def to_transform(stamp, parent, child, T):
    message = TransformStamped(child_frame_id=child)
    message.header.stamp, message.header.frame_id = stamp, parent
    fill_pose(message.transform.translation, message.transform.rotation, T)
    return TFMessage(transforms=[message])


def to_camera_info(header, width=WIDTH, height=HEIGHT, distortion=()):
    message = CameraInfo(header=header, width=width, height=height, distortion_model="plumb_bob")
    message.D = list(distortion) or [0.0] * 5
    fx, fy = FX * width / WIDTH, FY * height / HEIGHT
    cx, cy = (CX + 0.5) * width / WIDTH - 0.5, (CY + 0.5) * height / HEIGHT - 0.5
    message.K = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
    message.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    message.P = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return message


def to_segmentation(header, labels):
    message = Segmentation(header=header, labels=to_image(header, labels, "16UC1"))
    message.embedding_size = 4
    message.embeddings = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]
    message.confidences = [0.9, 0.9]
    message.image_embedding = [0.0, 0.0, 1.0, 0.0]
    return message


class Recording:
    """A RealSense's bag; tests change what they want wrong by the hooks' arguments.

    stamp: index -> seconds of the colour image; depth_delay: index -> seconds that depth is later (None:
    no depth image); depth_units_per_m, depth_encoding; frame_id; info_at: indices with a camera_info; pose_at: with a
    pose; pose: 'tf', 'odometry', 'pose' or None; links: [(parent, child, T)] on /tf_static; T_pose_camera: the
    moving tf frame or pose is not the camera itself; compressed; depth_size; segmentation: indices.
    """

    def __init__(self, **changes):
        self.num_frames = NUM_FRAMES
        self.stamp = lambda index: 100.0 + 0.1 * index
        self.depth_delay = lambda index: 0.0
        self.depth_units_per_m, self.depth_encoding = 1000.0, "16UC1"
        self.frame_id = self.depth_frame_id = CAMERA_FRAME
        self.info_at = self.pose_at = range(NUM_FRAMES)
        self.pose, self.pose_topic, self.world_frame = "tf", "/odom", "world"
        self.moving_frame, self.T_moving_camera, self.links = CAMERA_FRAME, np.eye(4), []
        self.compressed = False
        self.depth_size = (WIDTH, HEIGHT)
        self.distortion = ()
        self.with_segmentation = True
        self.color_topic, self.depth_topic, self.info_topic = COLOR, DEPTH, INFO
        self.tf_namespace = ""
        self.frames = None  # indices that are written; None = all
        for name, value in changes.items():
            assert hasattr(self, name), name
            setattr(self, name, value)

    def write(self, path):
        with rosbag.Bag(str(path), "w") as bag:
            if self.links:
                for parent, child, T in self.links:
                    bag.write(self.tf_namespace + "/tf_static", to_transform(to_time(99.0), parent, child, T), to_time(99.0))
            for index in (self.frames if self.frames is not None else range(self.num_frames)):
                self.write_frame(bag, index)
        return path

    def write_frame(self, bag, index):
        recorded = to_time(100.0 + 0.1 * index)
        stamp = to_time(self.stamp(index))
        header = Image().header
        header.stamp, header.frame_id = stamp, self.frame_id
        T = pose_at(index)
        color, depth, labels = render(T)
        if index in self.pose_at:
            self.write_pose(bag, recorded, stamp, T @ np.linalg.inv(self.T_moving_camera))
        if index in self.info_at:
            bag.write(self.info_topic, to_camera_info(header, distortion=self.distortion), recorded)
        if self.compressed:
            bag.write(self.color_topic + "/compressed", to_compressed(header, color), recorded)
        else:
            bag.write(self.color_topic, to_image(header, color, "rgb8"), recorded)
        if self.depth_delay(index) is not None:
            self.write_depth(bag, index, recorded)
        if self.with_segmentation:
            bag.write("/segmentation", to_segmentation(header, labels), recorded)

    def write_depth(self, bag, index, recorded):
        width, height = self.depth_size
        scale = width / WIDTH
        _, depth, _ = render(pose_at(index), width, height, FX * scale, FY * scale,
                             (CX + 0.5) * scale - 0.5, (CY + 0.5) * scale - 0.5)
        header = Image().header
        header.stamp = to_time(self.stamp(index) + self.depth_delay(index))
        header.frame_id = self.depth_frame_id
        kind = np.float32 if self.depth_encoding == "32FC1" else np.uint16
        values = depth * self.depth_units_per_m
        raw = (values if kind is np.float32 else np.round(values)).astype(kind)
        if self.compressed:
            bag.write(self.depth_topic + "/compressedDepth", to_compressed_depth(header, raw), recorded)
        else:
            bag.write(self.depth_topic, to_image(header, raw, self.depth_encoding), recorded)

    def write_pose(self, bag, recorded, stamp, T):
        if self.pose == "tf":
            bag.write(self.tf_namespace + "/tf", to_transform(stamp, self.world_frame, self.moving_frame, T), recorded)
        elif self.pose == "odometry":
            message = Odometry(child_frame_id=self.moving_frame)
            message.header.stamp, message.header.frame_id = stamp, self.world_frame
            fill_pose(message.pose.pose.position, message.pose.pose.orientation, T)
            bag.write(self.pose_topic, message, recorded)
        elif self.pose == "pose":
            message = PoseStamped()
            message.header.stamp, message.header.frame_id = stamp, self.world_frame
            fill_pose(message.pose.position, message.pose.orientation, T)
            bag.write(self.pose_topic, message, recorded)


def trajectory_lines(inverted=False):
    """The walk in TUM's format."""
    recording = Recording()
    lines = ["# stamp tx ty tz qx qy qz qw"]
    for index in range(recording.num_frames):
        T = np.linalg.inv(pose_at(index)) if inverted else pose_at(index)
        numbers = [*T[:3, 3], *quaternion(T[:3, :3])]
        lines.append(f"{recording.stamp(index):.6f} " + " ".join(f"{n:.9f}" for n in numbers))
    return "\n".join(lines) + "\n"


TASKS = """tasks:
  - {name: take the red box, embedding: [1, 0, 0, 0]}
  - {name: take the blue box, embedding: [0, 1, 0, 0]}
"""
PLACE_TASKS = """tasks:
  - {name: room, embedding: [0, 0, 1, 0]}
"""
