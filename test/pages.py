#!/usr/bin/env python3
"""Links of the pages lead to files and headings that exist.

  test/pages.py SOURCE_DIR

Exit code 1 with a line for each link that leads nowhere.
"""
import glob
import os
import re
import sys


def outside_of_code(page):
    """(number, line) of what is not a block of code."""
    in_code = False
    with open(page, encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            if line.lstrip().startswith("```"):
                in_code = not in_code
            elif not in_code:
                yield number, line


def anchors(page):
    """Of its headings, as GitHub makes them."""
    found = set()
    for _, line in outside_of_code(page):
        heading = re.match(r"#+\s+(.*?)\s*$", line)
        if heading:
            text = re.sub(r"\]\([^)]*\)", "", heading[1]).lower()
            anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
            taken = sum(a == anchor or re.fullmatch(re.escape(anchor) + r"-\d+", a) is not None for a in found)
            found.add(f"{anchor}-{taken}" if taken else anchor)
    return found


def wrong_links(page):
    for number, line in outside_of_code(page):
        for link in re.findall(r"\]\(([^)\s]+)\)", line):
            if re.match(r"[a-z]+:", link):  # of the web
                continue
            file, _, anchor = link.partition("#")
            target = os.path.join(os.path.dirname(page), file) if file else page
            if not os.path.exists(target):
                yield f"{page}:{number}: there is no file {link}"
            elif anchor and anchor not in anchors(target):
                yield f"{page}:{number}: there is no heading for {link}"


def main():
    os.chdir(sys.argv[1])
    pages = glob.glob("*.md") + glob.glob("doc/*.md") + glob.glob("datasets/*.md")
    wrong = [line for page in sorted(pages) for line in wrong_links(page)]
    print("\n".join(wrong) or f"{len(pages)} pages, all links lead somewhere")
    return 1 if wrong or "README.md" not in pages else 0


sys.exit(main())
