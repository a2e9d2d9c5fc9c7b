# SPDX-License-Identifier: BSD-3-Clause
"""The Python package puts the scene graph together from its changes."""
import copy
import random
import unittest

from task_scene_graph.msg import Place, PlaceEdge, Region, RegionEdge, SceneGraph, SceneGraphChanges, SceneObject
from task_scene_graph_client import SceneGraphReader, apply_changes

NODES = {"objects": SceneObject, "places": Place, "regions": Region}
EDGES = {"place_edges": PlaceEdge, "region_edges": RegionEdge}


def key_of(item):
    return (item.a, item.b) if hasattr(item, "a") else item.id


class World:
    """A graph in which things come, go and change at random, and the changes that say so."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.graph = SceneGraph()
        self.sequence = 0

    def change(self):
        self.sequence += 1
        changes = SceneGraphChanges(sequence=self.sequence)
        changes.header.stamp.secs = self.graph.header.stamp.secs + 1
        if self.random.random() < 0.2:
            changes.has_tasks, changes.object_tasks = True, ["task %d" % self.sequence]
            self.graph.object_tasks, self.graph.place_tasks = changes.object_tasks, []
        for kind, message in list(NODES.items()) + list(EDGES.items()):
            self._change_items(kind, message, changes)
        self.graph.header.stamp.secs += 1
        return changes

    def _change_items(self, kind, message, changes):
        items = {key_of(item): item for item in getattr(self.graph, kind)}
        for name in sorted(items):
            if self.random.random() < 0.2:
                del items[name]
                getattr(changes, "removed_" + kind).extend(name if isinstance(name, tuple) else [name])
        for _ in range(self.random.randrange(4)):
            item = message()
            if kind in NODES:
                item.id = self.random.randrange(1, 40)
            else:
                item.a = self.random.randrange(1, 6)
                item.b = item.a + self.random.randrange(1, 6)
            self._set_number(item)
            name = key_of(item)
            removed = getattr(changes, "removed_" + kind)
            names = list(zip(removed[::2], removed[1::2])) if kind in EDGES else removed
            if name in names or name in [key_of(other) for other in getattr(changes, kind)]:
                continue
            items[name] = item
            getattr(changes, kind).append(item)
        setattr(self.graph, kind, [items[name] for name in sorted(items)])

    def _set_number(self, item):
        number = self.random.randrange(9)
        for field in ("score", "clearance", "passage"):
            if hasattr(item, field):
                setattr(item, field, number)
        if isinstance(item, Place):
            item.position = type(item.position)(number, 0, 0)


def make_whole(world):
    whole = SceneGraphChanges(sequence=world.sequence, is_whole=True, has_tasks=True, header=world.graph.header)
    for field in ("object_tasks", "place_tasks", *NODES, *EDGES):
        setattr(whole, field, getattr(world.graph, field))
    return whole


class Changes(unittest.TestCase):
    def test_applied_one_after_the_other_they_give_the_whole_graph(self):
        for seed in range(30):
            world, reader = World(seed), SceneGraphReader()
            self.assertEqual(reader.apply(make_whole(world)), reader.APPLIED)
            for _ in range(40):
                self.assertEqual(reader.apply(world.change()), reader.APPLIED)
                self.assertEqual(reader.graph, world.graph)

    def test_a_lost_message_is_noticed_and_the_whole_graph_mends_it(self):
        world, reader = World(1), SceneGraphReader()
        self.assertEqual(reader.apply(world.change()), reader.WAITING)
        self.assertEqual(reader.apply(make_whole(world)), reader.APPLIED)
        self.assertEqual(reader.apply(SceneGraphChanges(sequence=1)), reader.KNOWN)
        world.change()
        self.assertEqual(reader.apply(world.change()), reader.LOST)
        self.assertIsNone(reader.graph)
        self.assertEqual(reader.apply(world.change()), reader.WAITING)
        self.assertEqual(reader.apply(make_whole(world)), reader.APPLIED)
        self.assertEqual(reader.graph, world.graph)

    def test_changes_that_do_not_fit_are_refused_and_change_nothing(self):
        world = World(2)
        for _ in range(10):
            world.change()
        before = copy.deepcopy(world.graph)
        place = world.graph.places[0]
        for wrong in (SceneGraphChanges(removed_places=[999]), SceneGraphChanges(places=[place, place]),
                      SceneGraphChanges(removed_place_edges=[1, 2, 3])):
            with self.assertRaises(ValueError):
                apply_changes(wrong, world.graph)
        self.assertEqual(world.graph, before)


if __name__ == "__main__":
    unittest.main()
