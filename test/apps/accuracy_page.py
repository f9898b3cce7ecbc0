#!/usr/bin/env python3
"""The tables of doc/accuracy.md and its note are what talus-compare finds: a small part of them is written anew, into copies.

  test/apps/accuracy_page.py TALUS_COMPARE

Exit code 1 with what is wrong. The table of held-out beams is looked at where TALUS_TEST_DATA has the log.
"""
import json
import os
import re
import subprocess
import sys
import tempfile

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE, NOTE = os.path.join(SOURCE, "doc/accuracy.md"), os.path.join(SOURCE, "doc/notes/accuracy.md")
DATA = os.environ.get("TALUS_TEST_DATA", os.path.join(SOURCE, "../shared/data"))
LOG, ROW = "offroad_b", "forest B"
STALE = 0.1  # of a figure: the map has changed by more than that since the page was written


def part(page, name):
    return re.search(f"<!-- {name}: written by .*?-->(.*?)<!-- {name}: end -->", page, re.DOTALL)[1]


def rows(text):
    return [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in text.splitlines() if line[:1] == "|"]


def read(page):
    with open(page, encoding="utf-8") as file:
        return file.read()


def write(command, option, page, folder, *arguments):
    subprocess.run([sys.executable, os.path.join(SOURCE, "apps/lab/talus-compare/page.py"), command, option, page,
                    "--output", folder, "--methods", "talus,highest", *arguments], check=True)
    return read(page)


def check_worlds(command, page, folder, before):
    world = os.path.join(folder, "bench.yaml")
    with open(world, "w", encoding="utf-8") as file:
        file.write("ground: [plane: {}]\nobjects: [box: {at_m: [2, 0.5], size_m: [0.5, 0.5, 0.5]}]\n"
                   "robot: {path_m: [[0, 0], [0.6, 0]]}\n")
    after = write(command, "--page", page, folder, "--only", "worlds", "budgets", "--worlds", world)
    with open(os.path.join(folder, "bench/comparison.json"), encoding="utf-8") as file:
        found = json.load(file)["worlds"][0]
    heading, _, talus, highest = rows(part(after, "worlds"))
    shown = dict(zip(heading, talus))
    assert highest[0] == "highest", highest
    assert shown["ground mm"] == f"{1000 * found['methods']['talus']['measured_ground_rmse_m']:.1f}", shown
    assert set(heading) <= set(rows(part(before, "worlds"))[0]), "the page has other columns: ./dev compare --page"
    verdicts = [budget["verdict"] for budget in found["budgets"]]
    told = [int(number) for number in re.findall(r"\d+", part(after, "budgets"))]
    assert told == [len(verdicts) - verdicts.count("not applicable"), verdicts.count("fail")], told
    assert part(after, "scans") == part(before, "scans"), "the table scans was touched"
    outside = [re.sub("<!-- (worlds|budgets): written.*?end -->", "", text, flags=re.DOTALL)
               for text in (before, after)]
    assert outside[0] == outside[1], "text outside of the markers was touched"


def check_held_out(command, page, folder, before):
    after = write(command, "--note", page, folder, "--only", "held_out", "--logs", LOG)
    new = next(row for row in rows(part(after, "held_out")) if row[0].startswith(ROW))
    old = next(row for row in rows(part(before, "held_out")) if row[0].startswith(ROW))
    for a, b in zip(old[1:], new[1:], strict=True):
        for told, found in zip(map(float, a.split(",")), map(float, b.split(",")), strict=True) if a != b else ():
            assert abs(told - found) <= STALE * found, f"the page says {a}, it is {b}: run ./dev compare --page"


def main():
    command = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        page = os.path.join(folder, "accuracy.md")
        for check, original in ((check_worlds, PAGE), (check_held_out, NOTE)):
            if check is check_held_out and not os.path.exists(os.path.join(DATA, "street.rawlog")):
                print(f"held-out beams: left out, there are no logs in {DATA} (TALUS_TEST_DATA)")
                continue
            before = read(original)
            with open(page, "w", encoding="utf-8") as file:
                file.write(before)
            check(command, page, folder, before)
            print(f"{check.__name__}: as it should be")


if __name__ == "__main__":
    main()
