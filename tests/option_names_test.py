#!/usr/bin/env python3
"""Every option that a sentence of the library or of the commands names exists.

    option_names_test.py SOURCE TAGCAL

Takes the string literals of lib/tagcal and tools, finds "--name" in them, and asks each command for
its options (`tagcal COMMAND --help`). An option of a whole command ("tagcal convert FILE --to
FORMAT") must be one of that command; any other must be one of some command.
"""

import re
import subprocess
import sys
from pathlib import Path

# Programs of others whose commands are named: "ffmpeg -i x.mp4 .."
OTHERS = re.compile(r"\b(ffmpeg|heif-convert|rosbag|ros2|cmake|apt|pip|tagcal-study|npm|chromium)\b")
# Options of tagcal-study, which has the same groups of options.
OF_STUDIES = {"csv"}
LITERAL = re.compile(r'"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*')
OPTION = re.compile(r"(?<![\w-])--([a-z][a-z0-9-]*[a-z0-9])")


def literals(path: Path) -> list[str]:
    """The literals of a file, those that follow each other joined."""
    text = path.read_text(encoding="utf-8")
    text = re.sub(r'("(?:[^"\\\n]|\\.)*")|//[^\n]*', lambda m: m[1] or "", text)
    return [
        "".join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', match[0])) for match in LITERAL.finditer(text)
    ]


def options_of(program: str) -> dict[str, set[str]]:
    def helped(*words: str) -> str:
        return subprocess.run([program, *words], capture_output=True, text=True).stdout

    commands = helped("--help").partition("Commands:")[2]
    names = re.findall(r"^  ([a-z-]+)  ", commands, re.MULTILINE)
    found = {}
    for name in names:
        full = helped(name, "--help-all") or helped(name, "--help")
        found[name] = set(OPTION.findall(full)) | {"help", "version", "help-all"}
    assert len(found) > 10, "the help does not list commands any more"
    return found


def mistakes(text: str, options: dict[str, set[str]]) -> list[str]:
    if OTHERS.search(text):
        return []
    every = OF_STUDIES.union(*options.values())
    found = []
    for match in OPTION.finditer(text):
        # The words before it in the same clause: does it follow a command's name?
        clause = re.split(r"[;:,(.] |\\n|^", text[: match.start()])[-1]
        command = re.findall(r"\b(?:tagcal )?(" + "|".join(options) + r")\b(?= )", clause)
        named = "tagcal " in clause and command
        known = options[command[-1]] if named else every
        if match[1] not in known:
            where = f"tagcal {command[-1]}" if named else "any command"
            found.append(f"--{match[1]}: no option of {where}, in \"{text}\"")
    return found


def main(source: Path, program: str) -> int:
    options = options_of(program)
    wrong, sentences = [], 0
    folders = [source / "lib/tagcal", source / "tools"]
    for path in sorted(path for folder in folders for path in folder.rglob("*.[ch]pp")):
        if "studies" in path.parts:
            continue  # another program, tagcal-study
        for text in literals(path):
            sentences += bool(OPTION.search(text))
            wrong += [f"{path.relative_to(source)}: {m}" for m in mistakes(text, options)]
    assert sentences > 50, "no sentences with options are found any more"
    assert mistakes("try --no-such-option", options), "a wrong option is not found"
    assert mistakes("tagcal diff A --to B", options), "an option of another command is not found"
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2]))
