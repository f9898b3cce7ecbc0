#!/usr/bin/env python3
"""Writes the tables of doc/accuracy.md: runs talus-compare on worlds and real logs, and puts what it found between the
markers of the page, each table under the settings that it was made with.

  apps/lab/talus-compare/page.py TALUS_COMPARE [--only PART ...] [--worlds NAME ...] [--methods NAME,...] [--page FILE]

Real logs are no part of the repository: they come from --data, the folder TALUS_TEST_DATA. Without it their tables stay
as they are, and a line says so. Exit code 1 where a comparison fails.
"""
import argparse
import concurrent.futures
import json
import math
import os
import re
import statistics
import subprocess
import sys

SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../.."))
CAR = ["--config", "datasets/configs/car.ini"]
WORLDS = ["branches", "demo", "ditch", "hall", "hillside", "person", "railing_gap",
          "unseen/fire_station", "unseen/mountain_hut", "unseen/water_mill"]
ORDER = ["talus", "paper", "octomap", "highest", "cucpp", "cupy", "heightgrid",  # methods
         "bgk", "min_filter", "navier_stokes", "telea"]  # fills
CITY = ["city_t00", "city_t08", "city_t16", "city_v02"]
SPARSE = ["sparse_t12", "sparse_t18", "sparse_t30", "sparse_v25612"]
SUGGESTED = ["--config", "{output}/{name}.ini"]  # what talus-map --suggest says of the log
HELD_OUT = {"street": ("street, 90 frames", CAR), "parked": ("a robot at rest, 14 frames", SUGGESTED),
            "offroad_a": ("forest A, one scan", SUGGESTED), "offroad_b": ("forest B, one scan", SUGGESTED)}
SCORES = {"ground mm": "measured_ground_rmse_m", "fill2 mm": "two_sided_seen_rmse_m", "fill1 mm": "one_sided_rmse_m",
          "hang pass": "hanging_passable", "obst": "obstacle_blocked", "free": "free_passable", "leak": "leak",
          "reach": "reach", "mover": "mover_freed", "posts": "posts_kept", "ditch": "ditch_found"}
LABELS = {"precision": "precision", "recall": "recall", "F1": "f1", "obst": "obstacle_blocked", "low": "low_blocked",
          "free": "ground_passable", "left": "left_blocked", "unjudged": "unjudged",
          "fill2 unjudged": "two_sided_unjudged"}


class Runs:
    """Comparisons, each made once and by several at a time."""

    def __init__(self, options):
        self.options = options
        self.pool = concurrent.futures.ThreadPoolExecutor(options.jobs)
        self.started = {}

    def start(self, source, arguments):
        """`source`: a world by its file, or a log by its name in the folder of data."""
        if source in self.started:
            return
        is_world = source.endswith(".yaml")
        name = os.path.splitext(os.path.basename(source))[0]
        file = source if is_world else os.path.join(self.options.data, source + ".rawlog")
        output = os.path.join(self.options.output, name)
        command = [self.options.command, file, *arguments, "--quiet", "--output", output]
        if self.options.methods and "--methods" not in arguments:
            command += ["--methods", self.options.methods]
        self.started[source] = self.pool.submit(self.run, command, output)

    def run(self, command, output):
        print("page: " + " ".join(command[1:]), file=sys.stderr, flush=True)
        if f"{output}.ini" in command:
            self.suggest(command[1], f"{output}.ini")
        done = subprocess.run(command, cwd=SOURCE, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise SystemExit(f"page: {' '.join(command)} failed: {done.stderr.strip()}")
        with open(os.path.join(output, "comparison.json"), encoding="utf-8") as file:
            return json.load(file)

    def suggest(self, log, ini):
        talus_map = os.path.join(os.path.dirname(self.options.command), "talus-map")
        with open(ini, "w", encoding="utf-8") as file:
            subprocess.run([talus_map, log, "--suggest"], stdout=file, check=True)

    def of(self, source):
        return self.started[source].result()


def number(value):
    """Three figures, or a whole number; '-' for what does not apply."""
    if value is None or math.isnan(value):
        return "-"
    return f"{value:.0f}" if abs(value) >= 99.95 else f"{value:.1f}"


def in_order(found):
    return sorted(found, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER))


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


