"""A topic in lock-step: the message of one step, not the latest one that happens to be there."""

import collections
import threading
import time
from typing import Any, Callable, Deque, Optional

import rospy

from deformable_sim.errors import TimedOut, check_interrupted

_KEPT = 64  # messages
_SLICE = 0.1  # s, between looks whether the program is to stop


class Listener:
    """Keeps the last messages of a topic whose messages have a header (all of the node's but ~markers and /tf).

    rospy.init_node() must have been called.
    """

    def __init__(self, topic: str, kind: Any) -> None:
        if 'header' not in kind.__slots__:
            raise TypeError('%s: messages of type %s have no header, and belong to no step' % (topic, kind._type))
        self.topic = topic
        self._messages: Deque[Any] = collections.deque(maxlen=_KEPT)
        self._arrived = threading.Condition()
        self._subscriber = rospy.Subscriber(topic, kind, self._keep, queue_size=_KEPT, tcp_nodelay=True)

    def at(self, stamp: rospy.Time, timeout: float) -> Any:
        """The newest message with that stamp; waits for it, at most `timeout` s (wall): TimedOut."""
        return self.wait(lambda message: message.header.stamp == stamp, timeout, 'of %.9g s' % stamp.to_sec())

    def wait(self, condition: Callable[[Any], bool], timeout: float, what: str = '') -> Any:
        """The newest message that meets the condition; waits for it, at most `timeout` s (wall): TimedOut."""
        end = time.monotonic() + timeout
        with self._arrived:
            while True:
                found = self._find(condition)
                if found is not None:
                    return found
                left = end - time.monotonic()
                if left <= 0.0:
                    raise TimedOut('%s: no message %s within %g s' % (self.topic, what, timeout))
                check_interrupted(self.topic)
                self._arrived.wait(min(left, _SLICE))

    def clear(self) -> None:
        """Forgets what has come; before time is set back."""
        with self._arrived:
            self._messages.clear()

    def close(self) -> None:
        self._subscriber.unregister()

    def _find(self, condition: Callable[[Any], bool]) -> Optional[Any]:
        return next((message for message in reversed(self._messages) if condition(message)), None)

    def _keep(self, message: Any) -> None:
        with self._arrived:
            self._messages.append(message)
            self._arrived.notify_all()
