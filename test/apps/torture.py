#!/usr/bin/env python3
"""Stops and kills the commands at random moments, fills their disk, and looks at what is left.

  test/torture.py BIN_DIR [--seconds 60] [--seed N] [--only map,sim,...]

After TERM, INT and HUP nothing hidden is left, and what was there before is whole, or the new results are. After KILL the
place has the results of one run or no file that says they are complete; the next run there tidies up. No process survives.
A file belongs to the run in whose time it was written, and is what a run that nobody disturbed wrote, where it tells no
measured times. Exit code 1 when any of this does not hold.
"""
import argparse
import collections
import filecmp
import glob
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
WORLD = """name: small
ground: [{sine: {amplitude_m: 0.15, wavelength_m: 9, yaw_deg: 15}}, {sine: {amplitude_m: 0.06, wavelength_m: 4.5, yaw_deg: 100}}]
objects: [box: {at_m: [3, 1], size_m: [0.5, 0.5, 0.5]}]
robot: {path_m: [[0, 0], [4, 1.5], [8, -1]]}
"""
SIGNALS = [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL, signal.SIGKILL]
LONGEST_S = 300  # of a run that nobody disturbs, on a machine with other things to do

Case = collections.namedtuple("Case", "name call variants seal good in_vain elsewhere timed")


def cases(out):
    """Each with two variants that write files of the same names, a call that fails once it has its output folder, and the
    files that tell measured times."""
    log, world, nav = "drive/small.rawlog", "small.yaml", HERE + "/../../datasets/worlds/nav_indoor.yaml"
    to = ["--output", out, "--quiet"]
    copy = ["--rawlog-out", "elsewhere/copy.rawlog"]
    goal, way = ["--goal", "15,0"], ["--timeout", "1", "--every", "4"]
    return [
        Case("map", ["talus-map", log, "--every", "10"] + copy + to, [["-s", "window_m=4"], ["-s", "window_m=5"]],
             "summary.json", [0], ["talus-map", "none.rawlog"] + copy + to, True,
             ["out/summary.json", "out/timing.csv"]),
        Case("sim", ["talus-sim", world, "--frames", "6", "--resolution", "0.2"] + to, [["--seed", "1"], ["--seed", "2"]],
             "small.rawlog", [0], ["talus-sim", "none.yaml"] + to, False, []),
        Case("compare", ["talus-compare", world, "--methods", "talus"] + to, [["--set", "window_m=4"], ["--set", "window_m=5"]],
             "comparison.json", [0], ["talus-compare", "none.yaml"] + to, False,
             ["out/comparison.json", "out/tables.md"]),
        Case("calibrate", ["talus-calibrate", log] + to, [["--max-range", "4"], ["--max-range", "5"]],
             "calibration.json", [0], ["talus-calibrate", "none.rawlog"] + to, False,
             ["out/calibration.json"]),
        Case("nav", ["talus-nav", nav] + goal + way + to, [["--seed", "1"], ["--seed", "2"]],
             "summary.json", [0, 5], ["talus-nav", "none.yaml"] + goal + to, False,
             ["out/log.reactivenavlog", "out/path.csv", "out/summary.json"]),
        Case("import", ["talus-import", "scans", "--poses", "poses.tum", "--output", out + "/small.rawlog", "--quiet"],
             [["--mount", "scans=0,0,1,0,0,0"], ["--mount", "scans=0,0,2,0,0,0"]],
             "small.rawlog", [0], ["talus-import", "none", "--output", out + "/small.rawlog"], False, []),
    ]


def write_scans(folder):
    """20 scans of KITTI's, of 20,000 points each."""
    rng = random.Random(1)
    points = struct.pack("<80000f", *(rng.uniform(-20, 20) for _ in range(80000)))
    os.mkdir(os.path.join(folder, "scans"))
    for number in range(20):
        with open(os.path.join(folder, "scans", f"{number:06}.bin"), "wb") as file:
            file.write(points[16 * number:] + points[:16 * number])
    with open(os.path.join(folder, "poses.tum"), "w") as file:
        file.write("0 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n")


