"""Runs of talus-compare on worlds and real logs, each once and several at a time, and pages that are written from them."""
import concurrent.futures
import json
import os
import re
import statistics
import subprocess
import sys

SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../.."))
CAR = ["--config", "datasets/configs/car.ini"]
CITY = ["city_t00", "city_t08", "city_t16", "city_v02"]
NUSCENES = ["--config", "datasets/configs/nuscenes_car.ini"]
SPARSE = ["sparse_t12", "sparse_t18", "sparse_t30", "sparse_v25612"]
SUGGESTED = ["--config", "{output}/{name}.ini"]  # what talus-map --suggest says of the log
SCORES = {"ground mm": "measured_ground_rmse_m", "fill2 mm": "two_sided_seen_rmse_m", "fill1 mm": "one_sided_rmse_m",
          "hang pass": "hanging_passable", "obst": "obstacle_blocked", "free": "free_passable", "leak": "leak",
          "reach": "reach", "mover": "mover_freed", "posts": "posts_kept", "ditch": "ditch_found"}
LABELS = {"precision": "precision", "recall": "recall", "F1": "f1", "obst": "obstacle_blocked", "low": "low_blocked",
          "free": "ground_passable", "left": "left_blocked", "swept": "swept_blocked",
          "unjudged": "unjudged", "fill2 unjudged": "two_sided_unjudged"}


class Runs:
    """Comparisons, each made once and by several at a time."""

    def __init__(self, command, data, output, jobs, arguments=()):
        """`output`: folder of all files; `arguments`: of every comparison that names no --methods itself."""
        self.command, self.data, self.output, self.arguments = command, data, output, list(arguments)
        self.pool = concurrent.futures.ThreadPoolExecutor(jobs)
        self.started = {}

    def start(self, source, arguments):
        """`source`: a world by its file, or a log by its name in the folder of data. In `arguments` {data}, {output} and
        {name} stand for the folders and the name."""
        if source not in self.started:
            self.started[source] = self.pool.submit(self.run, source, arguments)

    def run(self, source, arguments):
        is_world = source.endswith(".yaml")
        name = os.path.splitext(os.path.basename(source))[0]
        file = source if is_world else os.path.join(self.data, source + ".rawlog")
        folder = self.output if is_world else os.path.join(self.output, "logs")  # a log may be called as a world is
        told = [a.format(data=self.data, output=folder, name=name) for a in arguments]
        os.makedirs(folder, exist_ok=True)
        output = os.path.join(folder, name)
        command = [self.command, file, *told, "--quiet", "--output", output]
        if "--methods" not in told:
            command += self.arguments
        print("run: " + " ".join(command[1:]), file=sys.stderr, flush=True)
        if f"{output}.ini" in command:
            self.suggest(file, f"{output}.ini")
        done = subprocess.run(command, cwd=SOURCE, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)} failed: {done.stderr.strip()}")
        with open(os.path.join(output, "comparison.json"), encoding="utf-8") as opened:
            return json.load(opened)

    def suggest(self, log, ini):
        """The configuration that talus-map prints for a log."""
        talus_map = os.path.join(os.path.dirname(self.command), "talus-map")
        told = subprocess.run([talus_map, log, "--suggest"], stdout=subprocess.PIPE, check=True).stdout
        with open(ini + ".part", "wb") as file:
            file.write(told)
        os.replace(ini + ".part", ini)

    def of(self, source):
        return self.started[source].result()


def label_arguments(name):
    return ["--truth", f"{{data}}/{name}_truth.tif", *(NUSCENES if name in SPARSE else CAR)]


def mean(values):
    known = [v for v in values if v is not None]
    return statistics.fmean(known) if known else None


def scaled(name, value):
    """Heights in mm, shares in percent."""
    return None if value is None else value * (1000 if name.endswith("_m") else 100)


def table(heading, rows):
    """Columns of names are to the left, those of figures to the right."""
    is_name = [c == 0 or any(row[c].startswith("`") for row in rows) for c in range(len(heading))]
    lines = ["| " + " | ".join(heading) + " |", "|" + "".join("---|" if name else "---:|" for name in is_name)]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def write_between_markers(page, texts, command):
    """Puts each part between its two markers in the page, which say that the command writes them."""
    with open(page, encoding="utf-8") as file:
        text = file.read()
    for part, new in texts.items():
        begin, end = f"<!-- {part}: written by {command} -->", f"<!-- {part}: end -->"
        pattern = re.escape(begin) + r"\n.*?" + re.escape(end)
        if not re.search(pattern, text, re.DOTALL):
            raise SystemExit(f"{page} has no lines '{begin}' and '{end}': put them where its table belongs")
        text = re.sub(pattern, lambda _: f"{begin}\n\n{new}\n\n{end}", text, flags=re.DOTALL)
    with open(page + ".part", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(page + ".part", page)
