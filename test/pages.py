#!/usr/bin/env python3
"""Pages are true: links lead to files and headings that exist, commands and their long options to those that there are.
They are short, --help is not wide, and pictures are as new as the palette and the scenes that made them.

  test/pages.py SOURCE_DIR [BIN_DIR]
  test/pages.py SOURCE_DIR --made PICTURE    notes that it was made of what is there now (./dev pictures)

Without BIN_DIR (where the commands of talus were built) commands are not looked at. Exit code 1 with a line for each that
is wrong.
"""
import glob
import hashlib
import os
import re
import shlex
import subprocess
import sys


def lines_of(page):
    """(number, line, language) of each line; language: None outside of a block of code, '' where none is named."""
    language = None
    with open(page, encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            fence = re.match(r"\s*```(\w*)", line)
            if fence:
                language = fence[1] if language is None else None
            else:
                yield number, line.rstrip("\n"), language


def outside_of_code(page):
    """(number, line) of what is not a block of code."""
    return ((number, line) for number, line, language in lines_of(page) if language is None)


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


def commands(page):
    """(number, words) of each command of talus and ./dev: in blocks of sh or of no language, and in `code` of the text."""
    whole = ""
    for number, line, language in lines_of(page):
        if language is None:
            texts = re.findall(r"`([^`]+)`", line) + ([line] if re.match(r" {4}\S", line) else [])
        elif language in ("", "sh"):
            whole += line
            if whole.endswith("\\"):
                whole = whole[:-1]
                continue
            texts, whole = [whole], ""
        else:
            continue
        for text in texts:
            for command in re.split(r"&&|\||;|>", re.sub(r"(^|\s)#.*", "", text)):
                try:
                    words = [word for word in shlex.split(command) if not re.match(r"[A-Z_]+=", word)]
                except ValueError:  # prose
                    continue
                if words and re.fullmatch(r"\./dev|([\w./]+/)?talus-[a-z]+", words[0]):
                    yield number, words


class Helps:
    """What --help of each command says."""

    def __init__(self, bin_dir):
        self.bin_dir, self.known = bin_dir, {}

    def of(self, program):
        """None where there is no such command."""
        if program not in self.known:
            paths = [p for p in (f"{self.bin_dir}/{program}", f"apps/{program}/{program}") if os.path.isfile(p)]
            self.known[program] = subprocess.run([paths[0], "--help"], capture_output=True, text=True, check=True,
                                                 timeout=60).stdout if paths else None
        return self.known[program]


def wrong_commands(page, helps):
    not_built = ("talus-bench", "talus-soak")  # by every build
    with open("dev", encoding="utf-8") as dev:
        dev_says = dev.read()
    for number, words in commands(page):
        program = os.path.basename(words[0])
        if program == "dev":
            if len(words) > 1 and not re.search(rf"^  {re.escape(words[1])} ", dev_says, re.M):
                yield f"{page}:{number}: ./dev knows no {words[1]}"
            continue
        said = helps.of(program)
        if said is None:
            if program not in not_built:
                yield f"{page}:{number}: there is no command {program}"
            continue
        for word in words[1:words.index("--") if "--" in words else None]:
            option = re.match(r"--[a-z][\w-]*", word)
            if option and not re.search(re.escape(option[0]) + r"(?![\w-])", said):
                yield f"{page}:{number}: {program} has no {option[0]}"
            if re.match(r"(datasets|apps|doc|test)/(?!.*[A-Z]{2})", word) and not glob.glob(word):  # NAME: of your own
                yield f"{page}:{number}: there is no file {word}"


def wrong_helps(helps):
    for program, said in helps.known.items():
        for line in (said or "").splitlines():
            if len(line) > 100:
                yield f"{program} --help has a line of more than 100 columns: {line}"


def wrong_lengths():
    """Of the pages for users."""
    words = 0
    for page in ["README.md"] + glob.glob("doc/*.md"):
        with open(page, encoding="utf-8") as file:
            text = file.read()
        words += len(text.split())
        if text.count("\n") > 200:
            yield f"{page} has more than 200 lines: what was tried belongs into doc/notes/"
    if words > 18000:
        yield f"the pages for users have {words} words, more than 18,000"


PALETTE = "libs/io/include/talus/io/palette.h"  # of which the colours count
MADE_OF = "doc/images/made_of.txt"  # a line each: picture, digest, what it is made of


def made_of():
    with open(MADE_OF, encoding="utf-8") as lines:
        for line in lines:
            picture, digest, *files = line.split()
            sums = hashlib.sha256()
            for file in files + [PALETTE]:
                with open(file, encoding="utf-8") as content:
                    text = content.read()
                sums.update("".join(re.findall(r"{\d+, \d+, \d+}", text) if file == PALETTE else text).encode())
            yield picture, digest, sums.hexdigest()[:16], files


def wrong_pictures():
    known = []
    for picture, digest, now, files in made_of():
        known.append("doc/images/" + picture)
        if digest != now:
            yield f"doc/images/{picture} is older than the palette or {' '.join(files)}: ./dev pictures"
    for picture in glob.glob("doc/images/*.png") + glob.glob("doc/images/*.webp"):
        if picture not in known:
            yield f"{picture} is not in {MADE_OF}"


def note_made(made):
    lines = [" ".join([picture, now if picture == made else digest, *files]) for picture, digest, now, files in made_of()]
    with open(MADE_OF, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def main():
    os.chdir(sys.argv[1])
    if len(sys.argv) > 3:
        return note_made(sys.argv[3])
    folders = ("", "doc/", "doc/notes/", "datasets/", "kernels/")
    pages = sorted(page for folder in folders for page in glob.glob(folder + "*.md"))
    wrong = [line for page in pages for line in wrong_links(page)] + list(wrong_lengths()) + list(wrong_pictures())
    if len(sys.argv) > 2:
        helps = Helps(sys.argv[2])
        wrong += [line for page in pages for line in wrong_commands(page, helps)]
        wrong += wrong_helps(helps)
        count = sum(1 for page in pages for _ in commands(page))
        print(f"{count} commands")
        if count < 20:
            wrong.append("hardly any commands were found on the pages")
    print("\n".join(wrong) or f"{len(pages)} pages, nothing wrong")
    return 1 if wrong or "README.md" not in pages else 0


sys.exit(main())
