"""`import talus`: arrays in and out, errors, memory, threads, and the bits of C++."""

import copy
import os
import pickle
import resource
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import talus

sys.dont_write_bytecode = True  # beside the sources

LEVEL = np.eye(4)
SENSOR = np.eye(4)
SENSOR[2, 3] = 0.7


def floor(n=14400, reach=4.0):
    """A scan of level ground, 0.7 m below the sensor."""
    random = np.random.default_rng(1)
    r, a = random.uniform(0.3, reach, n), random.uniform(-np.pi, np.pi, n)
    return np.stack([r * np.cos(a), r * np.sin(a), np.full(n, -0.7)], 1).astype(np.float32)


def small_map(**more):
    return talus.Map(backend="cpu", threads=1, window=4.0, **more)


def memory_mib():
    with open("/proc/self/statm") as f:
        return int(f.read().split()[1]) * resource.getpagesize() / 2**20


class Layers(unittest.TestCase):
    def setUp(self):
        self.map = small_map()
        self.report = self.map.update(floor(), SENSOR, SENSOR, t=5.0)

    def test_are_squares_of_float32_that_nobody_writes_into(self):
        for name in self.map.keys() + ["ground"]:
            layer = self.map[name]
            self.assertEqual((layer.shape, layer.dtype, layer.flags.writeable), ((80, 80), np.float32, False), name)
        self.assertTrue(np.shares_memory(self.map["ground"], self.map["ground_elevation"]))
        self.assertAlmostEqual(float(np.nanmean(self.map["ground"])), 0, delta=0.01)

    def test_stay_as_they_are_when_the_map_goes_on_or_is_gone(self):
        before = self.map["variance"]
        copy = before.copy()
        for _ in range(3):
            self.map.update(floor(), SENSOR, SENSOR)
        self.assertFalse(np.array_equal(self.map["variance"], copy, equal_nan=True))
        del self.map
        np.testing.assert_array_equal(before, copy)

    def test_lie_where_extent_and_xy_say_with_row_0_in_the_south(self):
        scan = floor()
        scan[(scan[:, 0] > 1) & (scan[:, 1] < -1), 2] += 0.3  # south-east
        m = small_map()
        for _ in range(3):
            m.update(scan, SENSOR, SENSOR)
        x, y = m.xy()
        self.assertEqual(m.extent, (-2.0, 2.0, -2.0, 2.0))
        self.assertAlmostEqual(x[0], -1.975)
        top = np.fmax(m["ground"], m["elevation"])
        row, column = np.argmin(abs(y + 1.5)), np.argmin(abs(x - 1.5))
        self.assertAlmostEqual(float(top[row, column]), 0.3, delta=0.05)
        at = m.at("elevation", np.array([[x[column], y[row]], [50.0, 0.0]]))
        self.assertEqual(at[0], m["elevation"][row, column])
        self.assertTrue(np.isnan(at[1]))

    def test_take_the_contacts_of_feet(self):
        m = small_map()
        for _ in range(3):
            m.update(floor()[floor()[:, 0] < 0], SENSOR, SENSOR)
        before, at = m["ground"], np.array([[1.5, 0.3]])
        self.assertNotEqual(m.at("state", at)[0], 1)
        m.contact(1.5, 0.3, 0.04, 0.01)
        self.assertEqual((m.at("state", at)[0], m.at("ground", at)[0]), (1, np.float32(0.04)))
        z, sigma, origin = m.height_scan(LEVEL, [1.5], [0.3])
        self.assertEqual((z[0], origin[0]), (np.float32(0.04), 1))
        self.assertEqual(np.count_nonzero(m["ground"] != before), np.count_nonzero(np.isnan(before)) + 1)

    def test_report_counts_the_points(self):
        self.assertEqual((self.report.stamp, self.report.points_in), (5.0, 14400))
        self.assertEqual(self.report.points_accepted + sum(self.report.rejected.values()), 14400)

    def test_channels_become_layers(self):
        m = small_map(channels="intensity:mean")
        m.update(floor(), SENSOR, SENSOR, channels={"intensity": np.full(14400, 7)})
        self.assertEqual(float(np.nanmax(m["intensity"])), 7)

    def test_a_saved_map_goes_on(self):
        other = small_map()
        other.restore(self.map.save())
        for m in (self.map, other):
            m.update(floor(), SENSOR, SENSOR, t=6.0)
        np.testing.assert_array_equal(self.map["ground"], other["ground"])


