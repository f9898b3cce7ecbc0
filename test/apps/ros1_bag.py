#!/usr/bin/python3
"""Writes drive.bag, a ROS 1 bag: ros1_bag.py FOLDER. A scanner 0.5 m above a floor drives 1.1 m along x."""
import os
import struct
import sys

import genpy
import rosbag
from genpy.dynamic import generate_dynamic

RULE = "=" * 80 + "\nMSG: "
HEADER = RULE + "std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
CLOUD = ("std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
         "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n" + HEADER + RULE +
         "sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\n"
         "uint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n")
TF = ("geometry_msgs/TransformStamped[] transforms\n" + RULE + "geometry_msgs/TransformStamped\nstd_msgs/Header header\n"
      "string child_frame_id\ngeometry_msgs/Transform transform\n" + HEADER + RULE + "geometry_msgs/Transform\n"
      "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n" + RULE +
      "geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" + RULE +
      "geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n")
of_cloud = generate_dynamic("sensor_msgs/PointCloud2", CLOUD)
of_tf = generate_dynamic("tf2_msgs/TFMessage", TF)


def transform(stamp, x_m):
    t = of_tf["geometry_msgs/TransformStamped"]()
    t.header.stamp, t.header.frame_id, t.child_frame_id = stamp, "map", "base_link"
    t.transform.translation.x, t.transform.rotation.w = x_m, 1.0
    return of_tf["tf2_msgs/TFMessage"](transforms=[t])


def cloud(stamp):
    side = range(-30, 31)
    points = [(0.1 * i + 0.02, 0.1 * k + 0.02, -0.5) for i in side for k in side]
    field = of_cloud["sensor_msgs/PointField"]
    message = of_cloud["sensor_msgs/PointCloud2"](
        height=1, width=len(points), point_step=12, row_step=12 * len(points), is_dense=True)
    message.header.stamp, message.header.frame_id = stamp, "lidar"
    message.fields = [field(name, 4 * i, field.FLOAT32, 1) for i, name in enumerate("xyz")]
    message.data = b"".join(struct.pack("<3f", *p) for p in points)
    return message


with rosbag.Bag(os.path.join(sys.argv[1], "drive.bag"), "w") as bag:
    for i in range(12):
        now = genpy.Time(1700000000, 100000000 * i) if i < 10 else genpy.Time(1700000001, 100000000 * (i - 10))
        bag.write("/tf", transform(now, 0.1 * i), now)
        bag.write("/points", cloud(now), now)
