#!/usr/bin/env python3
"""Writes small ROS 2 bags: make_bags.py FOLDER NAME...

A second hand at the formats, written from their documents alone (CDR of the OMG, mcap.dev/spec, the tables of rosbag2), so
that the reader is not tested against its own idea of them. What is in the log says log(); test/import/bag.cpp expects it.
"""
import math
import os
import sqlite3
import struct
import subprocess
import sys
import zlib

START_S = 1_700_000_000
NS = 1_000_000_000
INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64, INT64, UINT64 = range(1, 11)
CODES = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d", 9: "q", 10: "Q"}
CLOUD, TF = "sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage"
ODOMETRY, POSE = "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped"
POSE_COV, IMU = "geometry_msgs/msg/PoseWithCovarianceStamped", "sensor_msgs/msg/Imu"
XYZ = [("x", 0, FLOAT32), ("y", 4, FLOAT32), ("z", 8, FLOAT32)]


class Cdr:
    """Plain CDR: numbers lie at multiples of their size after the four bytes of encapsulation."""

    def __init__(self, order="<"):
        self.order, self.out = order, bytearray()

    def put(self, code, *values):
        size = struct.calcsize(code)
        for value in values:
            self.out += b"\0" * (-len(self.out) % size) + struct.pack(self.order + code, value)
        return self

    def text(self, text):
        data = text.encode() + b"\0"
        self.put("I", len(data))
        self.out += data
        return self

    def blob(self, data):
        self.put("I", len(data))
        self.out += data
        return self

    def header(self, stamp_ns, frame):
        return self.put("i", stamp_ns // NS).put("I", stamp_ns % NS).text(frame)

    def pose(self, x, y, z, yaw):
        return self.put("d", x, y, z, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2))

    def bytes(self):
        return (b"\0\1\0\0" if self.order == "<" else b"\0\0\0\0") + bytes(self.out)


def stamp(seconds):
    return START_S * NS + round(seconds * NS)


def cloud(stamp_ns, frame, fields, step, points, big=False, height=1, pad=0):
    """`fields`: (name, offset, type); `points`: a value a field each; `pad`: bytes after each row."""
    cdr = Cdr().header(stamp_ns, frame)
    width = len(points) // height
    cdr.put("I", height, width, len(fields))
    for name, offset, kind in fields:
        cdr.text(name).put("I", offset).put("B", kind).put("I", 1)
    data = bytearray()
    for row in range(height):
        for values in points[row * width : (row + 1) * width]:
            point = bytearray(b"\xab" * step)
            for (_, offset, kind), value in zip(fields, values):
                struct.pack_into((">" if big else "<") + CODES[kind], point, offset, value)
            data += point
        data += b"\xcd" * pad
    cdr.put("B", big).put("I", step, step * width + pad).blob(bytes(data)).put("B", 0)
    return cdr.bytes()


def transforms(*links):
    """`links`: (stamp, parent, child, x, y, z, yaw)."""
    cdr = Cdr().put("I", len(links))
    for stamp_ns, parent, child, *pose in links:
        cdr.header(stamp_ns, parent).text(child).pose(*pose)
    return cdr.bytes()


def odometry(stamp_ns, frame, child, *pose):
    cdr = Cdr().header(stamp_ns, frame).text(child).pose(*pose)
    return cdr.put("d", *[0.0] * 36, *[0.0] * 6, *[0.0] * 36).bytes()


def pose_stamped(stamp_ns, frame, *pose, covariance=False):
    cdr = Cdr().header(stamp_ns, frame).pose(*pose)
    return cdr.put("d", *[0.0] * 36 if covariance else []).bytes()


def front_cloud(i):
    """Five points in order, the fourth of them NaN; padding; nanoseconds since the stamp."""
    fields = XYZ + [("intensity", 16, FLOAT32), ("ring", 20, UINT16), ("t", 24, UINT32)]
    points = [(i + 0.25 * k, math.nan if k == 3 else -k, 0.5, 10 * i + k, k, 1_000_000 * k) for k in range(5)]
    return cloud(stamp(0.1 * i), "front_lidar", fields, 32, points)