def files_below(folder):
    """Paths from the folder, with hidden folders (which end in a slash) but not what is in them."""
    found = []
    for root, folders, files in os.walk(folder):
        found += [os.path.relpath(os.path.join(root, name), folder) for name in files]
        found += [os.path.relpath(os.path.join(root, name), folder) + "/" for name in folders if name.startswith(".")]
        folders[:] = [name for name in folders if not name.startswith(".")]
    return sorted(found)


def hidden(folder):
    return [name for name in files_below(folder) if os.path.basename(name.rstrip("/")).startswith(".")]


def session_members(session):
    """Processes of a session that run; those that have ended and wait for their parent do not."""
    found = []
    for stat in glob.glob("/proc/[0-9]*/stat"):
        try:
            with open(stat) as file:
                state, _, _, member_of = file.read().rpartition(")")[2].split()[:4]
        except OSError:
            continue
        if int(member_of) == session and state not in "ZX":
            found.append(int(stat.split("/")[2]))
    return found


class Torture:
    def __init__(self, bin_dir, folder, rng):
        self.bin_dir, self.folder, self.random = os.path.abspath(bin_dir), folder, rng
        self.failures, self.counts = 0, collections.Counter()
        self.references, self.same, self.duration_s = {}, {}, {}
        self.spans = {}  # of the runs of a case, variant after variant: when they began and ended
        self.what = ""

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def expect(self, holds, message):
        if not holds:
            self.failures += 1
            print(f"FAILED: {self.what}: {message}", flush=True)

    def start(self, call):
        command = [os.path.join(self.bin_dir, call[0])] + call[1:]
        log = open(self.path("log.txt"), "w")
        return subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                start_new_session=True)

    def finish(self, process):
        """The exit code; no process of it runs on."""
        try:
            code = process.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            self.expect(False, "hangs")
            os.killpg(process.pid, signal.SIGKILL)
            code = process.wait()
        end = time.time() + 20
        while session_members(process.pid) and time.time() < end:
            time.sleep(0.01)
        self.expect(not session_members(process.pid), "a process of it survives")
        return code

    def said(self):
        with open(self.path("log.txt"), errors="replace") as file:
            return file.read()

    def prepare(self, chosen):
        with open(self.path("small.yaml"), "w") as file:
            file.write(WORLD)
        write_scans(self.folder)
        os.mkdir(self.path("elsewhere"))
        self.what = "drive"
        made = self.finish(self.start(["talus-sim", "small.yaml", "--output", "drive", "--frames", "30"]))
        self.expect(made == 0, self.said())
        for case in chosen:
            for variant in (0, 1):
                self.what = f"{case.name}, variant {variant}"
                for repetition in (0, 1):
                    begin = time.time()
                    code = self.finish(self.start(case.call + case.variants[variant]))
                    self.expect(code in case.good, f"exit code {code}: {self.said()}")
                    self.duration_s[case.name] = time.time() - begin
                    self.keep_reference(case, variant, repetition)

    def keep_reference(self, case, variant, repetition):
        kept = self.path(f"reference_{case.name}_{variant}_{repetition}")
        os.mkdir(kept)
        for place in self.places(case):
            os.rename(self.path(place), os.path.join(kept, place))
        os.makedirs(self.path("elsewhere"), exist_ok=True)
        self.references[case.name, variant] = kept
        if repetition == 1:
            names, first = files_below(kept), kept[:-1] + "0"
            same = self.same[case.name, variant] = [name for name in names if name not in case.timed]
            differ = filecmp.cmpfiles(kept, first, same, shallow=False)[1]
            self.expect(names == files_below(first) and not differ, f"two runs write other files: {differ}")

    def places(self, case):
        return ["out", "elsewhere"] if case.elsewhere else ["out"]

    def results(self):
        return {f"out/{name}" for name in files_below(self.path("out")) if not name.endswith("/")}

    def check_copy(self):
        """The file at another place is whole; it need not be of the run of the results."""
        copy = "elsewhere/copy.rawlog"
        references = [self.references["map", variant] for variant in (0, 1)]
        self.expect(not os.path.exists(self.path(copy)) or
                    any(filecmp.cmp(self.path(copy), os.path.join(r, copy), shallow=False) for r in references),
                    f"{copy} is of no run")

    def check_whole(self, case, by_time):
        """All results are of one run; False where there are none."""
        if case.elsewhere:
            self.check_copy()
        if not os.path.exists(self.path("out", case.seal)):
            return False
        names = self.results()
        wrong = []
        for variant, span in self.spans.get(case.name, []):
            reference = self.references[case.name, variant]
            expected = {name for name in files_below(reference) if name.startswith("out/")}
            same = [name for name in self.same[case.name, variant] if name in expected]
            not_its_own = list(names ^ expected) + filecmp.cmpfiles(reference, self.folder, same, shallow=False)[1]
            if by_time:
                not_its_own += [n for n in names & expected if not span[0] <= os.stat(self.path(n)).st_mtime <= span[1]]
            if not not_its_own:
                return True
            wrong.append((variant, sorted(set(not_its_own))))
        self.expect(False, f"of no run as a whole; not of (variant, files): {wrong}")
        return True

    def strike(self, case, process, sent, begin):
        """Sends the signal at a random moment, or as soon as results are moved to their place."""
        group, twice, at_end = (self.random.random() < p for p in (0.3, 0.3, 0.4))
        wait_s, after_s = self.random.uniform(0, 1.1 * self.duration_s[case.name]), self.random.uniform(0, 0.001)
        self.what += f"{', to the group' if group else ''}{', twice' if twice else ''}"
        if at_end:
            self.what += ", as results are moved"
            while process.poll() is None and not glob.glob(self.path("out/.talus-run.*", case.seal)):
                pass
            wait_s, begin = after_s, time.time()
        while process.poll() is None and time.time() < begin + wait_s:
            time.sleep(min(0.001, wait_s))
        for _ in range(2 if twice else 1):
            if process.poll() is None:
                (os.killpg if group else os.kill)(process.pid, sent)

    def run_struck(self, case):
        variant, sent = self.random.randrange(2), self.random.choice(SIGNALS)
        self.what = f"{case.name}, variant {variant}, {sent.name}"
        had_results = os.path.exists(self.path("out", case.seal))
        time.sleep(0.02)  # more than the clock of a file system counts in
        begin = time.time() - 0.01
        process = self.start(case.call + case.variants[variant])
        self.strike(case, process, sent, time.time())
        code = self.finish(process)
        self.spans.setdefault(case.name, []).append((variant, (begin, time.time() + 0.01)))
        if sent == signal.SIGKILL:
            self.expect(code in case.good + [-sent], f"exit code {code}: {self.said()}")
            self.check_whole(case, True)
            return self.run_after_kill(case)
        self.expect(code in case.good + [128 + sent, -sent], f"exit code {code}: {self.said()}")
        self.expect(not hidden(self.folder), f"left: {hidden(self.folder)}")
        has_results = self.check_whole(case, True)
        self.expect(has_results or not had_results, "the results of before are gone")
        if code == -sent:
            self.counts["before it could be asked to stop"] += 1

    def run_after_kill(self, case):
        left = hidden(self.folder)
        self.counts["left something"] += 1 if left else 0
        while left and self.random.random() < 0.3:  # killed again
            process = self.start(case.in_vain)
            time.sleep(self.random.uniform(0, 0.1))
            process.kill()
            self.finish(process)
            left = hidden(self.folder)  # it may have tidied up, and been killed after that
        self.finish(self.start(case.in_vain))
        self.expect(not left or "killed" in self.said(), f"tidied up without a word: {self.said()}")
        self.expect(not hidden(self.folder), f"left after the next run: {hidden(self.folder)}")
        self.check_whole(case, True)

    def run_two(self, case):
        """Both variants at once into one place; often one of them is killed."""
        self.what = f"{case.name}, two at once"
        processes = [self.start(case.call + v) for v in case.variants]
        if self.random.random() < 0.7:
            self.what += ", one killed"
            time.sleep(self.random.uniform(0, 2 * self.duration_s[case.name]))
            processes[0].kill()
        codes = [self.finish(p) for p in processes]
        self.expect(codes[1] in case.good, f"exit code {codes[1]}: {self.said()}")
        self.finish(self.start(case.in_vain))
        self.expect(not hidden(self.folder), f"left: {hidden(self.folder)}")
        self.spans[case.name] = [(0, None), (1, None)]
        self.expect(self.check_whole(case, False), "no results")
        self.clear(case)

    def run_full(self, case):
        """On a disk with little room, and on one that cannot be written."""
        kib = self.random.randrange(4, 1000, 4)
        self.what = f"{case.name}, a disk of {kib} KiB"
        self.clear(case)
        os.mkdir(self.path("out"))
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kib}k", "tmpfs", self.path("out")],
                          stderr=subprocess.DEVNULL).returncode != 0:
            self.counts["full disk: skipped, needs root who may mount"] += 1
            return
        try:
            for variant in (0, 1):  # with results of before, or without
                before = self.results()
                code = self.finish(self.start(case.call + case.variants[variant]))
                told = "No space left" in self.said() or "disk full" in self.said()
                self.expect(code in case.good or (code == 1 and told and "out" in self.said()), f"exit code {code}: {self.said()}")
                self.expect(not hidden(self.folder), f"left: {hidden(self.folder)}")
                if code in case.good:
                    self.spans[case.name] = [(variant, None)]
                else:
                    self.expect(self.results() == before, "a run that failed has changed something")
                self.check_whole(case, False)
            subprocess.run(["mount", "-o", "remount,ro", self.path("out")], check=True)
            code = self.finish(self.start(case.call + case.variants[0]))
            self.expect(code not in case.good and "Read-only" in self.said(), f"read-only: exit code {code}: {self.said()}")
            self.check_whole(case, False)
            self.expect(not hidden(self.folder), f"left: {hidden(self.folder)}")
        finally:
            subprocess.run(["umount", "-l", self.path("out")], check=True)
        self.clear(case)

    def clear(self, case):
        for place in self.places(case):
            shutil.rmtree(self.path(place), ignore_errors=True)
        os.makedirs(self.path("elsewhere"), exist_ok=True)
        self.spans[case.name] = []

    def run(self, chosen, seconds):
        end = time.time() + seconds
        while time.time() < end and self.failures < 10:
            case = self.random.choice(chosen)
            self.clear(case)
            for _ in range(self.random.randrange(2, 7)):
                self.run_struck(case)
                self.counts[case.name] += 1
            if self.random.random() < 0.2:
                self.run_two(case)
                self.counts["two at once"] += 1
            if self.random.random() < 0.2:
                self.run_full(case)
                self.counts["full disk"] += 1
            self.clear(case)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 31))
    parser.add_argument("--only", default="map,sim,compare,calibrate,nav,import")
    o = parser.parse_args()
    print(f"seed {o.seed}", flush=True)
    chosen = [case for case in cases("out") if case.name in o.only.split(",")]
    with tempfile.TemporaryDirectory() as folder:
        torture = Torture(o.bin_dir, folder, random.Random(o.seed))
        torture.prepare(chosen)
        if torture.failures == 0:
            torture.run(chosen, o.seconds)
    print(", ".join(f"{what} {count}" for what, count in sorted(torture.counts.items())))
    print("all held" if torture.failures == 0 else f"{torture.failures} times something did not hold")
    return 1 if torture.failures else 0


if __name__ == "__main__":
    sys.exit(main())
