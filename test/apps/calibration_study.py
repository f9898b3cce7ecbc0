#!/usr/bin/env python3
"""Calibrates seeded simulated drives with known errors and prints how far the answers are from the truth.

  test/apps/calibration_study.py BUILD_DIR [--seeds 40] [--world datasets/worlds/rolling.yaml] [--jobs 2]

Each seed draws roll and pitch within 5 degrees, z within 0.1 m, the clock within 100 ms, c_beam in 5..30 mm and a_beam in
1..3 mm/m. The table (Markdown) goes to stdout; exit code 1 when less than 95 % of the truths lie within 3 sigma.
"""
import argparse
import json
import os
import random
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

LIMITS = {"roll": 0.05, "pitch": 0.05, "z": 0.005, "time_offset": 0.005, "c_beam_m": 0.10, "a_beam": 0.10}


def run(command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def one(seed, bin_dir, world):
    draw = random.Random(seed)
    roll, pitch, z = draw.uniform(-5, 5), draw.uniform(-5, 5), draw.uniform(-0.1, 0.1)
    clock, c_beam, a_beam = draw.uniform(-0.1, 0.1), draw.uniform(0.005, 0.03), draw.uniform(0.001, 0.003)
    name = os.path.splitext(os.path.basename(world))[0]
    with tempfile.TemporaryDirectory() as folder:
        run([f"{bin_dir}/talus-sim", world, "--output", folder, "--quiet", "--seed", str(seed),
             "--noise", str(c_beam), "--noise-per-m", str(a_beam), f"--clock-error={clock}",
             "--mounting-error", f"0,0,{z},0,{pitch},{roll}"])
        run([f"{bin_dir}/talus-calibrate", f"{folder}/{name}.rawlog", "--output", folder, "--quiet"])
        with open(f"{folder}/calibration.json") as file:
            got = json.load(file)
    truth = {"x": 0, "y": 0, "z": 0.68, "yaw": 0, "pitch": 0, "roll": 0, "time_offset": -clock}
    answers = {}
    for key, value in truth.items():
        p = got["parameters"][key]
        if p["observable"]:
            answers[key] = (p["estimate"] - value, p["sigma"], 1)
    for key, value in (("c_beam_m", c_beam), ("a_beam", a_beam)):
        p = got["noise"][key]
        if p["told_from_zero"]:
            answers[key] = (p["estimate"] - value, p["sigma"], value)
    return answers


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--world", default=os.path.join(os.path.dirname(__file__), "../../datasets/worlds/rolling.yaml"))
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    with ThreadPoolExecutor(args.jobs) as pool:
        runs = list(pool.map(lambda s: one(s, os.path.join(args.build, "bin"), args.world), range(1, args.seeds + 1)))
    print("| parameter | answered | RMS error | largest | limit | within the limit | within 3 sigma |\n|---|---|---|---|---|---|---|")
    total = inside = 0
    for key in ["roll", "pitch", "yaw", "x", "y", "z", "time_offset", "c_beam_m", "a_beam"]:
        found = [r[key] for r in runs if key in r]
        errors = [abs(e) / scale for e, _, scale in found]
        in_sigma = sum(abs(e) <= 3 * s for e, s, _ in found)
        total, inside = total + len(found), inside + in_sigma
        limit = LIMITS.get(key)
        met = sum(e <= limit for e in errors) if limit else "-"
        rms = (sum(e * e for e in errors) / max(1, len(errors))) ** 0.5
        print(f"| {key} | {len(found)} | {rms:.5f} | {max(errors, default=0):.5f} | {limit or '-'} | {met} | {in_sigma} |")
    print(f"\n{inside} of {total} truths within 3 sigma ({100 * inside / total:.1f} %)")
    return inside < 0.95 * total


if __name__ == "__main__":
    raise SystemExit(main())
