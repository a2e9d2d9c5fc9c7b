# SPDX-License-Identifier: BSD-3-Clause
"""The scene graph put together from its numbered changes (SceneGraphChanges.msg says how)."""
import threading

import rospy
from task_scene_graph.msg import SceneGraph, SceneGraphChanges


def apply_changes(changes, graph):
    """The graph (SceneGraph) after changes; the one given stays as it is, and shares what did not change.

    ValueError if the changes do not fit it. O(graph + changes).
    """
    after = SceneGraph(header=changes.header)
    after.object_tasks = changes.object_tasks if changes.has_tasks else graph.object_tasks
    after.place_tasks = changes.place_tasks if changes.has_tasks else graph.place_tasks
    for kind in ("objects", "places", "regions"):
        setattr(after, kind, _merge(kind, getattr(graph, kind), getattr(changes, kind),
                                    getattr(changes, "removed_" + kind), lambda node: node.id))
    for kind in ("place_edges", "region_edges"):
        ends = getattr(changes, "removed_" + kind)
        if len(ends) % 2:
            raise ValueError("%s to be removed have an odd number of ends" % kind)
        setattr(after, kind, _merge(kind, getattr(graph, kind), getattr(changes, kind),
                                    list(zip(ends[::2], ends[1::2])), lambda edge: (edge.a, edge.b)))
    return after


def _merge(kind, before, changed, removed, key):
    items = {key(item): item for item in before}
    if len({key(item) for item in changed}) != len(changed) or len(set(removed)) != len(removed):
        raise ValueError("%s: something is there twice" % kind)
    missing = [name for name in removed if name not in items]
    if missing:
        raise ValueError("%s: %s is removed, but is not there" % (kind, missing[0]))
    for name in removed:
        del items[name]
    items.update((key(item), item) for item in changed)
    return [items[name] for name in sorted(items)]


class SceneGraphReader:
    """Takes changes one after the other; `graph` is None until the whole has come, and again once a
    message was lost."""

    APPLIED, KNOWN, WAITING, LOST = "applied", "known", "waiting", "lost"

    def __init__(self):
        self.graph = None
        self.sequence = 0

    def apply(self, changes):
        """APPLIED; KNOWN: not later than what is here; WAITING: for the whole; LOST: subscribe anew."""
        if not changes.is_whole:
            if self.graph is None:
                return self.WAITING
            if changes.sequence <= self.sequence:
                return self.KNOWN
        is_next = changes.is_whole or changes.sequence == self.sequence + 1
        before = SceneGraph() if changes.is_whole else self.graph
        self.graph = None
        if not is_next:
            return self.LOST
        try:
            self.graph = apply_changes(changes, before)
        except ValueError:
            return self.LOST
        self.sequence = changes.sequence
        return self.APPLIED


class SceneGraphFollower:
    """Follows the scene graph of a running chain, and subscribes anew where a message was lost.

    topic: that of the changes.
    on_change: called with the new graph and the changes, from rospy's thread.
    """

    def __init__(self, topic="/task_scene_graph/scene_graph_changes", on_change=None):
        self._topic = topic
        self._on_change = on_change
        self._reader = SceneGraphReader()
        self._lock = threading.Lock()  # guards the reader
        self._subscriber = None
        self._subscribe()

    @property
    def graph(self):
        """The newest SceneGraph; None while it is not known."""
        with self._lock:
            return self._reader.graph

    def close(self):
        self._subscriber.unregister()

    def _subscribe(self):
        self._subscriber = rospy.Subscriber(self._topic, SceneGraphChanges, self._take, queue_size=None)

    def _take(self, changes):
        with self._lock:
            status = self._reader.apply(changes)
            graph = self._reader.graph
        if status == SceneGraphReader.APPLIED and self._on_change is not None:
            self._on_change(graph, changes)
        if status == SceneGraphReader.LOST:
            rospy.logwarn("%s: a message was lost after number %d; subscribing anew", self._topic,
                          self._reader.sequence)
            self._subscriber.unregister()
            self._subscribe()
