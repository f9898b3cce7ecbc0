"""Bags as they are found after a recorder was killed, and bags that do not tell the truth about themselves: make_bags.py
writes them by their names."""
import os
import shutil
import sqlite3
import struct
import tempfile

import make_bags as mb


def in_wal(path, keep_wal):
    """The rows of the log in the WAL alone: the recorder was killed before a checkpoint. Else: closed well."""
    with tempfile.TemporaryDirectory() as there:
        source, live = os.path.join(there, "log.db3"), os.path.join(there, "live.db3")
        mb.write_db3(source, mb.log())
        base, rows = sqlite3.connect(live), sqlite3.connect(source)
        base.execute("PRAGMA journal_mode=WAL")
        base.execute("PRAGMA wal_autocheckpoint=0")
        for (sql,) in rows.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL"):
            base.execute(sql)
        base.executemany("INSERT INTO topics VALUES (?,?,?,?,?)", rows.execute("SELECT * FROM topics").fetchall())
        base.commit()
        base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        base.executemany("INSERT INTO messages VALUES (?,?,?,?)", rows.execute("SELECT * FROM messages").fetchall())
        base.commit()
        if not keep_wal:
            base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        shutil.copy(live, path)
        if keep_wal:
            shutil.copy(live + "-wal", path + "-wal")
        base.close()
        rows.close()


def copy_without_wal(path):
    """Topics, and all messages are in a WAL that is not there."""
    in_wal(path, True)
    os.remove(path + "-wal")


def topics_in_wal(path):
    """Even the tables are in the WAL, and that one was not copied along."""
    with tempfile.TemporaryDirectory() as there:
        live = os.path.join(there, "live.db3")
        base = sqlite3.connect(live)
        base.execute("PRAGMA journal_mode=WAL")
        base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY)")
        base.commit()
        shutil.copy(live, path)
        base.close()


def in_transaction(path):
    """Killed in the middle of a transaction that has already changed the database: its journal tells what was there."""
    with tempfile.TemporaryDirectory() as there:
        live = os.path.join(there, "live.db3")
        mb.write_db3(live, mb.log())
        base = sqlite3.connect(live, isolation_level=None)
        base.execute("PRAGMA journal_mode=DELETE")
        base.execute("PRAGMA cache_size=5")
        base.execute("BEGIN")
        base.execute("UPDATE messages SET data=zeroblob(length(data)), topic_id=1")
        base.execute("DELETE FROM topics")
        base.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (1,?,?)",
                         [(mb.stamp(2 + i), b"\0" * 2000) for i in range(200)])
        shutil.copy(live, path)
        shutil.copy(live + "-journal", path + "-journal")
        base.execute("ROLLBACK")
        base.close()


def lose_rows_of_index(path):
    """The index of the times knows half of the messages."""
    mb.write_db3(path, mb.log()[::2])
    base = sqlite3.connect(path)
    base.execute("PRAGMA writable_schema=1")
    row = base.execute("SELECT * FROM sqlite_master WHERE name='timestamp_idx'").fetchone()
    base.execute("DELETE FROM sqlite_master WHERE name='timestamp_idx'")
    base.commit()
    base.close()
    base = sqlite3.connect(path)
    ids = dict(base.execute("SELECT name, id FROM topics"))
    base.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?,?,?)",
                     [(ids[topic], at, data) for at, topic, _, data in mb.log()[1::2]])
    base.execute("PRAGMA writable_schema=1")
    base.execute("INSERT INTO sqlite_master VALUES (?,?,?,?,?)", row)
    base.commit()
    base.close()


def split(folder, names, metadata=None):
    """Parts, of which the static links are in the last alone; the names tell nothing of the order."""
    mb.write_folder(folder, mb.in_groups(mb.log(), 20), metadata=False)
    count = len(os.listdir(folder))
    for i in range(count):
        os.rename(os.path.join(folder, f"part_{i}.db3"), os.path.join(folder, names(i, count)))
    if metadata is not None:
        with open(os.path.join(folder, "metadata.yaml"), "w") as file:
            file.write(metadata)