class Answers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scan = floor()
        wall = np.abs(cls.scan[:, 0] - 1.5) < 0.1
        cls.scan[wall, 2] += 0.5 * np.arange(wall.sum()) / wall.sum()
        cls.map = talus.Map(backend="cpu", threads=1)
        for _ in range(5):
            cls.map.update(cls.scan, SENSOR, SENSOR)

    def test_labels_and_risk(self):
        labels = self.map.labels(self.scan, SENSOR, SENSOR)
        self.assertEqual(labels.shape, (14400,))
        self.assertGreater(np.mean(labels == talus.LABELS.index("ground")), 0.9)
        risk = self.map.risk()
        self.assertEqual(risk.shape, self.map.shape)
        self.assertTrue(np.nanmin(risk) >= 0 and np.nanmax(risk) <= 1)

    def test_obstacles_are_the_wall(self):
        points = self.map.obstacles(LEVEL, unseen="free")
        self.assertEqual(points.shape[1], 3)
        self.assertGreater(len(points), 10)
        self.assertTrue(np.all(np.abs(points[:, 0] - 1.5) < 0.5))

    def test_heading_cost_and_plan(self):
        cost = self.map.heading_cost(np.array([[-1.0, 0, 0], [1.5, 0, 0]]))
        self.assertLess(cost["cost"][0], 0.2)
        self.assertGreater(cost["cost"][1], 0.5)
        route = talus.plan(self.map, LEVEL, (-2.0, 1.0), drops="ignore")
        self.assertAlmostEqual(route["x"][-1], -2, delta=0.4)
        self.assertEqual(len(talus.plan(self.map, LEVEL, (-2.0, 1.0), talus.Footprint(max_x=0.33))["yaw"].shape), 1)


    def test_height_scan_of_one_pose_and_of_many(self):
        x, y = np.meshgrid(np.arange(-0.8, 0.85, 0.1), np.arange(-0.5, 0.55, 0.1))
        z, sigma, origin = self.map.height_scan(LEVEL, x, y)
        self.assertEqual((z.shape, sigma.dtype, origin.dtype), ((11, 17), np.float32, np.uint8))
        self.assertLess(np.nanmax(abs(z[origin == 1])), 0.02)
        turned = np.array([LEVEL, [[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]], float)
        many = self.map.height_scan(turned, x, y)
        self.assertEqual(many[0].shape, (2, 11, 17))
        np.testing.assert_array_equal(many[0][0], z)


class Errors(unittest.TestCase):
    def test_name_the_argument(self):
        m, p = small_map(), floor()
        nowhere = np.full((4, 4), np.nan)
        for kind, name, call in (
                (ValueError, "points", lambda: m.update(p.astype(int), SENSOR)),
                (ValueError, "points", lambda: m.update(p[:, :2], SENSOR)),
                (ValueError, "points", lambda: m.update(p.ravel(), SENSOR)),
                (ValueError, "points", lambda: m.update(p.tolist(), SENSOR)),
                (ValueError, "T_map_sensor", lambda: m.update(p, nowhere)),
                (ValueError, "T_map_sensor", lambda: m.update(p, np.eye(3))),
                (ValueError, "T_base_sensor", lambda: m.update(p, SENSOR, nowhere)),
                (ValueError, "rotation", lambda: m.update(p, 2 * SENSOR)),
                (ValueError, "masked", lambda: m.update(np.ma.masked_array(p, p > 1), SENSOR)),
                (ValueError, "transposed", lambda: m.update(p, SENSOR.T)),
                (ValueError, "T_map_base: .*rotation", lambda: m.height_scan(np.diag([1, 1, -1, 1]), [0.0], [0.0])),
                (ValueError, "path: must", lambda: m.update(p, SENSOR, path=[SENSOR])),
                (ValueError, "path: needs", lambda: m.update(p, SENSOR, path=[(0, SENSOR), (1, SENSOR)])),
                (ValueError, "channels: must", lambda: m.update(p, SENSOR, channels=[p[:, 0]])),
                (ValueError, "x: is masked", lambda: m.height_scan(LEVEL, np.ma.masked_array([0.0], [True]), [0.0])),
                (ValueError, "side", lambda: m.heading_cost(np.zeros((1, 3)), talus.Footprint(min_x=1.0))),
                (ValueError, "side", lambda: m.heading_cost(np.zeros((1, 3)), talus.Footprint(max_y=np.nan))),
                (ValueError, "wheels", lambda: talus.Footprint(wheels=3)),
                (ValueError, "too large", lambda: talus.plan(m, LEVEL, (1, 0), talus.Footprint(max_x=1e9))),
                (ValueError, "too large", lambda: talus.plan(m, LEVEL, (1, 0), talus.Footprint(max_x=np.nan))),
                (ValueError, "times", lambda: m.update(p, SENSOR, times=[0.0])),
                (ValueError, "t: ", lambda: m.update(p, SENSOR, t=np.inf)),
                (ValueError, "channels: 'a'", lambda: m.update(p, SENSOR, channels={"a": p[:, 0]})),
                (ValueError, "resolution_m", lambda: talus.Map(resolution=-1)),
                (ValueError, "backend", lambda: talus.Map(backend="gpu")),
                (TypeError, "resolution_m", lambda: talus.Map(resolutoin=0.1)),
                (KeyError, "grond", lambda: m["grond"]),
                (ValueError, "T_map_base", lambda: m.obstacles(nowhere)),
                (TypeError, "drop", lambda: m.obstacles(LEVEL, drop="slope")),
                (ValueError, "drops", lambda: m.obstacles(LEVEL, drops="all")),
                (ValueError, "T_map_base", lambda: m.height_scan(nowhere, [0.0], [0.0])),
                (ValueError, "x, y is not in the window", lambda: m.contact(9.0, 0.0, 0.0, 0.01)),
                (ValueError, "sigma", lambda: m.contact(0.0, 0.0, 0.0, np.nan)),
                (ValueError, "sigma", lambda: m.contact(0.0, 0.0, 0.0, -0.01)),
                (ValueError, "z", lambda: m.contact(0.0, 0.0, np.inf, 0.01)),
                (ValueError, "x and y", lambda: m.height_scan(LEVEL, [0.0], [[0.0]])),
                (ValueError, "goal", lambda: talus.plan(m, LEVEL, (np.nan, 0)))):
            with self.assertRaisesRegex(kind, name):
                call()
        self.assertTrue(np.isnan(m["ground"]).all(), "nothing has changed")


    def test_are_told_of_objects_without_init_and_of_copies(self):
        report = small_map().update(floor(), SENSOR)
        for cls in (value for value in vars(talus._talus).values() if isinstance(value, type)):
            empty = cls.__new__(cls)
            for name in set(dir(cls)) - set(dir(object)):
                args = {"__getitem__": ["ground"], "at": ["ground", np.zeros((1, 2))], "band": [""]}.get(name, [])
                for args in (args, [SENSOR], [floor(), SENSOR], [SENSOR, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0], [b""]):
                    try:
                        member = getattr(empty, name)
                        if callable(member):
                            member(*args)
                    except (TypeError, ValueError):
                        pass
            self.assertRaises(TypeError, copy.copy, empty)
        for thing in (small_map(), report, talus.Footprint()):
            for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
                self.assertRaisesRegex(TypeError, "save", pickle.dumps, thing, protocol)
        with self.assertRaises(TypeError):
            talus.Map.__new__(talus.Map).shape
        with self.assertRaises(TypeError):
            talus.plan(talus.Map.__new__(talus.Map), LEVEL, (1, 0))
        with self.assertRaises(TypeError):
            small_map().heading_cost(np.zeros((1, 3)), talus.Footprint.__new__(talus.Footprint))


class Memory(unittest.TestCase):
    def test_a_million_points_are_not_copied(self):
        points = np.zeros((1_000_000, 8))  # 61 MiB, of float64 and with columns between
        points[:, :3] = floor(1_000_000)
        columns = np.ascontiguousarray(points[:, :3].T, dtype=np.float32).T
        m = talus.Map(backend="cpu", threads=1)
        for scan in (points, columns):
            m.update(scan, SENSOR, SENSOR)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for scan in (points[::-1], columns):
            m.update(scan, SENSOR, SENSOR)
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 4 * 1024, "KiB")

    def test_is_flat_over_a_thousand_maps(self):
        scan = floor(200)
        for i in range(1000):
            m = talus.Map(backend="cpu", threads=1, window=2.0)
            m.update(scan, SENSOR, SENSOR)
            layer = m["ground"]
            if i == 200:
                before = memory_mib()
        self.assertLess(memory_mib() - before, 3)
        self.assertEqual(sys.getrefcount(layer), 2)