def without_empty_columns(heading, rows):
    keep = [c for c in range(len(heading)) if any(row[c] != "-" for row in rows)]
    return table([heading[c] for c in keep], [[row[c] for c in keep] for row in rows])


def settings(lines):
    return ["```sh", *lines, "```", ""]


def label_arguments(name):
    return ["--truth", f"{{data}}/{name}_truth.tif", *CAR]


class Page:
    def __init__(self, options):
        self.options = options
        self.runs = Runs(options)
        self.parts = {"scans": self.scans, "held_out": self.held_out, "worlds": self.worlds, "budgets": self.budgets}
        chosen = options.worlds or WORLDS
        self.world_files = [name if name.endswith(".yaml") else f"datasets/worlds/{name}.yaml" for name in chosen]

    def start(self, parts):
        """The longest first."""
        if "held_out" in parts or "scans" in parts:
            self.start_log("street", [*CAR, "--methods", "talus"])
        if "scans" in parts:
            self.start_log("mover", CAR)
            for name in CITY + SPARSE:
                self.start_log(name, label_arguments(name))
        if "held_out" in parts:
            for name, (_, arguments) in HELD_OUT.items():
                self.start_log(name, [*arguments, "--methods", "talus"])
        if "worlds" in parts or "budgets" in parts:
            for world in self.world_files:
                self.runs.start(world, [])

    def start_log(self, name, arguments):
        if not self.options.logs or name in self.options.logs:
            self.runs.start(name, [a.format(data=self.options.data, output=self.options.output, name=name)
                                    for a in arguments])

    def scans(self):
        rows = []
        for title, names in {"city": CITY, "sparse": SPARSE, "mover": ["mover"], "street": ["street"]}.items():
            found = [self.runs.of(name)["real_logs"][0]["methods"] for name in names if name in self.runs.started]
            for method in in_order(found[0] if found else []):
                means = [mean([log[method][key] for log in found]) for key in LABELS.values()]
                rows.append([title, f"`{method}`", *(number(scaled("", m)) for m in means)])
        return settings([
            "# NAME: city_t00, _t08, _t16, _v02; sparse_t12, _t18, _t30, _v25612",
            "talus-compare DATA/NAME.rawlog --truth DATA/NAME_truth.tif --config datasets/configs/car.ini",
            "talus-compare DATA/mover.rawlog --config datasets/configs/car.ini",
            "talus-compare DATA/street.rawlog --config datasets/configs/car.ini --methods talus",
        ]) + without_empty_columns(["scans", "method", *LABELS], rows)

    def held_out(self):
        rows, commands = [], []
        fills = []
        for name, (title, arguments) in HELD_OUT.items():
            if name not in self.runs.started:
                continue
            commands += [f"talus-map DATA/{name}.rawlog --suggest > {name}.ini"] if arguments is SUGGESTED else []
            told = [a.format(output=".", name=name).removeprefix("./") for a in arguments]
            commands.append(" ".join(["talus-compare", f"DATA/{name}.rawlog", *told, "--methods talus"]))
            found = self.runs.of(name)["held_out"][0]["fills"]
            fills = in_order(found)
            errors = [[f["all_rmse_m"], f["all_p95_m"], f["all_median_m"]] for f in map(found.get, fills)]
            rows.append([title, *(", ".join(number(scaled("_m", e)) for e in fill) for fill in errors)])
        return settings(commands) + table(["log", *(f"`{f}`" for f in fills)], rows)

    def worlds(self):
        found = [self.runs.of(world)["worlds"][0]["methods"] for world in self.world_files]
        rows = []
        for method in in_order(found[0]):
            means = [mean([world[method].get(key) for world in found]) for key in SCORES.values()]
            rows.append([f"`{method}`", *(number(scaled(k, m)) for k, m in zip(SCORES.values(), means))])
        names = [os.path.splitext(world.removeprefix("datasets/worlds/"))[0] for world in self.world_files]
        lines, line = [], f"# {len(names)} world{'s' if len(names) > 1 else ''}:"
        for name in names:
            if len(line) + len(name) > 115:
                lines, line = [*lines, line], "#"
            line += " " + name
        return settings(["talus-compare datasets/worlds/NAME.yaml", *lines, line]) + \
            without_empty_columns(["method", *SCORES], rows)

    def budgets(self):
        judged = {}
        for world in self.world_files:
            for budget in self.runs.of(world)["worlds"][0].get("budgets", []):
                if budget["verdict"] != "not applicable":
                    judged.setdefault(budget["name"], []).append(budget)
        rows = []
        for name, budgets in judged.items():
            fails = sum(b["verdict"] == "fail" for b in budgets)
            if fails > 0:
                limit = ("<= " if budgets[0]["at_most"] else ">= ") + f"{budgets[0]['limit']:.3g}"
                median = f"{statistics.median_low([b['value'] for b in budgets]):.3g}"
                rows.append([f"`{name}`", limit, str(len(budgets)), str(fails), median])
        total = sum(map(len, judged.values()))
        failed = sum(int(row[3]) for row in rows)
        return [f"Of {total} budgets that were judged in these worlds {failed} do not hold:", ""] + \
            table(["budget", "limit", "judged", "fail", "median"], rows)

    def write(self, parts):
        texts = {part: "\n".join(self.parts[part]()) for part in parts}
        with open(self.options.page, encoding="utf-8") as file:
            page = file.read()
        for part, text in texts.items():
            begin, end = f"<!-- {part}: written by ./dev compare --page -->", f"<!-- {part}: end -->"
            pattern = re.escape(begin) + r"\n.*?" + re.escape(end)
            if not re.search(pattern, page, re.DOTALL):
                raise SystemExit(f"page: {self.options.page} has no lines '{begin}' and '{end}': put them where its "
                                 "table belongs")
            page = re.sub(pattern, lambda _: f"{begin}\n\n{text}\n\n{end}", page, flags=re.DOTALL)
        beside = self.options.page + ".part"
        with open(beside, "w", encoding="utf-8") as file:
            file.write(page)
        os.replace(beside, self.options.page)
        print(f"page: wrote {', '.join(texts)} of {self.options.page}", file=sys.stderr)


