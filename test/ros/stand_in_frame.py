#!/usr/bin/env python3
"""A tf frame in the place of a robot, for snippets of the documentation: `stand_in_frame.py NAME X Y Z [RISE]`.

In the world frame; it goes up by RISE metres within two seconds.
"""

import sys

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped


def main():
    name, x, y, z, rise = sys.argv[1], *(float(word) for word in (sys.argv[2:] + ['0'])[:4])
    rospy.init_node('stand_in_' + name)
    broadcaster = tf2_ros.TransformBroadcaster()
    rate = rospy.Rate(50)
    begin = rospy.Time.now()
    while not rospy.is_shutdown():
        frame = TransformStamped()
        frame.header.stamp = rospy.Time.now()
        frame.header.frame_id, frame.child_frame_id = 'world', name
        frame.transform.translation.x, frame.transform.translation.y = x, y
        frame.transform.translation.z = z + rise * min(1.0, (rospy.Time.now() - begin).to_sec() / 2.0)
        frame.transform.rotation.w = 1.0
        broadcaster.sendTransform(frame)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
