"""Judges Map.height_scan() in a scene of closed form and prints a table in Markdown, in half a minute:
height_table.py [NOISE [SEED]], the standard deviation of ranges [m], and a seed for other boxes on other waves.

The scene and the judgement are those of the accuracy test of elevation_mapping_cupy_core (sim/, scene `mixed`): waves
of 8 cm, five stairs and six boxes around a sensor at 0.8 m that turns on the spot in 16 scans; cells of 4 cm up to
2.5 m.
"""

import sys

import numpy as np

import talus

# x, y, half length, half width, height [m]
BOXES = [(1.4 + 0.4 * i, 0, 0.2, 1.5, 0.1 * (i + 1)) for i in range(5)] + [
    (-2.900, -1.842, 0.283, 0.146, 0.372), (-2.382, 1.642, 0.230, 0.265, 0.104), (1.665, 3.194, 0.302, 0.315, 0.171),
    (-1.451, -3.490, 0.204, 0.208, 0.440), (2.742, 0.596, 0.337, 0.128, 0.244), (1.449, -0.880, 0.305, 0.381, 0.095)]
CELL, REACH, SCANS, MOUNT = 0.04, 2.5, 16, 0.8
AWAY = 0.0, 0.0  # of the waves [m]
if len(sys.argv) > 2:
    random = np.random.default_rng(int(sys.argv[2]))
    AWAY = random.uniform(-50, 50, 2)
    BOXES = [(r * np.cos(a), r * np.sin(a), *random.uniform((0.1, 0.1, 0.1), (0.4, 0.4, 0.4)))
             for r, a in random.uniform((1.4, -3.14), (3.0, 3.14), (14, 2))]


def waves(x, y):
    x, y = x + AWAY[0], y + AWAY[1]
    z = 0.55 * np.sin(1.3 * x) * np.cos(0.9 * y) + 0.3 * np.sin(2.7 * x + 0.6) * np.sin(2.1 * y - 0.4)
    return 0.04 * (z + 0.15 * np.cos(4.1 * x - 1.1) * np.cos(3.3 * y + 0.9) + 1)


def height(x, y):
    z = waves(x, y)
    for cx, cy, a, b, top in BOXES:
        z = np.where((abs(x - cx) <= a) & (abs(y - cy) <= b), np.maximum(z, top), z)
    return z


def ranges(origin, d):
    """Of rays along unit vectors; infinity: no hit."""
    nearest = np.full(len(d), np.inf)
    with np.errstate(all="ignore"):
        for cx, cy, a, b, top in BOXES:
            low, high = ((np.array(corner) - origin) / d for corner in ((cx - a, cy - b, 0), (cx + a, cy + b, top)))
            enter, leave = np.minimum(low, high).max(1), np.maximum(low, high).min(1)
            nearest = np.where((enter <= leave) & (enter > 0), np.minimum(nearest, enter), nearest)
    down = d[:, 2] < -0.02
    ray = d[down]
    first, last = (origin[2] - 0.09) / -ray[:, 2], origin[2] / -ray[:, 2]

    def below(r):
        return origin[2] + r * ray[:, 2] < waves(origin[0] + r * ray[:, 0], origin[1] + r * ray[:, 1])

    low, high, found = first.copy(), last.copy(), np.zeros(len(ray), bool)
    for step in np.linspace(first, last, 13)[1:]:
        hit = ~found & below(step)
        high[hit], found = step[hit], found | hit
        low = np.where(found, low, step)
    for _ in range(14):
        middle = (low + high) / 2
        under = below(middle)
        low, high = np.where(under, low, middle), np.where(under, middle, high)
    nearest[down] = np.minimum(nearest[down], high)
    return nearest


def grid(low, high, beams, rays):
    elevation, azimuth = np.meshgrid(np.linspace(low, high, beams), np.linspace(-180, 180, rays, endpoint=False))
    return elevation.ravel(), azimuth.ravel()


SENSORS = (
    ("VLP-32, level", 0, lambda rng: grid(-25, 15, 32, 3750)),
    ("VLP-32, 20 degrees down", 20, lambda rng: grid(-25, 15, 32, 3750)),
    ("OS-128, 10 degrees down", 10, lambda rng: grid(-22.5, 22.5, 128, 1024)),
    ("Mid-360, 30 degrees down", 30, lambda rng: (rng.uniform(-7, 52, 20000), rng.uniform(-180, 180, 20000))))


def rigid(R, t):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, t
    return T


def judge(tilt, angles, noise):
    rng = np.random.default_rng(5)
    m = talus.Map(backend="cpu", resolution=CELL, window=10.0, max_range=12.0, clearance=1.2)
    base = np.array([0, 0, float(height(0.0, 0.0))])
    origin = base + (0, 0, MOUNT)
    t = np.deg2rad(tilt)
    T_base_sensor = rigid([[np.cos(t), 0, np.sin(t)], [0, 1, 0], [-np.sin(t), 0, np.cos(t)]], (0, 0, MOUNT))
    hits = set()
    for yaw in np.arange(SCANS) * 2 * np.pi / SCANS:
        c, s = np.cos(yaw), np.sin(yaw)
        T_map_base = rigid([[c, -s, 0], [s, c, 0], [0, 0, 1]], base)
        T_map_sensor = T_map_base @ T_base_sensor
        e, a = np.deg2rad(angles(rng))
        d = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], 1)
        r = ranges(origin, d @ T_map_sensor[:3, :3].T)
        seen = (r > 0.2) & (r < 12)
        points = d[seen] * (r[seen] + rng.normal(0, noise, seen.sum()))[:, None]
        m.update(points, T_map_sensor, T_base_sensor)
        at = (points @ T_map_sensor[:3, :3].T + origin)[:, :2]
        hits.update(map(tuple, np.floor(at / CELL).astype(int)))
    k = np.arange(-63, 63)
    i, j = (n.ravel() for n in np.meshgrid(k, k))
    near = np.hypot(i + 0.5, j + 0.5) * CELL <= REACH
    i, j = i[near], j[near]
    x, y = (i + 0.5) * CELL, (j + 0.5) * CELL
    z, sigma, origin_of = m.height_scan(rigid(np.eye(3), base), x, y)
    hit = np.array([cell in hits for cell in zip(i, j)])
    error = abs(z - height(x, y))
    return (100 * hit.mean(), 100 * np.mean(origin_of > 0), 1000 * np.sqrt(np.mean(error[hit] ** 2)),
            1000 * np.sqrt(np.mean(error**2)), 100 * np.mean(error < sigma), 100 * np.mean(error < 2 * sigma))


noise_m = float(sys.argv[1]) if len(sys.argv) > 1 else 0.0
columns = "cells with hits", "with a height", "RMSE of cells with hits", "of all cells", "within one, two deviations"
print("| sensor | " + " | ".join(columns) + " |")
print("|---|---|---|---|---|---|")
for name, tilt_deg, pattern in SENSORS:
    row = judge(tilt_deg, pattern, noise_m)
    print("| {} | {:.1f} % | {:.1f} % | {:.1f} mm | {:.1f} mm | {:.0f}, {:.0f} % |".format(name, *row))