class Threads(unittest.TestCase):
    def test_go_on_while_a_map_computes_and_share_a_map(self):
        points = np.ascontiguousarray(floor(1_000_000))
        m, counts, done = talus.Map(backend="cpu", threads=1), [0], threading.Event()

        def count():
            while not done.is_set():
                counts[0] += 1
                time.sleep(0.001)

        counter = threading.Thread(target=count)
        counter.start()
        m.update(points, SENSOR, SENSOR)
        during = counts[0]
        others = [threading.Thread(target=m.update, args=(floor(), SENSOR, SENSOR)) for _ in range(4)]
        for thread in others:
            thread.start()
        for _ in range(20):
            self.assertEqual(m["ground"].shape, (160, 160))
        for thread in others:
            thread.join()
        done.set()
        counter.join()
        self.assertGreater(during, 3)


    def test_that_compute_when_python_ends_do_not_crash(self):
        code = ("import threading, numpy, talus; m = talus.Map(backend='cpu'); p = numpy.full((100000, 3), 0.5)\n"
                "def go():\n  while True: m.update(p, numpy.eye(4))\n"
                "[threading.Thread(target=go, daemon=True).start() for _ in range(3)]; m.risk()")
        for _ in range(3):
            subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


class Bits(unittest.TestCase):
    """Of the world `standing` of test/core/golden_maps.cpp."""

    BOXES = (((2, 0.5, 0), (2.3, 0.9, 0.5)), ((4, -1, 0.75), (4.6, 1, 0.8)), ((1, -2, 0), (9, -1.95, 1.0)),
             ((3.02, -0.6, 0), (3.06, -0.56, 1.2)), ((6, -0.5, 0), (6.5, 0.5, 0.08)), ((7, -3, 0.35), (7.2, 3, 0.45)),
             ((-2.5, -1.5, 0.2), (-1.7, -0.9, 0.55)), ((1.5, 2, 0.2), (3.5, 3, 0.75)),
             ((1.8, 2.12, 0.75), (3.2, 2.9, 1.3)))

    def rays(self):
        at = np.arange(360)
        quarter = 4 * at // 360
        t = (4.0 * at + 1.5 - quarter * 360.0) / 360 * 0.41
        c, s = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
        x = np.choose(quarter, [c, -s, -c, s])
        y = np.choose(quarter, [s, c, -s, -c])
        slope = -0.7 + (0.1 - -0.7) * np.arange(24) / 23
        return np.stack([np.tile(x, 24), np.tile(y, 24), np.repeat(slope, 360)])

    def noise(self):
        mask, state = (1 << 64) - 1, 7
        while True:
            state = (state + 0x9E3779B97F4A7C15) & mask
            z = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
            z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
            yield -0.02 + (0.02 - -0.02) * float((z ^ (z >> 31)) >> 11) * 2.0**-53

    def ranges(self, origin, d):
        with np.errstate(all="ignore"):
            nearest = np.where(-d[2] > 0, origin[2] / -d[2], np.inf)
            for low, high in self.BOXES:
                enter, leave = np.zeros(d.shape[1]), np.full(d.shape[1], np.inf)
                for i in range(3):
                    a, b = (low[i] - origin[i]) / d[i], (high[i] - origin[i]) / d[i]
                    enter, leave = np.maximum(enter, np.minimum(a, b)), np.minimum(leave, np.maximum(a, b))
                nearest = np.where(enter <= leave, np.minimum(nearest, enter), nearest)
        return nearest

    def digest(self, layer):
        value = 0xCBF29CE484222325
        for byte in layer.tobytes():
            value = ((value ^ byte) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
        return f"{value:016x}"

    def test_are_those_of_the_golden_maps(self):
        path = os.path.join(os.path.dirname(__file__), "..", "core", "golden_maps.txt")
        with open(path) as file:
            golden = next(line.split()[3:] for line in file if line.startswith("standing 10 "))
        pose = np.eye(4)
        pose[:3, 3] = 0.01, 0.02, 0.7
        d, noise, m = self.rays(), self.noise(), talus.Map(backend="cpu")
        r = self.ranges(pose[:3, 3], d)
        hit = r < 30
        for i in range(10):
            error = np.fromiter(noise, float, d.shape[1])
            points = np.stack([r * d[0], r * d[1], r * d[2] + error], 1)[hit]
            m.update(points if i % 2 else points.astype(np.float32), pose, t=0.1 * i)
        for name, wanted in zip(m.keys(), golden):
            self.assertEqual(self.digest(m[name]), wanted, name)


@unittest.skipUnless(hasattr(talus._talus, "Frames"), "this build reads no files")
class Files(unittest.TestCase):
    def drive(self, folder):
        """KITTI's scans of a floor with a block, and the poses of a robot that passes it."""
        scans = os.path.join(folder, "velodyne")
        os.mkdir(scans)
        with open(os.path.join(folder, "poses.tum"), "w") as poses:
            for i in range(6):
                scan = floor(4000)
                block = (abs(scan[:, 0] + 0.2 * i - 2) < 0.3) & (abs(scan[:, 1]) < 0.3)
                scan[block, 2] += 0.4
                np.hstack([scan, np.ones((len(scan), 1), np.float32)]).tofile(os.path.join(scans, f"{i:06}.bin"))
                poses.write(f"{1000 + 0.1 * i} {0.2 * i} 0 0 0 0 0 1\n")
        with open(os.path.join(folder, "times.txt"), "w") as times:
            times.writelines(f"{1000 + 0.1 * i}\n" for i in range(6))
        return os.path.join(folder, "poses.tum")

    def test_frames_and_site_have_the_bits_of_talus_map(self):
        with tempfile.TemporaryDirectory() as folder:
            poses, out = self.drive(folder), os.path.join(folder, "out")
            subprocess.run(
                [os.environ["TALUS_MAP"], folder, "--poses", poses, "--mount", "velodyne=0,0,0.7,0,0,0",
                 "--backend", "cpu", "--output", out, "--quiet"], check=True, stderr=subprocess.DEVNULL)
            m = talus.Map(backend="cpu")
            frames = list(talus.frames(folder, poses=poses, mounts={"velodyne": SENSOR}))
            self.assertEqual([round(f["t"], 3) for f in frames], [1000 + 0.1 * i for i in range(6)])
            for f in frames:
                m.update(**f)
            found = [os.path.join(at, "map.tif") for at, _, names in os.walk(out) if "map.tif" in names]
            site = talus.Site.open(found[0].replace("map.tif", "site.tif"))
            whole = site["ground"]
            x0, _, y0, _ = m.extent
            x, y = round((x0 - site.extent[0]) / 0.05), round((y0 - site.extent[2]) / 0.05)
            measured = m["state"] == 1
            rows, columns = np.nonzero(measured)
            inside = (rows + y >= 0) & (columns + x >= 0) & (rows + y < whole.shape[0]) & (columns + x < whole.shape[1])
            rows, columns = rows[inside], columns[inside]
            self.assertGreater(len(rows), 1000)
            np.testing.assert_array_equal(whole[rows + y, columns + x], m["ground"][rows, columns])
            window = site.window(1.0, 0.0, 2.0)
            self.assertEqual(window["traversability"].shape, (40, 40))
            np.testing.assert_allclose(window.extent, (0, 2, -1, 1), atol=1e-9)
            self.assertTrue(np.shares_memory(window["ground"], whole))
            with self.assertRaises(KeyError):
                site["grond"]

    def test_frames_of_a_bag_have_the_poses_that_it_ends_with(self):
        sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "import"))
        import make_bags
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "log.mcap")
            make_bags.write_mcap(path, make_bags.in_groups(make_bags.log()))
            m = talus.Map(backend="cpu", min_height=-100, max_height=100)
            frames = list(talus.frames(path))
            self.assertEqual(sorted({f["sensor"] for f in frames}), [0, 1])
            self.assertEqual(len([f for f in talus.frames(path, topics=["/front/points"])]), 10)
            for f in frames:
                self.assertEqual(len(f["times"]), len(f["points"]))
                m.update(**f)
            self.assertGreater(frames[-1]["T_map_sensor"][0, 3], 10)

    def test_errors_name_the_file(self):
        with self.assertRaisesRegex(RuntimeError, "nowhere"):
            next(iter(talus.frames("/nowhere")))
        with self.assertRaisesRegex(RuntimeError, "nowhere.tif"):
            talus.Site.open("/nowhere.tif")


class Stubs(unittest.TestCase):
    def test_have_all_that_the_module_has(self):
        with open(os.path.join(os.path.dirname(talus.__file__), "__init__.pyi")) as file:
            stubs = file.read()
        for name in talus.__all__:
            self.assertRegex(stubs, rf"(class|def) {name}\b|{name}:")
            thing = getattr(talus, name)
            self.assertTrue(isinstance(thing, tuple) or thing.__doc__, name)
            for member in vars(thing) if isinstance(thing, type) else ():
                if not member.startswith("_"):
                    self.assertRegex(stubs, rf"\b{member}\b", f"{name}.{member}")
                    self.assertTrue(getattr(thing, member).__doc__, f"{name}.{member}")


if __name__ == "__main__":
    unittest.main()