def two_recorders(folder):
    """Clouds in one file, all else in another, both at the same time."""
    os.mkdir(folder)
    clouds = ("/front/points", "/rear/points")
    mb.write_mcap(os.path.join(folder, "a.mcap"), mb.in_groups(mb.of(*clouds)))
    mb.write_db3(os.path.join(folder, "b.db3"), mb.without(*clouds))


def records(data):
    """(begin, opcode, length of the content) of an MCAP file."""
    at = 8
    while at < len(data) - 8:
        length = struct.unpack_from("<Q", data, at + 1)[0]
        yield at, data[at], length
        at += 9 + length


def mcap(**more):
    with tempfile.TemporaryDirectory() as there:
        path = os.path.join(there, "x.mcap")
        mb.write_mcap(path, mb.in_groups(mb.log()), **{"program": "zstd", **more})
        return bytearray(open(path, "rb").read())


def lose(path, wanted, number, **more):
    """Without one record of a kind."""
    data = mcap(**more)
    at, length = [(at, length) for at, op, length in records(data) if op == wanted][number]
    del data[at : at + 9 + length]
    open(path, "wb").write(data)


def lie_statistics(path, place):
    """One more than there are: of all messages, or of the first channel that is told."""
    data = mcap()
    at = next(at for at, op, _ in records(data) if op == 11)
    data[at + 9 + place] += 1
    open(path, "wb").write(data)


def flip(path, wanted, place):
    """Another bit in a record that has no checksum of its own."""
    data = mcap(checked=True)
    at = next(at for at, op, _ in records(data) if op == wanted)
    data[at + 9 + place] ^= 1
    open(path, "wb").write(data)


def twice(path):
    data = mcap()
    open(path, "wb").write(data + data)


def since_boot(path, clouds=True, links=False, moving=False):
    """Stamps of a clock that began 614 s ago, of clouds or of all that moves."""
    rows, early = [], mb.START_S * mb.NS - 614_660_000_000
    fields = mb.XYZ + [("timestamp", 16, mb.FLOAT64)]
    for i in range(10):
        at = mb.stamp(0.1 * i)
        of_cloud, of_link = at - early * clouds, at - early * links
        points = [(1, 2, 3, of_cloud / mb.NS), (4, 5, 6, of_cloud / mb.NS + 0.05)]
        rows.append((at + 10_000_000, "/points", mb.CLOUD, mb.cloud(of_cloud, "lidar", fields, 24, points)))
        rows.append((at, "/tf", mb.TF, mb.transforms((of_link, "odom", "base_link", i, 0, 0, 0))))
        if moving:
            rows.append((at, "/tf", mb.TF, mb.transforms((at, "base_link", "lidar", 0, 0, 1, 1e-10 * i))))
    if not moving:
        rows.append((mb.stamp(0), "/tf_static", mb.TF, mb.transforms((0, "base_link", "lidar", 0, 0, 1, 0))))
    mb.write_mcap(path, [rows])


def ahead(path, seconds, jump=False, poses=0, sweep=0.0, stalls=False):
    """A scanner whose clock is ahead of the recorder's, or jumps there in the middle; its poses too. `sweep`: until the
    last point. `stalls`: the recorder, for 3 s."""
    fields, rows = [(name, 4 * i, mb.FLOAT32) for i, name in enumerate(("x", "y", "z", "time"))], []
    for i in range(100):
        at, off = mb.stamp(0.1 * i), round(seconds * mb.NS) * (i >= 50 or not jump)
        log = mb.stamp(6) if stalls and 30 < i < 60 else at
        points = [(1, 2, 3, 0), (1, 2, 3, sweep)]
        rows.append((log, "/tf", mb.TF, mb.transforms((at + poses * mb.NS, "odom", "base_link", 0.1 * i, 0, 0, 0))))
        rows.append((log + 20_000_000, "/points", mb.CLOUD, mb.cloud(at + off, "base_link", fields, 16, points)))
    mb.write_mcap(path, [rows])


