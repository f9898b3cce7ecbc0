#!/usr/bin/env python3
"""Rules are left out one by one, and the page gets what talus-compare finds then: tried on a small world, on a copy.

  test/apps/ablate_page.py TALUS_COMPARE_WITH_SWITCHES

Exit code 1 with what is wrong.
"""
import json
import os
import re
import subprocess
import sys
import tempfile

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
RULE = 1  # the band of heights: without it a floor that falls has no points
# In the manner of gtest: one test that fails while the rule is left out.
SITUATIONS = """#!/bin/sh
for argument; do case $argument in --gtest_output=json:*) file=${argument#*json:} ;; esac; done
failures=$([ "$TALUS_WITHOUT_RULES" = 1 ] && echo '[{}]' || echo '[]')
echo '{"testsuites": [{"name": "Floors", "testsuite": [{"name": "AreDeep", "failures": '$failures'}]}]}' >"$file"
"""
INSTRUCTIONS = """#!/bin/sh
[ "$1" = 1 ] && echo "S1  1 accept 1.00 M  sum 18.00 M" || echo "S1  1 accept 3.00 M  sum 20.00 M"
"""
WORLD = """seed: 2
ground: [plane: {slope_x_deg: -12}]
robot: {path_m: [[0, 0], [1, 0]]}
"""
PAGE = """before
<!-- measured: written by ./dev ablate -->

| rule | what it is | rows | worlds | real | situations | S1 | run |
|---:|---|---|---|---|---|---|---|
| 2 | body boxes | 1/2 | of old | - | - | - | `earlier` |

- `earlier`: known
  before.

<!-- measured: end -->
after
"""


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def rows(text):
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line[:1] == "|"]
    return {row[0]: row for row in cells}


def ablate(command, folder, *arguments):
    done = subprocess.run([sys.executable, os.path.join(SOURCE, "apps/lab/talus-compare/ablate.py"), command, "--jobs", "1",
                           *arguments, "--worlds", f"{folder}/deep.yaml", "--logs",
                           "--situations", f"{folder}/situations", "--instructions", f"{folder}/instructions",
                           "--output", f"{folder}/out", "--page", f"{folder}/page.md"], capture_output=True, text=True)
    return done.returncode, done.stderr


def figures(command, folder, *arguments):
    subprocess.run([command, f"{folder}/deep.yaml", "--methods", "talus", "--quiet", "--output", f"{folder}/compared",
                    *arguments], check=True)
    return json.loads(read(f"{folder}/compared/comparison.json"))["worlds"][0]


def check_row(command, folder):
    code, said = ablate(command, folder, str(RULE))
    assert code == 0, said
    page = read(f"{folder}/page.md")
    found = rows(page)
    assert found["2"][2:] == ["1/2", "of old", "-", "-", "-", "`earlier`"], found["2"]
    assert "- `earlier`: known before." in page, page
    assert page.startswith("before\n") and page.endswith("\nafter\n"), page
    everything, without = figures(command, folder), figures(command, folder, "--without", str(RULE))
    fails = [{b["name"]: b["verdict"] == "fail" for b in w["budgets"] if b["verdict"] != "not applicable"}
             for w in (everything, without)]
    both = fails[0].keys() & fails[1].keys()
    lost, won = (sum(fails[i][n] and not fails[1 - i][n] for n in both) for i in (1, 0))
    row = found[str(RULE)]
    assert row[2] == f"{lost}/{won}" + (" in 1" if lost + won else ""), (row, lost, won)
    names = {"free": "free_passable", "reach": "reach", "ditch": "ditch_found", "leak": "leak", "obst": "obstacle_blocked"}
    shown = {name: float(by) for name, by in re.findall(r"(\w+) ([+-][0-9.]+)(?! %)(?=,|$)", row[3]) if name in names}
    assert shown, f"the rule changes nothing that is shown: {row}"
    for name, by in shown.items():
        true = 100 * (without["methods"]["talus"][names[name]] - everything["methods"]["talus"][names[name]])
        assert abs(by - true) < 0.051, (name, by, true)
    assert row[5] == "1: `Floors.AreDeep`", row
    assert row[6] == "-10.0 %", row
    assert f"\n- {row[7]}: commit " in page and "1 worlds (deep)" in page, page


def check_that_it_goes_on(command, folder):
    before = read(f"{folder}/page.md")
    code, said = ablate(command, folder, str(RULE))
    assert code == 0 and "run:" not in said, f"measured again: {said}"
    assert read(f"{folder}/page.md") == before
    write(f"{folder}/deep.yaml", WORLD.replace("-12", "-11"))
    code, said = ablate(command, folder, str(RULE))
    assert code == 0 and said.count("run:") == 2, f"the world is another one: {said}"
    after = rows(read(f"{folder}/page.md"))[str(RULE)]
    assert after[7] != rows(before)[str(RULE)][7], after


def check_refusal(command, folder):
    before = read(f"{folder}/page.md")
    code, said = ablate(command, folder, "0")
    assert code == 2 and "no rule 0 has a switch. These have one: 1 " in said, said
    assert read(f"{folder}/page.md") == before


def main():
    command = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        write(f"{folder}/deep.yaml", WORLD)
        write(f"{folder}/page.md", PAGE)
        for name, script in (("situations", SITUATIONS), ("instructions", INSTRUCTIONS)):
            write(f"{folder}/{name}", script)
            os.chmod(f"{folder}/{name}", 0o755)
        for check in (check_row, check_that_it_goes_on, check_refusal):
            check(command, folder)
            print(f"{check.__name__}: as it should be")


if __name__ == "__main__":
    main()
