#!/usr/bin/env python3
"""talus-batch on the cores of this machine and on a Slurm of two nodes: the same bytes, whatever is killed on the way.

  test/cluster/batch.py BIN_DIR [--laptop]

Six generated drives that overlap or do not, and a log that cannot be mapped. On the laptop the run is killed in the middle
and started again; on Slurm a node dies in the middle. --laptop: without Slurm. Exit code 1 when anything does not hold, 77
with a reason where it cannot be tried.
"""
import argparse
import filecmp
import glob
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import slurm

HERE = os.path.dirname(os.path.abspath(__file__))
BATCH = os.path.join(HERE, "../../apps/talus-batch/talus-batch")
CANNOT_BE_TRIED = 77
LONGEST_S = 150  # of one run, on a machine with other things to do
DRIVES = 6
NEAR = 3  # of them
CORES = 2
WORLD = """name: drive
seed: {seed}
ground: [{{sine: {{amplitude_m: 0.15, wavelength_m: 9, yaw_deg: 15}}}}, {{sine: {{amplitude_m: 0.06, wavelength_m: 4.5, yaw_deg: 100}}}}]
objects: [box: {{at_m: [3, 1], size_m: [0.5, 0.5, 0.5]}}, box: {{at_m: [43, -1], size_m: [0.5, 0.5, 0.9]}}]
robot: {{path_m: [[{x}, {y}], [{to_x}, {to_y}]]}}
"""


class Test:
    def __init__(self, bin_dir, folder):
        self.bin_dir, self.folder, self.failures = os.path.abspath(bin_dir), folder, 0
        self.logs = os.path.join(folder, "all logs")

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def expect(self, holds, message):
        if not holds:
            self.failures += 1
            print(f"FAILED: {message}", flush=True)

    def make_logs(self):
        """Three cross each other near the origin, three are 40 m away or more, one of them 30 km; two are called the same."""
        for i in range(DRIVES):
            x, y = (0.8 * i, 0.4 * i - 1) if i < NEAR else (40 + 15 * (i - NEAR) if i < DRIVES - 1 else 30000, 0)
            name = "drive" if i in (0, NEAR) else f"drive_{i}"
            folder = os.path.join(self.logs, "near" if i < NEAR else "far")
            world = self.path(f"{name}.yaml")
            with open(world, "w") as file:
                file.write(WORLD.format(seed=i + 1, x=x, y=y, to_x=x + 6, to_y=y + 1 - 0.5 * i if i < NEAR else y + 2))
            subprocess.run([os.path.join(self.bin_dir, "talus-sim"), world, "--output", folder, "--frames", "60", "--resolution",
                            "0.5", "--quiet"], check=True)
        shutil.copyfile(os.path.join(self.logs, "near/drive.rawlog"), os.path.join(self.logs, "no_poses.rawlog"))

    def start(self, output, *options, env=None):
        """A session of its own, so that all of it can be killed."""
        call = [sys.executable, BATCH, self.logs, "--output", self.path(output), "--bin", self.bin_dir, "--group", "4", *options]
        with open(self.path(output + ".txt"), "a") as said:
            return subprocess.Popen(call, stdout=said, stderr=said, stdin=subprocess.DEVNULL, start_new_session=True,
                                    cwd=self.folder, env=dict(env or os.environ, CI="true"))  # which asks Slurm more often

    def finish(self, run):
        try:
            return run.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            kill_session(run)
            return "none: it hangs"

    def said(self, output):
        with open(self.path(output + ".txt"), errors="replace") as file:
            return file.read()

    def mapped(self, output):
        return glob.glob(self.path(output, "maps/*/summary.json"))

    def wait_until(self, holds, run):
        """False where the run has ended before, or hangs."""
        end = time.monotonic() + LONGEST_S
        while run.poll() is None and time.monotonic() < end:
            if holds():
                return True
            time.sleep(0.05)
        return False

    def check_report(self, output, code):
        self.expect(code == 1, f"{output}: exit code {code}, and a log cannot be mapped:\n{self.said(output)}")
        try:
            with open(self.path(output, "maps/no_poses.json")) as file:
                told = json.load(file)
            with open(self.path(output, "report.html")) as file:
                page = file.read()
        except OSError as error:
            self.expect(False, f"{output}: {error}\n{self.said(output)}")
            return
        self.expect("no poses" in told.get("error", ""), f"{output}: does not tell why: {told}")
        self.expect(f"{DRIVES} of {DRIVES + 1} logs mapped" in page and "no poses" in page, f"{output}: the report: {page}")
        self.expect('href="maps/near_drive/site.png"' in page, f"{output}: the report has no link to the map of a log: {page}")
        said = self.said(output)
        self.expect(said.count("no poses") == 1 and "Error in rule" not in said, f"{output}: a bad log is one line: {said}")
        self.expect(os.path.exists(self.path(output, "site.png")), f"{output}: there is no picture")
        self.expect('<a href="site.html"><img' in page, f"{output}: the picture does not lead to the page: {page}")
        self.expect(not glob.glob(self.path(output, "**/*.new"), recursive=True), f"{output}: files are left behind")

    def check_same(self, one, other):
        """All maps, to the last byte. Only what tells times and ways may differ."""
        names = {kind: maps_below(self.path(kind)) for kind in (one, other)}
        self.expect(names[one] == names[other], f"maps of {one} and {other}: {names}")
        self.expect({"site.tif", "site_island_1.tif", "maps/near_drive/site.tif", "maps/far_drive/site.tif"} <= names[one], f"maps: {names[one]}")
        differ, lost = filecmp.cmpfiles(self.path(one), self.path(other), names[one], shallow=False)[1:]
        self.expect(not differ and not lost, f"{one} and {other} differ in {differ + lost}")

    def on_laptop(self):
        run = self.start("laptop", "--cores", str(CORES))
        in_time = self.wait_until(lambda: len(self.mapped("laptop")) >= 2, run)
        kill_session(run)
        self.expect(in_time, f"ended before it was killed:\n{self.said('laptop')}")
        kept = {path: os.stat(path).st_mtime_ns for path in glob.glob(self.path("laptop/maps/*.json")) if "no_poses" not in path}
        self.check_report("laptop", self.finish(self.start("laptop", "--cores", str(CORES))))
        anew = [path for path, time_ns in kept.items() if os.stat(path).st_mtime_ns != time_ns]
        self.expect(len(anew) <= CORES, f"not only those that were at work were mapped twice: {anew}")

    def after_repair(self):
        """The log that failed is tried again, and only what depends on it."""
        kept = {path: os.stat(path).st_mtime_ns for path in glob.glob(self.path("laptop/maps/*.json"))}
        shutil.copyfile(os.path.join(self.logs, "near/drive.tum"), os.path.join(self.logs, "no_poses.tum"))
        code = self.finish(self.start("laptop", "--cores", str(CORES)))
        anew = [os.path.basename(path) for path, time_ns in kept.items() if os.stat(path).st_mtime_ns != time_ns]
        self.expect(code == 0 and anew == ["no_poses.json"], f"after the repair: exit code {code}, made anew: {anew}")

    def on_slurm(self):
        begin = time.monotonic()
        folder = self.path("cluster")
        os.mkdir(folder)
        with slurm.Slurm(folder) as cluster:
            run = self.start("slurm", "--slurm", env=cluster.env)
            lost = []

            def a_node_dies():
                lost[:] = cluster.kill_node("n1") if len(self.mapped("slurm")) >= 2 else []
                return lost

            in_time = self.wait_until(a_node_dies, run)
            print(f"node n1 dies after {time.monotonic() - begin:.0f} s with jobs {lost}", flush=True)
            self.expect(in_time, f"ended before a node died:\n{self.said('slurm')}")
            self.check_report("slurm", self.finish(run))
            for job in lost:
                told = cluster.ask("scontrol", "show", "job", job)
                self.expect("Restarts=1" in told and "COMPLETED" in told, f"a job of the node that died: {told}")
        print(f"Slurm: {time.monotonic() - begin:.0f} s", flush=True)


