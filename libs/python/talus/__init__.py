"""Maps of the terrain around ground robots, in NumPy arrays.

Lengths are metres, angles radians, times seconds. Poses are (4, 4) arrays [R t; 0 1]. Row 0 of a layer is in the south,
column 0 in the west. doc/python.md leads from a folder of KITTI's to a plot.
"""

import os as _os

from ._talus import LABELS, Footprint, FrameReport, Map, __version__, plan

try:
    from ._talus import Frames as _Frames
    from ._talus import SiteFile as _SiteFile
except ImportError:  # built without what reads files
    _Frames = _SiteFile = None

__all__ = ["LABELS", "Footprint", "FrameReport", "Map", "Site", "SiteWindow", "frames", "plan"]


def _reader(cls):
    if cls is None:
        raise ImportError("this build of talus reads no files (TALUS_WITH_MRPT=OFF)")
    return cls


def frames(*sources, poses="", mounts=None, topics=(), poses_of_sensor=False):
    """The scans that `talus-import` reads, one at a time: `for f in talus.frames("bag/"): m.update(**f)`.

    sources: a folder of scans (KITTI's, .pcd, .ply, .bin), a file of one scan, or the parts of a ROS 2 bag.
    poses: a file of poses, where the source has none. mounts: {label: T_base_sensor}. topics: of a bag.
    poses_of_sensor: the poses are those of the sensor, not of the base. Scans without a pose are left out.
    Yields dicts: points (N, 3) float32, T_map_sensor, T_base_sensor, t, sensor, and times and path where points have
    times.
    """
    paths = [_os.fspath(source) for source in sources]
    topics = [topics] if isinstance(topics, str) else list(topics)
    return _reader(_Frames)(paths, _os.fspath(poses or ""), dict(mounts or {}), topics, poses_of_sensor)


class SiteWindow:
    """A rectangle of a site: its layers as views, (H, W) float32, row 0 in the south, NaN: unknown."""

    def __init__(self, site, x, y, size):
        grid = site._read(site.keys()[0])[1:]
        self._site, (min_x, min_y, self.resolution) = site, grid
        shape = site.shape
        bounds = []
        for middle, low, cells in ((x, min_x, shape[1]), (y, min_y, shape[0])):
            first = round((middle - size / 2 - low) / self.resolution)
            last = round((middle + size / 2 - low) / self.resolution)
            bounds.append((min(max(first, 0), cells), min(max(last, 0), cells)))
        (x0, x1), (y0, y1) = bounds
        self._cells = (slice(y0, y1), slice(x0, x1))
        self.shape = (y1 - y0, x1 - x0)
        #: (min x, max x, min y, max y) [m], as imshow(origin="lower") takes it.
        self.extent = tuple(
            low + self.resolution * cell for low, cell in ((min_x, x0), (min_x, x1), (min_y, y0), (min_y, y1)))

    def __getitem__(self, layer):
        return self._site[layer][self._cells]

    def keys(self):
        """Names of the layers."""
        return self._site.keys()


class Site:
    """A whole drive: the file site.tif of talus-map or talus-merge."""

    def __init__(self, path):
        self._file = _reader(_SiteFile)(_os.fspath(path))
        self._bands = {}

    @classmethod
    def open(cls, path):
        """Opens a file; layers are read when they are asked for."""
        return cls(path)

    def _read(self, layer):
        name = "ground_elevation" if layer == "ground" else layer
        if name not in self._bands:
            self._bands[name] = self._file.band(name)
        return self._bands[name]

    def __getitem__(self, layer):
        """A layer of the whole site: (H, W) float32, read-only, row 0 in the south, NaN: unknown."""
        return self._read(layer)[0]

    def keys(self):
        """Names of the layers."""
        return list(self._file.bands)

    @property
    def shape(self):
        """(H, W) of each layer."""
        return self[self.keys()[0]].shape

    @property
    def resolution(self):
        """Side of a cell [m]."""
        return self._read(self.keys()[0])[3]

    @property
    def extent(self):
        """(min x, max x, min y, max y) [m] in the map frame, as imshow(origin="lower") takes it."""
        layer, min_x, min_y, cell = self._read(self.keys()[0])
        return (min_x, min_x + cell * layer.shape[1], min_y, min_y + cell * layer.shape[0])

    def window(self, x, y, size):
        """A square of `size` metres around (x, y), cut off where the site ends."""
        return SiteWindow(self, x, y, size)