def rare_tf(path):
    """A mounting that is published in /tf, once, late."""
    rows = []
    for i in range(20):
        at = mb.stamp(0.1 * i)
        rows.append((at, "/tf", mb.TF, mb.transforms((at, "odom", "base_link", 0.1 * i, 0, 0, 0))))
        rows.append((at, "/points", mb.CLOUD, mb.cloud(at, "lidar", mb.XYZ, 12, [(1, 2, 3)])))
    rows.append((mb.stamp(1), "/tf", mb.TF, mb.transforms((mb.stamp(1), "base_link", "lidar", 0, 0, 1, 0))))
    mb.write_mcap(path, [rows])


def not_stamped(path):
    """Scans of 0.05 s without a stamp, recorded 0.01 s after their last points."""
    fields = [(name, 4 * i, mb.FLOAT32) for i, name in enumerate(("x", "y", "z", "time"))]
    body = mb.cloud(0, "base_link", fields, 16, [(1, 2, 3, 0), (1, 2, 3, 0.05)])
    mb.write_mcap(path, [[(mb.stamp(0.1 * i + 0.06), "/points", mb.CLOUD, body) for i in range(9)]])


def with_maps(path):
    """A LiDAR, and what a SLAM makes of it: its map in two frames, and scans in the frame of the map."""
    rows = []
    for i in range(10):
        at, points = mb.stamp(0.2 * i), [(k, 1, 2) for k in range(10 + i // 2)]
        rows.append((at, "/tf", mb.TF, mb.transforms((at, "map", "base_link", 0.3 * i, 0, 0, 0))))
        for topic, frame, some in (("/points", "base_link", [(i, 2, 3), (4, 5, 6)]), ("/grows", "lidar_map", points),
                                   ("/repeats", "lidar_map", points[:5]), ("/registered", "map", [(i, 2, 3)])):
            rows.append((at, topic, mb.CLOUD, mb.cloud(at, frame, mb.XYZ, 12, some)))
    mb.write_mcap(path, [rows])


def copies(path):
    """A LiDAR as it is, thinned out, moved to the base, and another LiDAR with the same stamps."""
    import random

    numbers, rows = random.Random(3), [(mb.stamp(0), "/tf_static", mb.TF, mb.transforms(
        (mb.stamp(0), "base_link", "lidar", 0.1, 0, 0.7, 0), (mb.stamp(0), "base_link", "rear", -0.5, 0, 0.7, 0)))]
    some = lambda: [(numbers.uniform(-9, 9), numbers.uniform(-9, 9), numbers.uniform(-1, 1)) for _ in range(200)]
    for i in range(10):
        at, points = mb.stamp(0.1 * i), some()
        rows.append((at, "/tf", mb.TF, mb.transforms((at, "odom", "base_link", 0.3 * i, 0, 0, 0))))
        for topic, frame, cloud in (("/a_base", "base_link", [(x + 0.1, y, z + 0.7) for x, y, z in points]),
                                    ("/points", "lidar", points), ("/thin", "lidar", points[::3]),
                                    ("/rear", "rear", some())):
            rows.append((at, topic, mb.CLOUD, mb.cloud(at, frame, mb.XYZ, 12, cloud)))
    mb.write_mcap(path, [rows])


def no_returns(path, count):
    """In the frame of the base: ground that an exact sensor sees, and at its place what gave no return."""
    rows = []
    for i in range(10):
        points = [(2 + 0.1 * k, 0, 0) for k in range(30)] + [(2, 1, 0.1 * i)] + [(0.2, 0, 0.7)] * count
        rows.append((mb.stamp(i), "/points", mb.CLOUD, mb.cloud(mb.stamp(i), "base_link", mb.XYZ, 12, points)))
    mb.write_mcap(path, [rows])


def wrong_order(path):
    """A cloud that says it is big endian, and is not."""
    good = mb.cloud(mb.stamp(0), "lidar", mb.XYZ, 12, [(1.1 * k, 2.3, 0.7) for k in range(5)])
    at = good.index(struct.pack("<fff", 0, 2.3, 0.7)) - 16  # flag, padding, steps, bytes
    assert good[at] == 0
    mb.write_mcap(path, [[(mb.stamp(0), "/points", mb.CLOUD, good[:at] + b"\1" + good[at + 1 :])]])


def tf_bomb(path, chunks, links):
    """Some KB that unpack to very many links, each of another time."""
    some = mb.transforms(*[(mb.stamp(0), "odom", "base_link", 0, 0, 0, 0)] * 3)
    size = 96  # of all but the first, by where they lie
    second = len(some) - 2 * size
    groups = []
    for c in range(chunks):
        many = bytearray(some[:second] + some[-size:] * (links - 1))
        struct.pack_into("<I", many, 4, links)
        for i in range(links):
            at = second + size * (i - 1) if i else 8
            struct.pack_into("<II", many, at, mb.START_S + c * links + i, 0)
        groups.append([(mb.stamp(c), "/tf", mb.TF, bytes(many))])
    groups.append(mb.of("/front/points", "/tf_static"))
    mb.write_mcap(path, groups, "zstd")


def frame_bomb(path):
    """Of TF very many frames."""
    links = [(0, "odom", f"frame_{i}", 0, 0, 0, 0) for i in range(11000)]
    mb.write_mcap(path, [[(mb.stamp(0), "/tf", mb.TF, mb.transforms(*links))], mb.of("/front/points")], "zstd")


def cloud_bomb(path, in_message):
    """A cloud of millions of points that are all the same."""
    whole = cloud_of_many(5_000_000)
    rows = [(mb.stamp(0), "/points", mb.CLOUD, mb.packed(whole, "zstd") if in_message else whole)]
    mb.write_mcap(path, [rows], "" if in_message else "zstd")


def chunk_bomb(path, program):
    """A chunk of 20 MB."""
    mb.write_mcap(path, [[(mb.stamp(0), "/points", mb.CLOUD, b"\0" * 20_000_000)]], program)


def topic_bomb(path):
    """Topics whose names take 5 MB."""
    rows = [(mb.stamp(0), "/" + "x" * 50000 + str(i), mb.CLOUD, b"") for i in range(100)]
    mb.write_mcap(path, [rows], "zstd", indexed=False)


def overlapping_bomb(path):
    """Chunks of 8 MB that all begin at one time."""
    empty = mb.cloud(mb.stamp(0), "lidar", mb.XYZ, 12, [])
    body = empty[:-9] + struct.pack("<II", 12, 0) + struct.pack("<I", 0) + b"\0"
    rows = [(mb.stamp(0), "/points", mb.CLOUD, body), (mb.stamp(9), "/points", mb.CLOUD, body + b"\0" * 8_000_000)]
    last = [(mb.stamp(10), "/points", mb.CLOUD, cloud_of_many(1_400_000))]
    mb.write_mcap(path, [rows] * 14 + [last], "zstd")


def cloud_of_many(count):
    fields = [("x", 0, mb.INT8), ("y", 1, mb.INT8), ("z", 2, mb.INT8)]
    one = mb.cloud(mb.stamp(0), "lidar", fields, 3, [(1, 1, 1)] * 3)
    body = one.replace(struct.pack("<II", 1, 3), struct.pack("<II", 1, count), 1)
    at = body.index(struct.pack("<III", 3, 9, 9))
    return body[:at] + struct.pack("<III", 3, 3 * count, 3 * count) + b"\1" * (3 * count) + b"\0"


def many_scans(count=200):
    """With points that do not pack well. Where they are few, the tree of a database has three levels."""
    import random
    numbers = random.Random(7)
    rows = []
    for i in range(200):
        points = [(i, numbers.random(), numbers.random()) for _ in range(count)]
        rows.append((mb.stamp(0.1 * i), "/front/points", mb.CLOUD, mb.cloud(mb.stamp(0.1 * i), "lidar", mb.XYZ, 12, points)))
    return rows


def bags(folder):
    p = lambda name: os.path.join(folder, name)
    names = {
        "wal_killed.db3": lambda n: in_wal(n, True),
        "wal_closed.db3": lambda n: in_wal(n, False),
        "wal_lost.db3": copy_without_wal,
        "wal_lost_early.db3": topics_in_wal,
        "journal.db3": in_transaction,
        "lost_index.db3": lose_rows_of_index,
        "wide.db3": lambda n: mb.write_db3(n, many_scans()),
        "deep.db3": lambda n: mb.write_db3(n, many_scans(15)),
        "split_names_lie": lambda n: split(n, lambda i, count: f"{(i * 7 + 3) % count:03}.db3"),
        "split_empty_metadata": lambda n: split(n, lambda i, count: f"part_{i}.db3", ""),
        "split_bad_metadata": lambda n: split(n, lambda i, count: f"part_{i}.db3", "rosbag2_bagfile_information: ["),
        "split_metadata_ends": lambda n: split(
            n, lambda i, count: f"part_{i}.db3",
            "rosbag2_bagfile_information:\n  relative_file_paths: [part_0.db3, part_1.db3]\n"),
        "two_recorders": two_recorders,
        "lie_statistics.mcap": lambda n: lie_statistics(n, 0),
        "lie_channel.mcap": lambda n: lie_statistics(n, 48),
        "lost_chunk.mcap": lambda n: lose(n, 6, 4),
        "lost_message.mcap": lambda n: lose(n, 5, 20, chunked=False),
        "flip_index.mcap": lambda n: flip(n, 7, 7),
        "flip_summary.mcap": lambda n: flip(n, 11, 10),
        "twice.mcap": twice,
        "boot_clouds.mcap": since_boot,
        "boot_all.mcap": lambda n: since_boot(n, links=True),
        "boot_odometry.mcap": lambda n: since_boot(n, clouds=False, links=True),
        "boot_moving.mcap": lambda n: since_boot(n, moving=True),
        "ahead_37.mcap": lambda n: ahead(n, 37),
        "ahead_1.mcap": lambda n: ahead(n, 1),
        "ahead_all.mcap": lambda n: ahead(n, 37, poses=37),
        "jump_2.mcap": lambda n: ahead(n, 2, jump=True),
        "stall.mcap": lambda n: ahead(n, 0, stalls=True),
        "sweep_end.mcap": lambda n: ahead(n, 0, sweep=0.1),
        "rare_tf.mcap": rare_tf,
        "not_stamped.mcap": not_stamped,
        "with_maps.mcap": with_maps,
        "copies.mcap": copies,
        "no_returns_1.mcap": lambda n: no_returns(n, 1),
        "no_returns_9.mcap": lambda n: no_returns(n, 9),
        "wrong_order.mcap": wrong_order,
        "one_chunk.mcap": lambda n: mb.write_mcap(n, [many_scans()]),
        "tf_bomb.mcap": lambda n: tf_bomb(n, 12, 30000),
        "frame_bomb.mcap": frame_bomb,
        "topic_bomb.mcap": topic_bomb,
        "overlapping_bomb.mcap": overlapping_bomb,
        "cloud_bomb.mcap": lambda n: cloud_bomb(n, False),
        "cloud_bomb_message.mcap": lambda n: cloud_bomb(n, True),
    }
    for program in ("zstd", "lz4"):
        names[f"chunk_bomb_{program}.mcap"] = lambda n, program=program: chunk_bomb(n, program)
        names[f"one_chunk_{program}.mcap"] = lambda n, program=program: mb.write_mcap(n, [many_scans()], program)
    return {p(name): write for name, write in names.items()}
