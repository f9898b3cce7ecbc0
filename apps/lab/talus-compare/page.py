#!/usr/bin/env python3
"""Writes the tables of doc/accuracy.md and of its note: runs talus-compare on worlds and real logs, and puts the results
between the markers of the pages, each table under the settings that it was made with.

  apps/lab/talus-compare/page.py TALUS_COMPARE [--only PART ...] [--worlds NAME ...] [--methods NAME,...] [--page FILE]
                                               [--note FILE]

Real logs are no part of the repository: they come from --data, the folder TALUS_TEST_DATA. Without it their tables stay
as they are, and a line says so. Exit code 1 where a comparison fails.
"""
import argparse
import math
import os
import sys

from comparisons import (CAR, CITY, LABELS, SCORES, SOURCE, SPARSE, SUGGESTED, Runs, label_arguments, mean, scaled,
                         table, write_between_markers)

WORLDS = ["branches", "demo", "ditch", "hall", "hillside", "person", "railing_gap",
          "unseen/fire_station", "unseen/mountain_hut", "unseen/water_mill"]
# Nobody looked at these while the constants of the error bars were chosen.
KEPT_BACK = ["basement", "branches", "canal_lock", "clearing", "cow_shed", "farm_lane", "museum", "office", "plaza",
             "sawmill", "skate_park", "wind_throw", "unseen/fishing_slip", "unseen/laundry", "unseen/mountain_hut",
             "unseen/water_mill"]
RISK = ["branches", "clearing", "farm_lane", "plaza", "sawmill", "wind_throw"]
TALUS = ["--methods", "talus"]
OF_NOTE = ["held_out", "bars", "risk"]  # parts of the note, the others belong to the page
FEWEST_RISKY = 100  # cells in a tenth of the risk, or it has no figure
HEIGHTS = {"measured": "measured", "fill2": "two_sided", "fill1": "one_sided", "presumed": "presumed"}
FEWEST_HEIGHTS = 100  # of a kind in a world or log, or it has no say
ORDER = ["talus", "paper", "octomap", "highest", "cucpp", "cupy", "heightgrid",  # methods
         "bgk", "min_filter", "navier_stokes", "telea"]  # fills
HELD_OUT = {"street": ("street, 90 frames", CAR), "parked": ("a robot at rest, 14 frames", SUGGESTED),
            "offroad_a": ("forest A, one scan", SUGGESTED), "offroad_b": ("forest B, one scan", SUGGESTED)}


def number(value):
    """Three figures, or a whole number; '-' for what does not apply."""
    if value is None or math.isnan(value):
        return "-"
    return f"{value:.0f}" if abs(value) >= 99.95 else f"{value:.1f}"


def in_order(found):
    return sorted(found, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER))


def without_empty_columns(heading, rows):
    keep = [c for c in range(len(heading)) if any(row[c] != "-" for row in rows)]
    return table([heading[c] for c in keep], [[row[c] for c in keep] for row in rows])


def settings(lines):
    return ["```sh", *lines, "```", ""]


def names_of(world_files):
    """Lines of a comment."""
    names = [os.path.splitext(world.removeprefix("datasets/worlds/"))[0] for world in world_files]
    lines, line = [], f"# {len(names)} world{'s' if len(names) > 1 else ''}:"
    for name in names:
        if len(line) + len(name) > 115:
            lines, line = [*lines, line], "#"
        line += " " + name
    return [*lines, line]


def bars_row(title, sources, where="all"):
    """For each kind of height: shares within one and two stated deviations, then the stated and the true deviation."""
    cells = []
    for kind in HEIGHTS.values():
        found = [source["heights"][kind][where] for source in sources if "heights" in source]
        found = [heights for heights in found if heights["n"] >= FEWEST_HEIGHTS]
        one, two, stated, true = (mean([heights[key] for heights in found])
                                  for key in ("within_1", "within_2", "told_m", "true_m"))
        cells.append("-" if one is None else
                     f"{100 * one:.0f}, {100 * two:.0f} ({number(1000 * stated)}, {number(1000 * true)})")
    return [title, *cells]


