"""Which nodes a grasp takes, as deformable_sim/GraspSelection."""

import operator
from typing import Any, Iterable, List, Sequence

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion

from deformable_sim.msg import GraspSelection

IDENTITY = (0.0, 0.0, 0.0, 1.0)  # x y z w


def numbers(values: Any, count: int, name: str) -> List[float]:
    """`count` floats; anything else is a ValueError."""
    try:
        result = [float(value) for value in values]
    except TypeError:
        result = []
    if len(result) != count:
        raise ValueError('%s: %r; %d numbers are needed' % (name, values, count))
    return result


def pose_stamped(position: Sequence[float], orientation: Sequence[float] = IDENTITY, frame_id: str = '') -> PoseStamped:
    """position in m, orientation as quaternion x y z w; an empty frame is the node's ~frame_id."""
    stamped = PoseStamped(pose=to_pose(position, orientation))
    stamped.header.frame_id = frame_id
    return stamped


def to_pose(position: Sequence[float], orientation: Sequence[float] = IDENTITY) -> Pose:
    """position in m, orientation as quaternion x y z w; ValueError when they are not 3 and 4 numbers."""
    return Pose(Point(*numbers(position, 3, 'position')), Quaternion(*numbers(orientation, 4, 'orientation')))


def nearest(point: Sequence[float], radius: float = 0.02, frame_id: str = '') -> GraspSelection:
    """The node nearest to a point, at most `radius` (m) away."""
    return GraspSelection(method=GraspSelection.NEAREST, pose=pose_stamped(point, frame_id=frame_id), radius=radius)


def all_within(point: Sequence[float], radius: float, frame_id: str = '') -> GraspSelection:
    """All nodes within `radius` (m) of a point."""
    return GraspSelection(method=GraspSelection.RADIUS, pose=pose_stamped(point, frame_id=frame_id), radius=radius)


def in_box(center: Sequence[float], size: Sequence[float], orientation: Sequence[float] = IDENTITY,
           frame_id: str = '') -> GraspSelection:
    """All nodes in a box; size: full edge lengths, m."""
    selection = GraspSelection(method=GraspSelection.BOX, pose=pose_stamped(center, orientation, frame_id))
    selection.size.x, selection.size.y, selection.size.z = numbers(size, 3, 'size')
    return selection


def nodes(indices: Iterable[int]) -> GraspSelection:
    """Nodes by their numbers, from 0; TypeError for what is no integer, ValueError below 0."""
    indices = [operator.index(index) for index in indices]
    if min(indices, default=0) < 0:
        raise ValueError('nodes: %d; they are counted from 0' % min(indices))
    return GraspSelection(method=GraspSelection.NODES, nodes=indices)


def feature(name: str) -> GraspSelection:
    """A feature of the body: corner_0, edge_2, end_1, center, face_z0 ..."""
    return GraspSelection(method=GraspSelection.FEATURE, feature=name)
