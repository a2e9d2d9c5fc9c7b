# SPDX-License-Identifier: BSD-3-Clause
"""launch/clio_dataset.launch, live, on a small bag with the topics of the bags that the paper's authors published."""
import json
import os
import pathlib
import sys
import tempfile
import unittest

import yaml

from ros_session import SOURCE, Session, wait_until

sys.path.insert(0, str(SOURCE / "test" / "support"))
import box_room  # noqa: E402

SAVE_MAP = "/task_scene_graph/scene_graph/save_map"


class ClioDataset(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(os.path.realpath(self.temporary.name))
        self.session = Session(self.folder)
        self.addCleanup(self.session.close)
        preset = yaml.safe_load((SOURCE / "config" / "presets" / "clio_dataset.yaml").read_text())
        self.input = preset["input"]

    def write_bag(self, **changes):
        given = {"color_topic": self.input["color_topic"], "depth_topic": self.input["depth_topic"], "info_at": [],
                 "frame_id": self.input["camera_frame"], "depth_frame_id": self.input["camera_frame"],
                 "moving_frame": self.input["camera_frame"]}
        return box_room.Recording(**{**given, **changes}).write(self.folder / "walk.bag")

    def play(self, bag):
        """The objects' tasks in the map after the bag was played."""
        intrinsics = [box_room.FX, box_room.FY, box_room.CX, box_room.CY, box_room.WIDTH, box_room.HEIGHT]
        config = self.folder / "my.yaml"
        config.write_text(yaml.safe_dump({"input": {**self.input, "intrinsics": ", ".join(map(str, intrinsics))}}))
        tasks, places = self.folder / "tasks.yaml", self.folder / "places.yaml"
        tasks.write_text(box_room.TASKS)
        places.write_text(box_room.PLACE_TASKS)
        launched = self.session.start(
            ["roslaunch", "task_scene_graph", "clio_dataset.launch", "bag:=%s" % bag, "object_tasks:=%s" % tasks,
             "place_tasks:=%s" % places, "config:=%s" % config, "output:=%s" % (self.folder / "map"), "rviz:=false",
             "rate:=1", "delay:=15"], "launch")
        wait_until(lambda: "[player-" in launched.output() and "finished cleanly" in launched.output(),
                   "the end of the bag")
        saved = self.session.run("rosservice", "call", SAVE_MAP)
        self.assertIn("success: True", saved.stdout, saved.stderr + launched.output())
        summary = json.loads((self.folder / "map" / "summary.json").read_text())
        return sorted(row["task"] for room in summary["rooms"] for row in room["objects"])

    def test_bag_with_the_authors_odometry_yields_the_objects(self):
        bag = self.write_bag(pose="odometry", pose_topic=self.input["pose_topic"])
        self.assertEqual(self.play(bag), ["take the blue box", "take the red box"])

    def test_bag_with_poses_in_tf_yields_the_objects(self):
        self.input["pose_topic"] = ""
        self.assertEqual(self.play(self.write_bag()), ["take the blue box", "take the red box"])


if __name__ == "__main__":
    unittest.main()