def rear_cloud(i):
    """Two rows of three, big endian, doubles, rows with bytes after them; seconds since the epoch."""
    fields = [("timestamp", 0, FLOAT64), ("z", 8, FLOAT64), ("y", 16, FLOAT64), ("x", 24, FLOAT64), ("channel", 32, UINT8),
              ("reflectivity", 33, INT16)]
    at = stamp(0.1 * i + 0.05)
    points = [(at / NS + 0.01 * k, 0.125 * k, 2.5, -i - k, k, 100 - k) for k in range(6)]
    return cloud(at, "rear_lidar", fields, 40, points, big=True, height=2, pad=7)


def log():
    """(log_time, topic, type, payload) in the order of time: one second."""
    rows = []
    for i in range(10):
        rows.append((stamp(0.1 * i + 0.011), "/front/points", CLOUD, front_cloud(i)))
        rows.append((stamp(0.1 * i + 0.061), "/rear/points", CLOUD, rear_cloud(i)))
        rows.append((stamp(0.1 * i), "/imu", IMU, b"\0\1\0\0" + b"\0" * 40))
    for i in range(21):
        at = 0.05 * i
        rows.append((stamp(at), "/tf", TF, transforms(
            (stamp(at), "odom", "base_link", 2 * at, 0, 0, 0.1 * at),
            (stamp(at), "base_link", "arm", 0, 0, 1, at))))
        rows.append((stamp(at), "/odom", ODOMETRY, odometry(stamp(at), "odom", "base_link", 2 * at, 0, 0, 0.1 * at)))
    for i in range(6):
        at = 0.2 * i
        rows.append((stamp(at), "/tf", TF, transforms((stamp(at), "map", "odom", 10 + at, 5, 0, 0))))
        rows.append((stamp(at), "/slam_pose", POSE, pose_stamped(stamp(at), "map", at, 7, 0, 0)))
    rows.sort(key=lambda row: row[0])
    # Late: after scans that need it.
    rows.append((stamp(1.5), "/tf_static", TF, transforms(
        (0, "base_link", "mast", 0.5, 0, 1, math.pi / 2), (0, "mast", "front_lidar", 0.25, 0, 0, 0),
        (0, "arm", "rear_lidar", -0.5, 0, 0, math.pi))))
    return rows


def packed(data, program):
    if not program:
        return data
    extra = ["--content-size", "-B4"] if program == "lz4" else []  # blocks of 64 KiB, as MCAP's writer
    return subprocess.run([program, "-q", "-c", *extra, "-"], input=data, stdout=subprocess.PIPE, check=True).stdout


def write_db3(path, rows, pack="", index=True):
    base = sqlite3.connect(path)
    base.execute("PRAGMA page_size=512")
    base.execute("PRAGMA synchronous=OFF")
    base.execute("PRAGMA journal_mode=OFF")
    base.execute("CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL)")
    base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
                 "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)")
    base.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
                 "data BLOB NOT NULL)")
    if index:
        base.execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
    ids = {}
    for at, topic, kind, payload in rows:
        if topic not in ids:
            ids[topic] = len(ids) + 1
            base.execute("INSERT INTO topics VALUES (?,?,?,'cdr','')", (ids[topic], topic, kind))
        base.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?,?,?)", (ids[topic], at, packed(payload, pack)))
    base.commit()
    base.close()


def record(op, content):
    return struct.pack("<BQ", op, len(content)) + content


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


class Channels:
    """Schema and Channel records, each once a place."""

    def __init__(self):
        self.ids = {}

    def declare(self, topic, kind):
        number = self.ids.setdefault((topic, kind), len(self.ids) + 1)
        return number, self.records(topic, kind, number)

    def records(self, topic, kind, number):
        schema = struct.pack("<H", number) + text(kind) + text("ros2msg") + text("# not of use here\n")
        channel = struct.pack("<HH", number, number) + text(topic) + text("cdr") + struct.pack("<I", 0)
        return record(3, schema) + record(4, channel)

    def all(self):
        return b"".join(self.records(*key, number) for key, number in self.ids.items())


