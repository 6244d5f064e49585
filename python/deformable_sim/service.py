"""One ROS service over one kept connection, with a timeout.

rospy.ServiceProxy waits for ever for a node that hangs, and looks the service up and connects anew for every call.
"""

import http.client
import io
import select
import socket
import struct
import threading
import time
import urllib.parse
import xmlrpc.client
from typing import Any, Optional

import genpy
import numpy
import rosgraph
import rosgraph.network
import rospy

from deformable_sim.errors import TimedOut, Unreachable, check_interrupted

_POLL = 0.05  # s, between looks for a node that is not there yet
_SHORTEST = 0.2  # s, a single look
_SLICE = 0.1  # s, between looks whether the program is to stop


class _Deadline:
    """What is left of a call's timeout (s, wall)."""

    def __init__(self, seconds: float, what: str) -> None:
        self.seconds = seconds
        self.end = time.monotonic() + seconds
        self.what = what

    def left(self) -> float:
        left = self.end - time.monotonic()
        if left <= 0.0:
            raise TimedOut('%s: no answer within %g s' % (self.what, self.seconds))
        return left


class _MasterTransport(xmlrpc.client.Transport):
    """XML-RPC that gives up."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


def service_address(name: str, timeout: float) -> Any:
    """(host, port) that the master knows for a service; None when it knows none. Unreachable without a master."""
    uri = rosgraph.get_master_uri()
    with xmlrpc.client.ServerProxy(uri, transport=_MasterTransport(timeout)) as master:
        try:
            answer: Any = master.lookupService(rospy.get_name(), name)
        except socket.timeout:
            raise TimedOut('%s: the master at %s does not answer within %g s' % (name, uri, timeout)) from None
        except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
            raise Unreachable('%s: no ROS master at %s (%s)' % (name, uri, error)) from None
    code, _, address = answer
    if code != 1:
        return None
    parsed = urllib.parse.urlparse(address)
    return parsed.hostname, parsed.port


def wait_for_master(timeout: float) -> None:
    """Until a ROS master answers; Unreachable after `timeout` s (wall)."""
    end = time.monotonic() + timeout
    while True:
        try:
            service_address('/rosout/get_loggers', max(_SHORTEST, end - time.monotonic()))
            return
        except (Unreachable, TimedOut):
            if time.monotonic() >= end:
                raise
        check_interrupted('the ROS master')
        time.sleep(_POLL)


class Service:
    """Calls of one service, one at a time. Arrays in answers are numpy arrays.

    name       full name.
    kind       generated class, for example deformable_sim.srv.Step.
    """

    def __init__(self, name: str, kind: Any) -> None:
        self.name = name
        self._kind = kind
        self._socket: Optional[socket.socket] = None
        self._lock = threading.Lock()

    def __call__(self, request: Any, timeout: float) -> Any:
        """The answer. Unreachable, TimedOut; a request with a value that its field cannot hold is not sent: ValueError."""
        buffer = io.BytesIO()
        try:
            request.serialize(buffer)
        except (genpy.SerializationError, AttributeError, TypeError) as error:
            raise ValueError('%s: %s' % (self.name, str(error).splitlines()[0])) from None
        payload = buffer.getvalue()
        deadline = _Deadline(timeout, self.name)
        with self._lock:
            try:
                peer = self._connection(deadline)
                peer.settimeout(deadline.left())
                peer.sendall(struct.pack('<I', len(payload)) + payload)
                done, length = struct.unpack('<BI', self._receive(peer, 5, deadline))
                answer = self._receive(peer, length, deadline)
            except socket.timeout:
                self.close()
                raise TimedOut('%s: no answer within %g s' % (self.name, timeout)) from None
            except OSError as error:
                self.close()
                raise Unreachable('%s: the node went away during the call (%s)' % (self.name, error)) from None
            except BaseException:
                # A late answer must not be taken for that of the next call.
                self.close()
                raise
        if not done:
            raise Unreachable('%s: %s' % (self.name, answer.decode('utf-8', 'replace')))
        response = self._kind._response_class()
        response.deserialize_numpy(answer, numpy)
        return response

    def wait(self, timeout: float) -> None:
        """Until a node that offers the service takes the connection; Unreachable after `timeout` s (wall)."""
        end = time.monotonic() + timeout
        while True:
            try:
                with self._lock:
                    self._connection(_Deadline(max(_SHORTEST, end - time.monotonic()), self.name))
                return
            except socket.timeout:
                raise TimedOut('%s: the node does not answer within %g s' % (self.name, timeout)) from None
            except (OSError, Unreachable) as error:
                # A node that was killed stays registered with the master until another one takes its name.
                if time.monotonic() >= end:
                    raise Unreachable('%s (waited %g s); start one, for example with\n  roslaunch deformable_sim '
                                      'simulation.launch scene:=towel_on_table clock:=on_demand' % (error, timeout)) from None
            check_interrupted(self.name)
            time.sleep(_POLL)

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _connection(self, deadline: _Deadline) -> socket.socket:
        # Nothing is sent unasked: what can be read from an idle connection is its end.
        if self._socket is not None and select.select([self._socket], [], [], 0)[0]:
            self.close()
        if self._socket is None:
            self._socket = self._connect(deadline)
        return self._socket

    def _connect(self, deadline: _Deadline) -> socket.socket:
        address = service_address(self.name, deadline.left())
        if address is None:
            raise Unreachable('no node offers %s' % self.name)
        try:
            peer = socket.create_connection(address, deadline.left())
        except socket.timeout:
            raise
        except OSError as error:
            raise Unreachable('%s: the node at %s:%d is gone (%s)' % (self.name, address[0], address[1], error)) from None
        try:
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            rosgraph.network.write_ros_handshake_header(peer, {
                'callerid': rospy.get_name(), 'service': self.name, 'md5sum': self._kind._md5sum,
                'type': self._kind._type, 'persistent': '1'})
            length, = struct.unpack('<I', self._receive(peer, 4, deadline))
            header = rosgraph.network.decode_ros_handshake_header(struct.pack('<I', length) +
                                                                  self._receive(peer, length, deadline))
        except rosgraph.network.ROSHandshakeException as error:
            peer.close()
            raise Unreachable('%s: what answers at %s:%d is no ROS service (%s)' % (self.name, *address, error)) from None
        except BaseException:
            peer.close()
            raise
        if 'error' in header:
            peer.close()
            raise Unreachable('%s: %s' % (self.name, header['error']))
        return peer

    @staticmethod
    def _receive(peer: socket.socket, length: int, deadline: _Deadline) -> bytearray:
        data = bytearray(length)
        view = memoryview(data)
        while view:
            peer.settimeout(min(deadline.left(), _SLICE))
            try:
                count = peer.recv_into(view)
            except socket.timeout:
                check_interrupted(deadline.what)
                continue
            if count == 0:
                raise OSError('connection closed')
            view = view[count:]
        return data
