#!/usr/bin/env python3
"""Measures what each rule of the map is worth: leaves it out, compares the map with itself in worlds and on real logs, and
writes the table of kernels/rules_measured.md.

  apps/lab/talus-compare/ablate.py TALUS_COMPARE [RULE ...] [--worlds NAME ...] [--situations TEST] [--instructions PROGRAM]

The programs must be of a build with -DTALUS_RULE_SWITCHES=ON: ./dev ablate makes one. What was measured is kept in one
file for each rule, by what the programs are made of, so that a run that was stopped goes on where it was, and a changed
map is measured anew. Rules that were not measured now keep their rows. Exit code 1 where a program fails.
"""
import argparse
import functools
import glob
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys

from comparisons import (CAR, CITY, LABELS, SCORES, SOURCE, SPARSE, SUGGESTED, Runs, label_arguments, mean, scaled, table,
                         write_between_markers)

COMMAND = "./dev ablate"
VARIABLE = "TALUS_WITHOUT_RULES"
LOGS = {**{name: label_arguments(name) for name in CITY + SPARSE}, "mover": CAR, "street": CAR,
        **{name: SUGGESTED for name in ("parked", "offroad_a", "offroad_b")}}
FIGURES = {**SCORES, "hang wrong": "hanging_wrong"}  # of worlds
NOTICED = {"points": 0.15, "%": 1.0, "mm": 0.5}  # less is no change
SHOWN = 4  # changes in a cell of the table
HEADING = ["rule", "what it is", "rows", "worlds", "real", "situations", "S1", "run"]


def switches():
    """Number and name of each rule that has a switch."""
    with open(os.path.join(SOURCE, "kernels/rule_switches.h"), encoding="utf-8") as file:
        found = re.findall(r"RULE\(k(\w+), (\d+)\)", file.read())
    return {int(number): re.sub(r"(?<!^)([A-Z])", r" \1", name).lower() for name, number in found}


