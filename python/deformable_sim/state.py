"""The state of a body, and clouds of points, as numpy arrays."""

import dataclasses
from typing import Any, Optional

import numpy
import rospy
from sensor_msgs.msg import PointCloud2, PointField

from deformable_sim.msg import BodyState

_TYPES = {PointField.INT8: 'i1', PointField.UINT8: 'u1', PointField.INT16: 'i2', PointField.UINT16: 'u2',
          PointField.INT32: 'i4', PointField.UINT32: 'u4', PointField.FLOAT32: 'f4', PointField.FLOAT64: 'f8'}


@dataclasses.dataclass
class State:
    """Every node of one body, exact.

    positions, velocities   n x 3, m and m/s, float64.
    segments                m x 6 of a rod with twist (deformable_sim/BodyState), else 0 x 6.
    stamp                   of all messages of this step; with clock: on_demand the simulated time.
    """

    body: str
    positions: numpy.ndarray
    velocities: numpy.ndarray
    segments: numpy.ndarray
    stamp: rospy.Time
    frame_id: str = ''
    kind: int = BodyState.CLOTH
    kinetic_energy: float = 0.0
    elastic_energy: float = 0.0
    potential_energy: float = 0.0
    max_strain: float = 0.0
    min_strain: float = 0.0
    contacts: int = 0

    @property
    def center(self) -> numpy.ndarray:
        """Mean position of the nodes, m."""
        return self.positions.mean(axis=0)

    def nearest_node(self, point: Any) -> int:
        return int(numpy.argmin(numpy.linalg.norm(self.positions - numpy.asarray(point, dtype=float), axis=1)))


def _rows(values: Any, width: int) -> numpy.ndarray:
    return numpy.array(values, dtype=numpy.float64).reshape(-1, width)


def state_from_message(message: BodyState) -> State:
    return State(body=message.body, positions=_rows(message.positions, 3), velocities=_rows(message.velocities, 3),
                 segments=_rows(message.segments, 6), stamp=message.header.stamp, frame_id=message.header.frame_id,
                 kind=message.kind, kinetic_energy=message.kinetic_energy, elastic_energy=message.elastic_energy,
                 potential_energy=message.potential_energy, max_strain=message.max_strain,
                 min_strain=message.min_strain, contacts=message.contacts)


def state_to_message(body: str, positions: Any, velocities: Optional[Any] = None,
                     segments: Optional[Any] = None) -> BodyState:
    """Without velocities the body is at rest. positions and velocities must be n x 3: ValueError."""
    positions = numpy.asarray(positions, dtype=numpy.float64)
    velocities = numpy.zeros_like(positions) if velocities is None else numpy.asarray(velocities, dtype=numpy.float64)
    for name, values in (('positions', positions), ('velocities', velocities)):
        if values.ndim != 2 or values.shape[1] != 3:
            raise ValueError('%s: an array of shape %s; n x 3 is needed' % (name, values.shape))
    message = BodyState(body=body, positions=positions.ravel().tolist(), velocities=velocities.ravel().tolist())
    if segments is not None:
        message.segments = numpy.asarray(segments, dtype=numpy.float64).ravel().tolist()
    return message


def cloud_array(cloud: PointCloud2) -> numpy.ndarray:
    """A height x width structured array with the cloud's fields: cloud_array(c)['x'] ..."""
    order = '>' if cloud.is_bigendian else '<'
    kind = numpy.dtype({'names': [field.name for field in cloud.fields],
                        'formats': [order + _TYPES[field.datatype] for field in cloud.fields],
                        'offsets': [field.offset for field in cloud.fields], 'itemsize': cloud.point_step})
    rows = numpy.frombuffer(cloud.data, dtype=numpy.uint8).reshape(cloud.height, cloud.row_step)
    points = numpy.ascontiguousarray(rows[:, :cloud.width * cloud.point_step])
    return points.view(kind).reshape(cloud.height, cloud.width)