def message(channel, number, at, payload):
    return record(5, struct.pack("<HIQQ", channel, number, at, at) + payload)


def chunk(rows, channels, known, program):
    """A Chunk, and its MessageIndex records."""
    content, index = b"", {}
    for number, (at, topic, kind, payload) in enumerate(rows):
        channel, records = channels.declare(topic, kind)
        if channel not in known:
            content += records
            known.add(channel)
        index.setdefault(channel, []).append((at, len(content)))
        content += message(channel, number, at, payload)
    times = [row[0] for row in rows]
    data = packed(content, program)
    head = struct.pack("<QQQI", min(times), max(times), len(content), zlib.crc32(content)) + text(program)
    whole = record(6, head + struct.pack("<Q", len(data)) + data)
    for channel, entries in index.items():
        whole += record(7, struct.pack("<HI", channel, 16 * len(entries)) + b"".join(struct.pack("<QQ", *e) for e in entries))
    return whole, len(record(6, head + struct.pack("<Q", len(data)) + data))


def statistics(groups, channels, chunks):
    """Of all messages and those of each channel."""
    rows = [row for group in groups for row in group]
    counts = {}
    for _, topic, kind, _ in rows:
        counts[channels.ids[topic, kind]] = counts.get(channels.ids[topic, kind], 0) + 1
    times = [row[0] for row in rows] or [0]
    told = b"".join(struct.pack("<HQ", *item) for item in counts.items())
    return record(11, struct.pack("<QHIIIIQQI", len(rows), len(channels.ids), len(channels.ids), 0, 0, chunks, min(times),
                                  max(times), len(told)) + told)


def write_mcap(path, groups, program="", chunked=True, indexed=True, checked=False):
    """`groups`: rows of one chunk each. Not chunked: no chunks at all; not indexed: no index, no summary; checked: with the
    checksums of data and summary."""
    channels, known, out = Channels(), set(), b"\x89MCAP0\r\n" + record(1, text("ros2") + text("make_bags"))
    for rows in groups:
        if chunked:
            whole, size = chunk(rows, channels, known, program)
            out += whole if indexed else whole[:size]
            continue
        for number, (at, topic, kind, payload) in enumerate(rows):
            channel, records = channels.declare(topic, kind)
            out += b"" if channel in known else records
            known.add(channel)
            out += message(channel, number, at, payload)
    out += record(15, struct.pack("<I", zlib.crc32(out) if checked else 0))
    begin = len(out)
    if indexed:
        out += channels.all() + statistics(groups, channels, len(groups) if chunked else 0)
    out += struct.pack("<BQQQ", 2, 20, begin if indexed else 0, 0)
    out += struct.pack("<I", zlib.crc32(out[begin:]) if checked else 0) + b"\x89MCAP0\r\n"
    with open(path, "wb") as file:
        file.write(out)


def in_groups(rows, size=12):
    return [rows[i : i + size] for i in range(0, len(rows), size)]


def write_metadata(folder, names, mode="", rows=(), more=0):
    """`more`: messages of each topic that it tells of, and that are not there."""
    counts = {}
    for row in rows:
        counts[row[1]] = counts.get(row[1], more) + 1
    with open(os.path.join(folder, "metadata.yaml"), "w") as file:
        file.write("rosbag2_bagfile_information:\n  version: 5\n  compression_format: zstd\n"
                   f"  compression_mode: \"{mode}\"\n  relative_file_paths:\n" + "".join(f"    - {n}\n" for n in names))
        file.write("  topics_with_message_count:\n" if counts else "")
        for topic, count in counts.items():
            file.write(f"    - topic_metadata:\n        name: {topic}\n      message_count: {count}\n")


def write_folder(folder, groups, mode="", metadata=True, pack="", more=0):
    os.mkdir(folder)
    names = [f"part_{i}.db3" for i in range(len(groups))]
    for name, rows in zip(names, groups):
        write_db3(os.path.join(folder, name), rows, pack)
    if metadata:
        write_metadata(folder, names, mode, [row for rows in groups for row in rows], more)