@functools.lru_cache(maxsize=None)
def digest_of(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def digest(files, *words):
    there = [path for path in (os.path.join(SOURCE, f) for f in files) if os.path.isfile(path)]
    told = [digest_of(path) for path in there] + list(words)
    return hashlib.sha256("\n".join(told).encode()).hexdigest()[:12]


def found_in(comparison):
    """What a row needs to know of one comparison."""
    kept = {}
    for world in comparison["worlds"]:
        if world["truth"]:
            kept["figures"] = {name: world["methods"]["talus"].get(key) for name, key in FIGURES.items()}
            kept["fails"] = {b["name"]: b["verdict"] == "fail" for b in world["budgets"] if b["verdict"] != "not applicable"}
    for log in comparison["real_logs"]:
        kept["labels"] = {name: log["methods"]["talus"][key] for name, key in LABELS.items()}
    for log in comparison["held_out"]:
        kept["held out"] = log["fills"]["talus"]["all_rmse_m"]
    return kept


class Ablation:
    def __init__(self, options):
        self.options = options
        libraries = [f for f in sorted(glob.glob(os.path.join(os.path.dirname(options.command), "../lib/libtalus_*.a")))
                     if "talus_app" not in f]  # which has the commit, but nothing that is measured
        self.programs = [p for p in (options.situations, options.instructions) if p]
        self.folder = os.path.join(options.output, digest(libraries + self.programs))
        os.makedirs(self.folder, exist_ok=True)
        self.sources = {world: [] for world in self.world_files()}
        for name in self.log_names():
            ini = os.path.join(self.folder, name + ".ini")
            self.sources[name] = [a.format(data=options.data, output=self.folder, name=name) for a in LOGS[name]]
            if ini in self.sources[name] and not os.path.exists(ini):
                self.runs(None, self.folder).suggest(self.log_file(name), ini)
        self.digests = {source: digest([source, self.log_file(source), *arguments], *arguments)
                        for source, arguments in self.sources.items()}
        self.run = digest([], self.folder, *sorted(self.digests.values()))[:7]

    def world_files(self):
        if self.options.worlds is None:
            found = glob.glob("datasets/worlds/*.yaml", root_dir=SOURCE) + \
                glob.glob("datasets/worlds/unseen/*.yaml", root_dir=SOURCE)
            return [os.path.join(SOURCE, world) for world in sorted(found)]
        return [os.path.abspath(w) if w.endswith(".yaml") else os.path.join(SOURCE, f"datasets/worlds/{w}.yaml")
                for w in self.options.worlds]

    def log_names(self):
        wanted = list(LOGS) if self.options.logs is None else self.options.logs
        there = [name for name in wanted if os.path.exists(self.log_file(name))]
        if len(there) < len(wanted):
            print(f"ablate: {len(wanted) - len(there)} logs are not in {self.options.data} (TALUS_TEST_DATA): left out",
                  file=sys.stderr)
        return there

    def log_file(self, name):
        return os.path.join(self.options.data, name + ".rawlog")

    def file_of(self, rule):
        return os.path.join(self.folder, "all_rules.json" if rule is None else f"without_{rule}.json")

    def kept(self, rule):
        if not os.path.exists(self.file_of(rule)):
            return {}
        with open(self.file_of(rule), encoding="utf-8") as file:
            return json.load(file)

    def keep(self, rule, found):
        with open(self.file_of(rule) + ".part", "w", encoding="utf-8") as file:
            json.dump(found, file, indent=1, sort_keys=True)
        os.replace(self.file_of(rule) + ".part", self.file_of(rule))

    def runs(self, rule, scratch):
        without = [] if rule is None else ["--without", str(rule)]
        return Runs(self.options.command, self.options.data, scratch, self.options.jobs, ["--methods", "talus", *without])

    def measure(self, rule):
        """All that is missing of one rule, None: of all rules; each part is kept as soon as it is there."""
        found = self.kept(rule)
        scratch = os.path.join(self.folder, f"scratch_{rule}")
        os.makedirs(scratch, exist_ok=True)
        runs = self.runs(rule, scratch)
        missing = [s for s in self.sources if found.get(s, {}).get("of") != self.digests[s]]
        for source in missing:
            runs.start(source, self.sources[source])
        try:
            for source in missing:
                found[source] = {"of": self.digests[source], **found_in(runs.of(source))}
                self.keep(rule, found)
        finally:  # what did not begin does not begin any more
            runs.pool.shutdown(cancel_futures=True)
        for name, program, count in (("situations", self.options.situations, failing_tests),
                                     ("instructions", self.options.instructions, instructions_of_s1)):
            if program and name not in found:
                found[name] = count(program, rule, scratch)
                self.keep(rule, found)
        shutil.rmtree(scratch)
        return found

    def worlds(self):
        return [source for source in self.sources if source.endswith(".yaml")]

    def logs(self):
        return [source for source in self.sources if not source.endswith(".yaml")]


def with_rules_off(rule):
    return {**os.environ, VARIABLE: "" if rule is None else str(rule)}


def failing_tests(program, rule, scratch):
    report = os.path.join(scratch, "situations.json")
    done = subprocess.run([program, "--gtest_brief=1", f"--gtest_output=json:{report}"], env=with_rules_off(rule),
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1) or not os.path.exists(report):
        raise SystemExit(f"{program} failed: {done.stderr.strip()}")
    with open(report, encoding="utf-8") as file:
        suites = json.load(file)["testsuites"]
    return sorted(f"{suite['name']}.{test['name']}" for suite in suites for test in suite["testsuite"]
                  if test.get("failures"))


def instructions_of_s1(program, rule, _):
    """Millions of one frame."""
    done = subprocess.run([program] + ([] if rule is None else [str(rule)]), capture_output=True, text=True)
    found = re.search(r"sum ([0-9.]+) M", done.stdout)
    if done.returncode != 0 or not found:
        raise SystemExit(f"{program} failed: {done.stderr.strip()}")
    return float(found[1])


def pairs(all_rules, without, sources, part):
    """The same part of both for each source that has it."""
    for source in sources:
        before, after = all_rules[source].get(part), without[source].get(part)
        if before is not None and after is not None:
            yield source, before, after


def largest(changes):
    """(name, by how much, unit) in words, the largest first; what is too small to notice is left out."""
    weighed = sorted(((abs(by) / NOTICED[unit], name, by, unit) for name, by, unit in changes), reverse=True)
    words = [f"{name} {by:+.1f}" + ("" if unit == "points" else f" {unit}") for weight, name, by, unit in weighed
             if weight >= 1]
    return ", ".join(words[:SHOWN]) or "-"


def changes_of_worlds(all_rules, without, worlds):
    """Of the means over the worlds that have the figure both ways: shares in points, errors in percent."""
    for name, key in FIGURES.items():
        both = [(before[name], after[name]) for _, before, after in pairs(all_rules, without, worlds, "figures")
                if before[name] is not None and after[name] is not None]
        if not both:
            continue
        before, after = mean([b for b, _ in both]), mean([a for _, a in both])
        if key.endswith("_m"):
            yield name.removesuffix(" mm"), 100 * (after / before - 1) if before else 0, "%"
        else:
            yield name, 100 * (after - before), "points"


def changes_of_logs(all_rules, without, logs):
    for group, names in {"city": CITY, "sparse": SPARSE, "mover": ["mover"], "street": ["street"]}.items():
        found = list(pairs(all_rules, without, [name for name in names if name in logs], "labels"))
        for name in LABELS if found else []:
            if name != "F1":
                before, after = mean([b[name] for _, b, _ in found]), mean([a[name] for _, _, a in found])
                if before is not None and after is not None:
                    yield f"{group} {name}", scaled("", after - before), "points"
    for log in ("street", "parked", "offroad_a", "offroad_b"):
        for _, before, after in pairs(all_rules, without, [log] if log in logs else [], "held out"):
            yield f"{log} held out", scaled("_m", after - before), "mm"


def rows_of(all_rules, without, worlds):
    """Rows lost and won, and in how many worlds."""
    lost, won = set(), set()
    for world, before, after in pairs(all_rules, without, worlds, "fails"):
        for name in before.keys() & after.keys():
            if before[name] != after[name]:
                (lost if after[name] else won).add((world, name))
    concerned = {world for world, _ in lost | won}
    return f"{len(lost)}/{len(won)}" + (f" in {len(concerned)}" if concerned else "")


def situations_of(all_rules, without):
    if "situations" not in without:
        return "-"
    failing = [name for name in without["situations"] if name not in all_rules["situations"]]
    told = ", ".join(f"`{name}`" for name in failing[:2])
    return f"{len(failing)}: {told}" + (" ..." if len(failing) > 2 else "") if failing else "-"


def row(rule, name, ablation, all_rules, without):
    cost = "-"
    if "instructions" in without:
        cost = f"{100 * (without['instructions'] / all_rules['instructions'] - 1):+.1f} %"
    worlds, logs = ablation.worlds(), ablation.logs()
    return [str(rule), name, rows_of(all_rules, without, worlds), largest(changes_of_worlds(all_rules, without, worlds)),
            largest(changes_of_logs(all_rules, without, logs)), situations_of(all_rules, without), cost, f"`{ablation.run}`"]


def note(ablation, all_rules):
    """What the rows of a run were made with."""
    commit = subprocess.run(["git", "rev-parse", "--short=10", "HEAD"], cwd=SOURCE, capture_output=True, text=True)
    worlds = [os.path.splitext(os.path.basename(world))[0] for world in ablation.worlds()]
    fails = [fail for world in ablation.worlds() for fail in all_rules[world]["fails"].values()]
    names = f" ({' '.join(worlds)})" if ablation.options.worlds is not None else ""
    words = f"- `{ablation.run}`: commit {commit.stdout.strip() or '-'}, {len(worlds)} worlds{names}, logs: " + \
        f"{' '.join(ablation.logs()) or 'none'}. With all rules {sum(fails)} of {len(fails)} rows fail"
    if "situations" in all_rules:
        words += f", {len(all_rules['situations'])} situations fail"
    if "instructions" in all_rules:
        words += f", S1 takes {all_rules['instructions']:.2f} M instructions"
    return words + "."


def wrapped(line, width=118):
    lines = [""]
    for word in line.split(" "):
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append(" ")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


def rows_before(page):
    """Rows of rules and notes of runs that the page has already."""
    with open(page, encoding="utf-8") as file:
        text = file.read()
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in text.splitlines() if line[:1] == "|"]
    rows = {int(c[0]): c for c in cells if c[0].isdigit() and len(c) == len(HEADING)}
    notes = {found[1]: " ".join(found[0].split()) for found in re.finditer(r"^- (`\w+`):(?:.|\n(?=  \S))*", text, re.MULTILINE)}
    return rows, notes