class Page:
    def __init__(self, options):
        self.options = options
        arguments = ["--methods", options.methods] if options.methods else []
        self.runs = Runs(options.command, options.data, options.output, options.jobs, arguments)
        self.parts = {"scans": self.scans, "held_out": self.held_out, "worlds": self.worlds, "budgets": self.budgets,
                      "bars": self.bars, "risk": self.risk}
        self.world_files = self.files_of(options.worlds or WORLDS)
        self.kept_back = self.files_of(options.worlds or KEPT_BACK)
        self.risk_worlds = self.files_of(options.worlds or RISK)

    @staticmethod
    def files_of(worlds):
        return [name if name.endswith(".yaml") else f"datasets/worlds/{name}.yaml" for name in worlds]

    def start(self, parts):
        """The longest first."""
        if "scans" in parts:
            for name in ("street", "mover"):
                self.start_log(name, [*CAR, *TALUS])
            for name in CITY + SPARSE:
                self.start_log(name, label_arguments(name))
        if "held_out" in parts or "bars" in parts:
            for name, (_, arguments) in {**HELD_OUT, **({"mover": ("", CAR)} if "bars" in parts else {})}.items():
                self.start_log(name, [*arguments, *TALUS])
            for name in CITY + (SPARSE if "held_out" in parts else []):
                self.start_log(name, [*label_arguments(name), *TALUS])
        if "worlds" in parts or "budgets" in parts:
            for world in self.world_files:
                self.runs.start(world, [])
        for world in (self.kept_back if "bars" in parts else []) + (self.risk_worlds if "risk" in parts else []):
            self.runs.start(world, TALUS)

    def start_log(self, name, arguments):
        if not self.options.logs or name in self.options.logs:
            self.runs.start(name, arguments)

    def scans(self):
        rows = []
        for title, names in {"city": CITY, "sparse": SPARSE, "mover": ["mover"], "street": ["street"]}.items():
            found = [self.runs.of(name)["real_logs"][0]["methods"] for name in names if name in self.runs.started]
            for method in in_order(found[0] if found else []):
                means = [mean([log[method][key] for log in found]) for key in LABELS.values()]
                rows.append([title, f"`{method}`", *(number(scaled("", m)) for m in means)])
        return settings([
            "# NAME, CAR: city_t00, _t08, _t16, _v02, car; sparse_t12, _t18, _t30, _v25612, nuscenes_car",
            "talus-compare DATA/NAME.rawlog --truth DATA/NAME_truth.tif --config datasets/configs/CAR.ini",
            "# NAME: mover, street",
            "talus-compare DATA/NAME.rawlog --config datasets/configs/car.ini --methods talus",
        ]) + without_empty_columns(["scans", "method", *LABELS], rows)

    def held_out(self):
        rows, fills = [], []
        groups = {title: [name] for name, (title, _) in HELD_OUT.items()} | {"city": CITY, "sparse": SPARSE}
        for title, names in groups.items():
            found = [self.runs.of(name)["held_out"][0] for name in names if name in self.runs.started]
            if not found:
                continue
            fills = in_order(found[0]["fills"])
            errors = [[mean([log["fills"][fill][f"all_{key}_m"] for log in found]) for key in ("rmse", "p95", "median")]
                      for fill in fills]
            rows.append([title, *(", ".join(number(scaled("_m", e)) for e in fill) for fill in errors),
                         number(scaled("", mean([log["not_ground"] for log in found])))])
        return settings([
            "talus-compare DATA/street.rawlog --config datasets/configs/car.ini --methods talus",
            "# NAME: parked, offroad_a, offroad_b",
            "talus-map DATA/NAME.rawlog --suggest > NAME.ini",
            "talus-compare DATA/NAME.rawlog --config NAME.ini --methods talus",
            "# city and sparse: as above, --methods talus",
        ]) + table(["log", *(f"`{f}`" for f in fills), "not ground, %"], rows)

    def worlds(self):
        found = [self.runs.of(world)["worlds"][0]["methods"] for world in self.world_files]
        rows = []
        for method in in_order(found[0]):
            means = [mean([world[method].get(key) for world in found]) for key in SCORES.values()]
            rows.append([f"`{method}`", *(number(scaled(k, m)) for k, m in zip(SCORES.values(), means))])
        return settings(["talus-compare datasets/worlds/NAME.yaml", *names_of(self.world_files)]) + \
            without_empty_columns(["method", *SCORES], rows)

    def budgets(self):
        verdicts = [budget["verdict"] for world in self.world_files
                    for budget in self.runs.of(world)["worlds"][0].get("budgets", [])]
        failed = verdicts.count("fail")
        return [f"Of {failed + verdicts.count('pass')} budgets that were judged in these worlds {failed} do not hold."]

    def bars(self):
        worlds = [self.runs.of(world)["worlds"][0] for world in self.kept_back]
        rows = [bars_row(f"all {len(worlds)} worlds", worlds), bars_row("near the robot", worlds, "near"),
                bars_row("far from it", worlds, "far")]
        for sensor in sorted({world["sensor"] for world in worlds}):
            of_sensor = [world for world in worlds if world["sensor"] == sensor]
            rows.append(bars_row(f"{sensor}, {len(of_sensor)} world{'s' if len(of_sensor) > 1 else ''}", of_sensor))
        titles = {name: title for name, (title, _) in HELD_OUT.items()} | {"mover": "traffic, 29 frames"}
        for name, title in titles.items():
            if name in self.runs.started:
                rows.append(bars_row(title, self.runs.of(name)["held_out"]))
        city = [self.runs.of(name)["held_out"][0] for name in CITY if name in self.runs.started]
        if city:
            rows.append(bars_row(f"city, mean of {len(city)} single scans", city))
        return settings(["talus-compare datasets/worlds/NAME.yaml --methods talus",
                         *names_of(self.kept_back),
                         "talus-compare DATA/mover.rawlog --config datasets/configs/car.ini --methods talus",
                         "# and the logs of the held-out beams as above"]) + \
            without_empty_columns(["heights", *HEIGHTS], rows)

    def risk(self):
        found = [self.runs.of(world)["worlds"][0].get("risk", []) for world in self.risk_worlds]
        rows = []
        for tenth in range(10):
            cells, impassable = (sum(world[tenth][key] for world in found if world) for key in ("n", "impassable"))
            if cells >= FEWEST_RISKY:
                rows.append([f"{10 * tenth} to {10 * tenth + 10}", f"{cells:.0f}", number(100 * impassable / cells)])
        return settings(["talus-compare datasets/worlds/NAME.yaml --methods talus", *names_of(self.risk_worlds)]) + \
            table(["stated risk, %", "cells", "impassable, %"], rows)

    def write(self, parts):
        texts = {part: "\n".join(self.parts[part]()) for part in parts}
        for page, of_page in ((self.options.page, [part for part in parts if part not in OF_NOTE]),
                              (self.options.note, [part for part in parts if part in OF_NOTE])):
            if of_page:
                write_between_markers(page, {part: texts[part] for part in of_page}, "./dev compare --page")
                print(f"page: wrote {', '.join(of_page)} of {page}", file=sys.stderr)


def main():
    parts = ["scans", "held_out", "worlds", "budgets", "bars", "risk"]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", help="talus-compare")
    parser.add_argument("--page", default=os.path.join(SOURCE, "doc/accuracy.md"), help="page to write")
    parser.add_argument("--note", default=os.path.join(SOURCE, "doc/notes/accuracy.md"), help="page of the details")
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
        wanted = [part for part in wanted if part not in ("scans", "held_out", "bars")]
        print(f"page: no street.rawlog in {options.data} (TALUS_TEST_DATA): tables of real logs stay as they are",
              file=sys.stderr)
    os.makedirs(options.output, exist_ok=True)
    page = Page(options)
    page.start(wanted)
    page.write(wanted)


if __name__ == "__main__":
    main()
