#!/usr/bin/env python3
"""Subscribes to every topic of the master there is, and takes SECONDS over each message: soak_listener.py SECONDS."""
import sys
import time

import rospy

LOOK = 0.5  # s between looks for new topics


def main():
    seconds = float(sys.argv[1])
    rospy.init_node('listener', anonymous=True, disable_signals=True, log_level=rospy.FATAL)
    known = set()
    while True:
        try:
            topics = {name for name, _ in rospy.get_published_topics()} - {'/rosout', '/rosout_agg'}
        except OSError:
            topics = set()  # no master just now
        for topic in topics - known:
            rospy.Subscriber(topic, rospy.AnyMsg, lambda _: time.sleep(seconds))
        known |= topics
        time.sleep(LOOK)


if __name__ == '__main__':
    main()
