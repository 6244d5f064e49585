"""A master and a node of a script's own: started, looked at, stopped."""
import os
import signal
import socket
import subprocess
import sys
import time
import xmlrpc.client

NODE = 'deformable_sim'
DEADLINE = 60.0  # s


def free_port():
    with socket.socket() as listener:
        listener.bind(('127.0.0.1', 0))
        return listener.getsockname()[1]


def start_master(port=None):
    """On a free port unless one is given; what is started from here on talks to it."""
    port = port or free_port()
    os.environ['ROS_MASTER_URI'] = 'http://127.0.0.1:%d' % port
    os.environ['ROS_IP'] = '127.0.0.1'
    master = subprocess.Popen(['rosmaster', '--core', '-p', str(port)], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
    end = time.monotonic() + DEADLINE
    while True:
        try:
            xmlrpc.client.ServerProxy(os.environ['ROS_MASTER_URI']).getPid('/' + NODE)
            return master
        except OSError:
            if time.monotonic() > end or master.poll() is not None:
                sys.exit('no master could be started')
            time.sleep(0.05)


def start_node(executable, scene, log, *parameters, environment=None):
    return subprocess.Popen([executable, '__name:=' + NODE, '_scene:=' + scene, *parameters], stdout=log,
                            stderr=subprocess.STDOUT, env=environment)


def resident(pid):
    """MiB."""
    with open('/proc/%d/status' % pid, encoding='ascii') as stream:
        return next(int(line.split()[1]) / 1024.0 for line in stream if line.startswith('VmRSS'))


def allocated(pid):
    """MiB that it has for itself, in memory or swapped: pages of files come and go with what else the machine does."""
    with open('/proc/%d/status' % pid, encoding='ascii') as stream:
        return sum(int(line.split()[1]) / 1024.0 for line in stream if line.startswith(('RssAnon', 'VmSwap')))


def descriptors(pid):
    return len(os.listdir('/proc/%d/fd' % pid))


def stop(process, how=signal.SIGINT, seconds=DEADLINE):
    """Its exit code; None when it had to be killed."""
    process.send_signal(how)
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return None