def main():
    parts = ["scans", "held_out", "worlds", "budgets"]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", help="talus-compare")
    parser.add_argument("--page", default=os.path.join(SOURCE, "doc/accuracy.md"), help="page to write")
    parser.add_argument("--data", default=os.environ.get("TALUS_TEST_DATA", os.path.join(SOURCE, "../shared/data")),
                        help="folder of the real logs; default: TALUS_TEST_DATA")
    parser.add_argument("--output", default=os.path.join(SOURCE, "out/compare_page"), help="folder of all files")
    parser.add_argument("--only", nargs="+", choices=parts, default=parts, help="parts of the page")
    parser.add_argument("--worlds", nargs="+", help="names or files, instead of those of the page")
    parser.add_argument("--logs", nargs="+", help="names, instead of all real logs")
    parser.add_argument("--methods", default="", help="of worlds and scans, instead of all")
    parser.add_argument("--jobs", type=int, default=max(1, (os.cpu_count() or 2) // 2), help="comparisons at a time")
    options = parser.parse_args()
    options.command, options.data = os.path.abspath(options.command), os.path.abspath(options.data)
    options.output = os.path.abspath(options.output)
    wanted = options.only
    if not os.path.exists(os.path.join(options.data, "street.rawlog")):
        wanted = [part for part in wanted if part not in ("scans", "held_out")]
        print(f"page: no street.rawlog in {options.data} (TALUS_TEST_DATA): tables of real logs stay as they are",
              file=sys.stderr)
    os.makedirs(options.output, exist_ok=True)
    page = Page(options)
    page.start(wanted)
    page.write(wanted)


if __name__ == "__main__":
    main()