def write(page, ablation, all_rules, measured):
    rows, notes = rows_before(page)
    notes[f"`{ablation.run}`"] = note(ablation, all_rules)
    lines = []
    for rule, name in switches().items():
        if rule in measured:
            lines.append(row(rule, name, ablation, all_rules, measured[rule]))
        else:
            old = rows.get(rule, [str(rule), name] + ["-"] * (len(HEADING) - 2))
            lines.append([old[0], name, *old[2:]])
    used = [key for key in notes if any(line[-1] == key for line in lines)]
    text = table(HEADING, lines) + [""] + [part for key in used for part in wrapped(notes[key])]
    write_between_markers(page, {"measured": "\n".join(text)}, COMMAND)


def options_of_command_line():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", help="talus-compare, with switches")
    parser.add_argument("rules", nargs="*", type=int, metavar="RULE", help="numbers; default: all that have a switch")
    parser.add_argument("--worlds", nargs="+", help="names or files, instead of all")
    parser.add_argument("--logs", nargs="*", help="names, instead of all real logs")
    parser.add_argument("--situations", help="test_situations, with switches")
    parser.add_argument("--instructions", help="instructions_without.sh, which takes a rule and says what a frame costs without it")
    parser.add_argument("--data", default=os.environ.get("TALUS_TEST_DATA", os.path.join(SOURCE, "../shared/data")),
                        help="folder of the real logs; default: TALUS_TEST_DATA")
    parser.add_argument("--output", default=os.path.join(SOURCE, "out/ablate"), help="folder of what was measured")
    parser.add_argument("--page", default=os.path.join(SOURCE, "kernels/rules_measured.md"), help="page to write")
    parser.add_argument("--jobs", type=int, default=max(1, (os.cpu_count() or 2) // 2), help="comparisons at a time")
    o = parser.parse_intermixed_args()  # rules may follow options
    for name in ("command", "data", "output", "situations", "instructions"):
        setattr(o, name, getattr(o, name) and os.path.abspath(getattr(o, name)))
    unknown = [rule for rule in o.rules if rule not in switches()]
    if unknown:
        parser.error(f"no rule {unknown[0]} has a switch. These have one: {' '.join(map(str, switches()))}")
    return o


def main():
    options = options_of_command_line()
    os.environ.pop(VARIABLE, None)  # or none of the comparisons would be with all rules
    ablation = Ablation(options)
    measured = {}
    try:
        all_rules = ablation.measure(None)
        for rule in options.rules or switches():
            print(f"ablate: without rule {rule}", file=sys.stderr, flush=True)
            measured[rule] = ablation.measure(rule)
            write(options.page, ablation, all_rules, measured)  # what a run that is stopped leaves is true
    except KeyboardInterrupt:
        raise SystemExit("ablate: stopped; the same command goes on from here") from None
    print(f"ablate: wrote {options.page}", file=sys.stderr)


if __name__ == "__main__":
    main()
