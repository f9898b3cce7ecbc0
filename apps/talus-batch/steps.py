#!/usr/bin/env python3
"""The steps of a batch; the Snakefile calls them in the folder of the results.

What a step has made is told by a small JSON file, which is written last: `state` (ok or failed), `maps` (files by name:
site.tif, site_floor_1.tif, site_island_1.tif ...), of a log also what the report says of it.
"""
import fcntl
import html
import json
import os
import shutil
import subprocess
import sys
import time
import urllib.parse

SITE = "site.tif"  # other floors and islands lie beside it


def write_whole(path, text):
    """Under another name first, so that nobody reads half of it."""
    beside = path + ".new"
    with open(beside, "w") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(beside, path)


def write_json(path, value):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    write_whole(path, json.dumps(value, indent=2) + "\n")


def read_json(path):
    with open(path) as file:
        return json.load(file)


def last_line(path):
    with open(path, errors="replace") as file:
        lines = [line.strip() for line in file if line.strip()]
    return lines[-1] if lines else "it said nothing"


def run(command, log):
    """The exit code; what the command says goes to the log. A command that was killed or stopped ends this step too: it is
    tried again."""
    with open(log, "a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # held as long as the command lives: one that outlives its batch is waited for
        file.truncate(0)
        code = subprocess.run(command, stdout=file, stderr=file, stdin=subprocess.DEVNULL).returncode
    if code < 0 or code >= 128:
        sys.exit(f"talus-batch: {os.path.basename(command[0])} was stopped by signal {-code if code < 0 else code - 128}")
    return code


def maps_in(folder):
    return {name: os.path.join(folder, name) for name in sorted(os.listdir(folder))
            if name.startswith((SITE, "site_floor_", "site_island_")) and name.endswith(".tif")}


def map_log(output, log, attempt, retries, drive, command):
    """Maps a log. The last attempt is none: it tells that those before were killed, and so no other log has to wait."""
    folder = output[: -len(".json")]
    begin = time.monotonic()
    if int(attempt) > int(retries):
        told = {"state": "failed", "error": f"{drive}: its job was killed {retries} times: too little memory or time?"}
    elif run(command[:1] + [drive, "--output", folder, "--quiet"] + command[1:], log) != 0:
        told = {"state": "failed", "error": last_line(log)}
    elif not maps_in(folder):
        told = {"state": "failed", "error": f"{command[0]} wrote no site.tif"}
    else:
        told = {"state": "ok", **measures(read_json(os.path.join(folder, "summary.json")))}
    told["maps"] = maps_in(folder) if told["state"] == "ok" else {}
    told["log"], told["seconds"] = drive, round(time.monotonic() - begin, 1)
    write_json(output, told)


def measures(summary):
    return {"frames": summary["frames"], "length_m": summary["site"]["length_m"], "area_m2": summary["site"]["area_m2"]}


def merge(output, log, draws, inputs, command):
    """Merges the maps of the inputs. What is alone is taken as it is, but for the map of all, which is drawn too."""
    folder = output[: -len(".json")]
    found = [told["maps"] for told in map(read_json, inputs) if told["maps"]]
    maps = found[0] if found else {}
    if len(found) > 1 or (found and draws):
        os.makedirs(folder, exist_ok=True)
        site = os.path.join(folder, SITE)
        drawn = ["--picture", picture_of(site)] if draws else []
        inputs = [parts[SITE] for parts in found]
        if run(command[:1] + inputs + ["--output", site, "--quiet"] + drawn + command[1:], log) != 0:
            sys.exit(f"talus-batch: {last_line(log)}")
        maps = maps_in(folder)
    write_json(output, {"state": "ok", "maps": maps})


def picture_of(path):
    return path[: -len(".tif")] + ".png"


def publish(path, name):
    """Puts a file where people look, in one move; what was there before stays until then."""
    if os.path.exists(name) and os.path.samefile(path, name):  # which no move of a link would change
        return
    beside = name + ".new"
    if os.path.exists(beside):
        os.remove(beside)
    try:
        os.link(path, beside)
    except OSError:  # a file system without links
        shutil.copyfile(path, beside)
    os.replace(beside, name)


def page_of(path):
    return path[: -len(".tif")] + ".html"


def make_pages(maps, command):
    """The map of all as pages, where talus-export can make them; the report says what it lacks, and no map is lost."""
    site = maps[SITE]
    options = ["--to", "html", "--title", os.path.basename(os.getcwd()), "--output", os.path.dirname(site), "--quiet"]
    code = run(command[:1] + [site] + options + command[1:], site + ".log")
    for name, path in maps.items():
        if code == 0:
            publish(page_of(path), page_of(name))
        elif os.path.exists(page_of(name)):  # of an older map
            os.remove(page_of(name))
    return "" if code == 0 else last_line(site + ".log")


def logs_of(batch):
    return [read_json(f"maps/{name}.json") for name in sorted(read_json(batch)["logs"])]


def report(output, whole, batch, command):
    maps = read_json(whole)["maps"]
    for name, path in maps.items():
        publish(path, name)
        publish(picture_of(path), picture_of(name))
    lacks = make_pages(maps, command) if maps else ""
    for name in set(maps_in(".")) - set(maps) if maps else []:  # floors that no log sees any more
        os.remove(name)
        for file in filter(os.path.exists, (picture_of(name), page_of(name))):
            os.remove(file)
    write_whole(output, report_page(logs_of(batch), maps, lacks))


def drawn(name):
    """The picture of a map, which leads to its page where there is one."""
    picture = f'<img src="{picture_of(name)}" alt="{name}">'
    return f'<a href="{page_of(name)}">{picture}</a>' if os.path.exists(page_of(name)) else picture


def report_page(logs, maps, lacks):
    ok = [told for told in logs if told["state"] == "ok"]
    total = {key: sum(told[key] for told in ok) for key in ("frames", "length_m", "area_m2", "seconds")}
    files = ", ".join(f'<a href="{name}">{name}</a>' for name in maps) or "no map: no log was mapped"
    pictures = "".join(map(drawn, maps)) + (f"<p>No page to open: {html.escape(lacks)}</p>" if lacks else "")
    rows = "".join(map(row, logs))
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>talus-batch</title><style>
body {{ font-family: sans-serif; margin: 2em; }} img {{ max-width: 100%; }}
table {{ border-collapse: collapse; }} td, th {{ padding: 0.2em 0.8em; border-bottom: 1px solid #ccc; text-align: right; }}
td:first-child, th:first-child, td:last-child, th:last-child {{ text-align: left; }} .failed {{ color: #b00; }}
</style></head><body>
<h1>{len(ok)} of {len(logs)} logs mapped</h1>
<p>{files}</p>
{pictures}
<table>
<tr><th>log</th><th>frames</th><th>km</th><th>m<sup>2</sup></th><th>seconds</th><th>map</th><th>state</th></tr>
{rows}<tr><th>all that were mapped</th>{numbers(total)}<th></th><th></th></tr>
</table></body></html>
"""


def numbers(told):
    cells = [f"{told['frames']}", f"{told['length_m'] / 1000:.3f}", f"{told['area_m2']:.0f}"] if "frames" in told else [""] * 3
    return "".join(f"<td>{cell}</td>" for cell in cells + [f"{told['seconds']:.1f}"])


def links(told):
    """To the maps of a log, and their pictures."""
    files = [file for path in told["maps"].values() for file in (page_of(path), picture_of(path), path)
             if os.path.exists(file)]
    return " ".join(f'<a href="{urllib.parse.quote(file)}">{html.escape(os.path.basename(file))}</a>' for file in files)


def row(told):
    state = told["state"] + (f": {told['error']}" if "error" in told else "")
    return f'<tr class="{told["state"]}"><td>{html.escape(told["log"])}</td>{numbers(told)}<td>{links(told)}</td><td>{html.escape(state)}</td></tr>\n'


def verdict(batch):
    logs = logs_of(batch)
    failed = [told for told in logs if told["state"] != "ok"]
    print(f"talus-batch: {len(logs) - len(failed)} of {len(logs)} logs mapped; see {os.path.abspath('report.html')}", flush=True)
    for told in failed:
        print(f"talus-batch: failed: {told['error']}", file=sys.stderr)
    sys.exit(1 if failed else 0)


def main():
    step, arguments = sys.argv[1], sys.argv[2:]
    command = []
    if "--" in arguments:
        at = arguments.index("--")
        arguments, command = arguments[:at], arguments[at + 1 :]
    if step == "map":
        map_log(*arguments, command)
    elif step == "merge":
        merge(*arguments[:2], arguments[2] == "True", arguments[3:], command)
    elif step == "report":
        report(*arguments, command)
    elif step == "verdict":
        verdict(*arguments)


if __name__ == "__main__":
    main()
