"""What a call can end with instead of an answer."""

from typing import Optional

import rospy

from deformable_sim.msg import Status

CODE_NAMES = {getattr(Status, name): name for name in (
    'OK', 'INVALID_ARGUMENT', 'NOT_FOUND', 'ALREADY_EXISTS', 'UNAVAILABLE', 'TIMEOUT', 'OUT_OF_RANGE', 'INTERNAL')}


class SimulationError(Exception):
    """Any of those below."""


class Refused(SimulationError):
    """The node refused a request, and nothing has changed.

    service    full name of the service.
    code       of deformable_sim/Status; None for the std_srvs services ~pause, ~reset and ~describe, which have none.
    message    what was wrong and what is allowed.
    """

    def __init__(self, service: str, code: Optional[int], message: str) -> None:
        super().__init__(service, code, message)
        self.service = service
        self.code = code
        self.message = message

    @property
    def code_name(self) -> str:
        return '' if self.code is None else CODE_NAMES.get(self.code, str(self.code))

    def __str__(self) -> str:
        code = ' (%s)' % self.code_name if self.code is not None else ''
        return '%s refused%s: %s' % (self.service, code, self.message)


class Unreachable(SimulationError):
    """No master, no such node, or the node went away during the call: whether the request was done is not known then."""


class TimedOut(SimulationError):
    """No answer within the timeout. The node may still be at it."""


class Interrupted(SimulationError):
    """This program was told to stop (Ctrl-C, rosnode kill) during the call. The node may still be at it."""


def check_interrupted(what: str) -> None:
    """To be called while waiting: rospy turns Ctrl-C into a flag, and nothing else would end the wait."""
    if rospy.is_shutdown():
        raise Interrupted('%s: rospy was shut down during the call' % what)