def write_file_mode(folder):
    write_folder(folder, [log()], "FILE")
    data = open(os.path.join(folder, "part_0.db3"), "rb").read()
    os.remove(os.path.join(folder, "part_0.db3"))
    with open(os.path.join(folder, "part_0.db3.zstd"), "wb") as file:
        file.write(packed(data, "zstd"))
    write_metadata(folder, ["part_0.db3.zstd"], "FILE")


def of(*topics):
    return [row for row in log() if row[1] in topics]


def without(*topics):
    return [row for row in log() if row[1] not in topics]


def integers():
    fields = [("y", 0, INT16), ("x", 2, INT8), ("z", 3, UINT16), ("i", 5, UINT32), ("line", 9, UINT8)]
    return cloud(stamp(0), "lidar", fields, 11, [(-300, -5, 60000, 70000, 3), (12, 7, 1, 2, 255)])


def timed(kind, unit_per_s, since, name):
    """Three points 0, 25 and 50 ms after the stamp."""
    whole = kind in (UINT32, INT32, UINT64, INT64)
    at = stamp(3)
    values = []
    for ms in (0, 25, 50):
        ns = ms * 1_000_000 + (at if since == "epoch" else 0)
        values.append(ns * unit_per_s // NS if whole else ns / NS * unit_per_s)
    return [(at, "/points", CLOUD, cloud(at, "lidar", XYZ + [(name, 12, kind)], 24, [(1, 2, 3, v) for v in values]))]


TIMES = [(UINT32, NS, "stamp", "t"), (UINT32, NS, "stamp", "offset_time"), (UINT64, NS, "epoch", "timestamp"),
         (UINT64, NS, "stamp", "time"), (FLOAT32, 1, "stamp", "time"), (FLOAT64, 1, "stamp", "time_stamp"),
         (FLOAT64, 1, "epoch", "timestamp"), (FLOAT64, NS, "epoch", "timestamp"), (FLOAT32, 1_000_000, "stamp", "t")]


def write_times(folder):
    os.mkdir(folder)
    for i, (kind, per_s, since, name) in enumerate(TIMES):
        write_mcap(os.path.join(folder, f"{i}_{name}_{since}.mcap"), [timed(kind, per_s, since, name)])


def interleaved():
    """Chunks that overlap in time, each of one topic; and within one against the order of time."""
    topics = sorted({row[1] for row in log()})
    groups = [of(topic)[::-1] if topic == "/front/points" else of(topic) for topic in topics]
    return [part for group in groups for part in in_groups(group, 7)]


def odometry_of_a_wheel():
    """The child of odometry is not the base; TF knows its place on it."""
    rows = of("/front/points")
    rows.append((stamp(0), "/tf_static", TF, transforms((0, "base_link", "wheel", 0, 1, 0, 0),
                                                       (0, "base_link", "front_lidar", 0, 0, 2, 0))))
    return rows + [(stamp(0.1 * i), "/wheel_odom", ODOMETRY, odometry(stamp(0.1 * i), "odom", "wheel", i, 1, 0, 0))
                   for i in range(10)]


def livox(at, count=20, told=None, order="<", zero=False):
    """livox_ros_driver2/msg/CustomMsg: points 1 ms apart; the last has no padding."""
    cdr = Cdr(order).header(0 if zero else at, "livox_frame").put("Q", at).put("I", count).put("B", 1, 0, 0, 0)
    cdr.put("I", count if told is None else told)
    for k in range(count):
        cdr.put("I", 1_000_000 * k).put("f", 1 + k, -2, 0.5).put("B", 100 + k, 0x10, k % 4)
    return cdr.bytes()


def livox_bag(**how):
    kind = how.pop("kind", "livox_ros_driver2/msg/CustomMsg")
    return [(stamp(0.1 * i), "/livox/lidar", kind, livox(stamp(0.1 * i), **how)) for i in range(3)]


def path_of(poses, now):
    cdr = Cdr().header(now, "map").put("I", len(poses))
    for at, x in poses:
        cdr.header(at, "map").pose(x, 0, 0, 0)
    return cdr.bytes()


def with_path(planned=False):
    """Poses as a path that grows, or the plan of a planner, which lies in the future."""
    rows = []
    for i in range(10):
        rows.append((stamp(0.1 * i), "/front/points", CLOUD, front_cloud(i)))
        steps = range(i, i + 9) if planned else range(i + 1)
        rows.append((stamp(0.1 * i + 0.01), "/path", "nav_msgs/msg/Path",
                     path_of([(stamp(0.1 * k), 0.3 * k) for k in steps], stamp(0.1 * i + 0.01))))
    return [rows]


def numbers_that_lie():
    """Clouds that say more than they hold, one a bag."""
    good = bytearray(front_cloud(0))
    at = good.index(b"front_lidar\0") + 12  # height, width
    huge, wide = bytearray(good), bytearray(good)
    struct.pack_into("<II", huge, at, 0xFFFFFFFF, 0xFFFFFFFF)
    struct.pack_into("<II", wide, at, 1, 6)
    fields = bytearray(good)
    struct.pack_into("<I", fields, at + 8, 0xFFFFFFFF)
    return {"huge": huge, "wide": wide, "fields": fields, "cut": good[:-40], "tiny": good[:2], "xml": b"<cloud/>"}


def livox_that_lies():
    return {"more": livox(stamp(0), told=21), "huge": livox(stamp(0), told=0xFFFFFFFF), "cut": livox(stamp(0))[:-3],
            "tiny": livox(stamp(0))[:30]}


def write_endless_view(path):
    """The table of messages is one that never ends."""
    write_db3(path, small())
    base = sqlite3.connect(path)
    base.execute("ALTER TABLE messages RENAME TO real_messages")
    base.execute("CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
                 "SELECT i AS id, 1 AS topic_id, i AS timestamp, zeroblob(9) AS data FROM n")
    base.commit()


def write_generated(path):
    """Each message takes eight bytes in the file, and 100 MB when asked for."""
    base = sqlite3.connect(path)
    base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
    base.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
                 "data BLOB AS (zeroblob(100000000)))")
    base.execute("INSERT INTO topics VALUES (1, '/points', ?, 'cdr')", (CLOUD,))
    base.executemany("INSERT INTO messages(topic_id, timestamp) VALUES (1, ?)", [(i,) for i in range(1000)])
    base.commit()


