#!/usr/bin/env python3
"""Every option that a sentence of the library or of the commands names exists, and advice works.

    option_names_test.py SOURCE TAGCAL

Takes the string literals of lib/tagcal and tools, finds "--name" in them, and asks each command for
its options (`tagcal COMMAND --help`). An option of a whole command ("tagcal convert FILE --to
FORMAT") must be one of that command; any other must be one of some command. Then makes mistakes with a rendered data set, takes the advice out of what is
printed, and follows it: the command must not be refused, and must not say the same again.
"""

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
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


# A command with a mistake, the advice that it prints, and the command that follows the advice, with
# the groups of the match. DESK and COPY are rendered data sets; --out keeps their corners, too.
ADVISED = [
    ("calibrate DESK --model weak --out weak.yaml", r"try (--model auto)", "calibrate DESK {0} --out a.yaml"),
    ("calibrate DESK --model f --out f.yaml", r"use (opencv\d) or (auto)", "calibrate DESK --model {0} --out a.yaml"),
    ("calibrate DESK --model fisheye4 --out fish.yaml", r"(opencv\d), another kind of lens, reduces .* use it",
     "calibrate DESK --model {0} --out a.yaml"),
    ("convert fish.yaml x.cameramodel", r"(--model \w+) fits one", "convert fish.yaml x.cameramodel {0}"),
    ("convert fish.yaml out.zip", r"choose one by (--to)", "convert fish.yaml out.zip {0} opencv"),
    ("calibrate DESK --model ds --out ds.yaml", r"(opencv\d), another kind of lens", "calibrate DESK --model {0} --out a.yaml"),
    ("convert ds.yaml x.cameramodel", r"(--model \w+) fits one", "convert ds.yaml x.cameramodel {0}"),
    ("convert ds.yaml x.ini --to ros", r"(--model \w+) fits one", "convert ds.yaml x.ini --to ros {0}"),
    ("convert o8.yaml chain.yaml --to kalibr", r"convert (--model \w+) fits a lens without it",
     "convert o8.yaml chain.yaml --to kalibr {0}"),
    ("convert o8.yaml chain.yaml --to kalibr", r"calibrate with (--model \w+)",
     "calibrate DESK {0} --out o4.yaml"),
    ("convert o8.yaml chain.yaml --to kalibr", r"calibrate with (--model \w+)",
     "convert o4.yaml chain.yaml --to kalibr"),
    ("convert o8.yaml t.json --to nerfstudio", r"calibrate with (--model \w+)",
     "calibrate DESK {0} --out o5.yaml"),
    ("pose DESK", r"(--unknown-focal)", "pose DESK {0}"),
    ("calibrate DESK/images", r"need their board, (--target) T", "calibrate DESK/images {0} DESK/target.yaml --out a.yaml"),
    ("detect DESK --target DESK/target.yaml", r"leave out (--target)", "detect DESK"),
    ("detect DESK/images --border-bits 1", r"needs (--family)", "detect DESK/images --border-bits 1 {0} tag36h11"),
    ("pose DESK/images --unknown-focal --family tag36h11", r"needs (--tag-size)",
     "pose DESK/images --unknown-focal --family tag36h11 {0} 0.088"),
    ("calibrate DESK COPY --target DESK/target.yaml", r"leave out (--target)", "calibrate DESK COPY --out many"),
    ("report o8.yaml --observations DESK/observations_exact.csv", r"needs (--dataset)",
     "report o8.yaml --dataset DESK --out r.html"),
]
# Edits of DESK/target.yaml whose pictures contradict them, with what to write instead.
EDITS = [("tagCols: 6", "tagCols: 7"), ("tagSpacing: 0.3", "tagSpacing: 0.5"),
         ("border_bits: 1", "border_bits: 2"), ("tag36h11", "tag36h10")]
WRITE = re.compile(r"write ((?:\w+: [\w.]+(?:, )?)+)")


class Advice:
    """Runs commands in a folder with rendered data sets."""

    def __init__(self, source: Path, program: str, folder: Path):
        self.program, self.folder, self.wrong = program, folder, []
        self.run(f"render {source}/data-synthetic/scenes/desk.yaml --views 8 --out DESK")
        shutil.copytree(folder / "DESK", folder / "COPY")
        self.run("calibrate DESK --model opencv8 --out o8.yaml")

    def run(self, arguments: str) -> tuple[int, str]:
        done = subprocess.run([self.program, *shlex.split(arguments)], cwd=self.folder, text=True,
                              capture_output=True)
        return done.returncode, " ".join((done.stdout + done.stderr).split())

    def follow(self, mistake: str, advice: str, followed: str) -> None:
        printed = self.run(mistake)[1]
        match = re.search(advice, printed)
        if not match:
            self.wrong.append(f"{mistake}: does not say {advice}: {printed}")
            return
        code, after = self.run(followed.format(*match.groups()))
        if code == 2 or match[0] in after:
            self.wrong.append(f"{mistake}: advises {followed.format(*match.groups())}: {after}")

    def follow_target(self, right: str, mistake: str) -> None:
        target = (self.folder / "DESK/target.yaml").read_text()
        assert right in target, right
        text = target.replace(right, mistake)
        detect = "detect DESK/images --no-cache --target wrong.yaml --out corners.csv"
        (self.folder / "wrong.yaml").write_text(text)
        said = WRITE.findall(self.run(detect)[1])
        if not said:
            self.wrong.append(f"{mistake} instead of {right}: nothing is said of it")
            return
        for key, value in (pair.split(": ") for pair in said[0].rstrip(", .").split(", ")):
            text = re.sub(f"^{key}: .*", f"{key}: {value}", text, flags=re.MULTILINE)
        (self.folder / "wrong.yaml").write_text(text)
        code, after = self.run(detect)
        if code != 0 or WRITE.search(after):
            self.wrong.append(f"{mistake} instead of {right}: advises {said[0]}: {after}")


def followed_advice(source: Path, program: str) -> list[str]:
    with tempfile.TemporaryDirectory() as folder:
        advice = Advice(source, program, Path(folder))
        for case in ADVISED:
            advice.follow(*case)
        for edit in EDITS:
            advice.follow_target(*edit)
        return advice.wrong


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
    wrong += followed_advice(source, program)
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), str(Path(sys.argv[2]).resolve())))