def maps_below(folder):
    found = glob.glob(os.path.join(glob.escape(folder), "**/*.tif"), recursive=True)
    return {os.path.relpath(path, folder) for path in found}


def kill_session(run):
    """And those who would go on without it."""
    for stat in glob.glob("/proc/[0-9]*/stat"):
        try:
            with open(stat) as file:
                session = int(file.read().rpartition(")")[2].split()[3])
        except OSError:
            continue
        if session == run.pid:
            slurm.kill([int(stat.split("/")[2])])
    run.wait()


def skip(reason):
    print(f"NOT TESTED: {reason}")
    sys.exit(CANNOT_BE_TRIED)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir")
    parser.add_argument("--laptop", action="store_true", help="without Slurm")
    options = parser.parse_args()
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    programs = ("snakemake",) if options.laptop else ("snakemake",) + slurm.PROGRAMS
    missing = [program for program in programs if not shutil.which(program)]
    if missing:
        skip("there is no " + ", ".join(missing))
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that the cluster is ended too
    with tempfile.TemporaryDirectory(prefix="talus-batch-") as folder:
        test = Test(options.bin_dir, folder)
        test.make_logs()
        test.on_laptop()
        if not options.laptop:
            try:
                test.on_slurm()
            except slurm.CannotRun as reason:
                skip(str(reason))
            test.check_same("laptop", "slurm")
        test.after_repair()
    print("all is as it should be" if test.failures == 0 else f"{test.failures} failures")
    sys.exit(1 if test.failures else 0)


if __name__ == "__main__":
    main()