def write_bomb(path):
    """A message of some KB that unpacks to 120 MB."""
    write_mcap(path, [[(stamp(0), "/points", CLOUD, packed(b"\0" * 120_000_000, "zstd"))]])


def write_large_claim(path):
    """A chunk that says it unpacks to 1 TiB."""
    write_mcap(path, [small()], "zstd")
    data = bytearray(open(path, "rb").read())
    at = data.index(b"\x06", 8 + 9 + 20)
    struct.pack_into("<Q", data, at + 9 + 16, 1 << 40)
    open(path, "wb").write(data)


def small():
    """A bit of everything, for what has to be small."""
    rows = {}
    for row in log():
        rows.setdefault(row[1], []).append(row)
    return sorted((row for some in rows.values() for row in some[:3]), key=lambda row: row[0])


def bags(folder):
    p = lambda name: os.path.join(folder, name)
    names = {
        "log.db3": lambda n: write_db3(n, log()),
        "no_index.db3": lambda n: write_db3(n, log()[::-1], index=False),
        "messages_zstd.db3": lambda n: write_db3(n, log(), "zstd"),
        "small.db3": lambda n: write_db3(n, small()),
        "small_none.mcap": lambda n: write_mcap(n, in_groups(small())),
        "small_zstd.mcap": lambda n: write_mcap(n, in_groups(small()), "zstd"),
        "small_lz4.mcap": lambda n: write_mcap(n, in_groups(small()), "lz4"),
        "small_loose.mcap": lambda n: write_mcap(n, in_groups(small()), chunked=False, indexed=False),
        "checked.mcap": lambda n: write_mcap(n, in_groups(log()), "zstd", checked=True),
        "none.mcap": lambda n: write_mcap(n, in_groups(log())),
        "zstd.mcap": lambda n: write_mcap(n, in_groups(log()), "zstd"),
        "lz4.mcap": lambda n: write_mcap(n, in_groups(log()), "lz4"),
        "loose.mcap": lambda n: write_mcap(n, in_groups(log()), chunked=False),
        "loose_no_summary.mcap": lambda n: write_mcap(n, in_groups(log()), chunked=False, indexed=False),
        "no_summary.mcap": lambda n: write_mcap(n, in_groups(log()), "zstd", indexed=False),
        "overlapping.mcap": lambda n: write_mcap(n, interleaved(), "lz4"),
        "parts": lambda n: write_folder(n, in_groups(log(), 10)),
        "parts_with_loss": lambda n: write_folder(n, in_groups(without("/imu"), 10), more=3),
        "parts_without_metadata": lambda n: write_folder(n, in_groups(log(), 7), metadata=False),
        "mode_message": lambda n: write_folder(n, [log()], "MESSAGE", pack="zstd"),
        "mode_file": write_file_mode,
        "no_tf.mcap": lambda n: write_mcap(n, [without("/tf", "/tf_static", "/slam_pose")]),
        "two_pose_topics.mcap": lambda n: write_mcap(n, [without("/tf")]),
        "no_poses.mcap": lambda n: write_mcap(n, [of("/front/points", "/tf_static")]),
        "no_clouds.mcap": lambda n: write_mcap(n, [of("/imu", "/odom")]),
        "wheel.mcap": lambda n: write_mcap(n, [odometry_of_a_wheel()]),
        "integers.mcap": lambda n: write_mcap(n, [[(stamp(0), "/points", CLOUD, integers())]]),
        "empty.mcap": lambda n: write_mcap(n, []),
        "times": write_times,
        "livox.mcap": lambda n: write_mcap(n, [livox_bag()]),
        "livox_1.mcap": lambda n: write_mcap(n, [livox_bag(kind="livox_ros_driver/msg/CustomMsg", zero=True)]),
        "livox_big.mcap": lambda n: write_mcap(n, [livox_bag(order=">")]),
        "path.mcap": lambda n: write_mcap(n, with_path()),
        "plan.mcap": lambda n: write_mcap(n, with_path(planned=True)),
        "few_digits.mcap": lambda n: write_mcap(n, [timed(FLOAT32, 1, "epoch", "time")]),
        "endless_view.db3": write_endless_view,
        "generated.db3": write_generated,
        "bomb.mcap": write_bomb,
        "large_claim.mcap": write_large_claim,
        "two_clocks.mcap": lambda n: write_mcap(n, [[(stamp(i), "/points", CLOUD, front_cloud(9 - i)) for i in range(3)]]),
        "unknown_type.mcap": lambda n: write_mcap(n, [[(stamp(0), "/points", CLOUD, cloud(
            stamp(0), "lidar", [("x", 0, 99)], 4, []))]]),
    }
    for what, payload in numbers_that_lie().items():
        names[f"lie_{what}.mcap"] = lambda n, payload=payload: write_mcap(n, [[(stamp(0), "/points", CLOUD, bytes(payload))]])
    for what, payload in livox_that_lies().items():
        names[f"lie_livox_{what}.mcap"] = lambda n, payload=payload: write_mcap(
            n, [[(stamp(0), "/livox/lidar", "livox_interfaces/msg/CustomMsg", payload)]])
    return {p(name): write for name, write in names.items()}


if __name__ == "__main__":
    import odd_bags

    known = {**bags(sys.argv[1]), **odd_bags.bags(sys.argv[1])}
    for wanted in sys.argv[2:]:
        path = os.path.join(sys.argv[1], wanted)
        if os.path.isfile(path):
            os.remove(path)
        known[path](path)
