"""Sentences of the library name arguments of Python, not options of the command."""

import re
from pathlib import Path

import pytest
import tagcal

LIBRARY = Path(__file__).parents[2] / "lib/tagcal"
LITERAL = r'"((?:[^"\\\n]|\\.)*)"'
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]+")


def sentences() -> list[str]:
    """The literals of the library that name an option, those that follow each other joined."""
    found = []
    for path in sorted(LIBRARY.rglob("*.[ch]pp")):
        text = path.read_text()
        text = re.sub(rf"{LITERAL}|//[^\n]*", lambda m: m[0] if m[0][0] == '"' else "", text)
        for match in re.finditer(rf"{LITERAL}(?:\s*{LITERAL})*", text):
            joined = "".join(re.findall(LITERAL, match[0]))
            if OPTION.search(joined):
                found.append(joined)
    return found


def arguments() -> set[str]:
    names = ("calibrate", "calibrate_rig", "calibrate_handeye", "read_robot_poses", "fit_lens")
    docs = [getattr(tagcal, name).__doc__ for name in names]
    return set(re.findall(r"(\w+): ", "\n".join(docs)))


def test_every_option_in_a_sentence_becomes_an_argument():
    found = sentences()
    assert len(found) > 5
    for sentence in found:
        said = tagcal._core._in_python(sentence)
        outside_of_commands = said.partition("tagcal ")[0].partition("ros2 ")[0]
        assert not OPTION.search(outside_of_commands), sentence


def test_the_arguments_exist():
    known = arguments()
    rows = re.findall(r'Row\{"(--[^"]+)"', (LIBRARY.parent / "python/sentences.cpp").read_text())
    assert len(rows) > 5
    for option in rows:
        said = tagcal._core._in_python(f"{option} x")
        of_command = said.startswith("tagcal convert --")
        assert of_command or re.match(r"\w+", said)[0] in known, option


@pytest.mark.parametrize(
    "sentence, said",
    [
        ("try --model auto", 'try model="auto"'),
        ("no lens: --model fisheye4 or opencv8 fits", 'no lens: model="fisheye4" or opencv8 fits'),
        ("a start (--start, --focal)", "a start (start, start_focal_px)"),
        ("state it with --sigma-px", "state it with sigma_px"),
        ("bent: try --board-warp.", "bent: try board_warp=True."),
        ("tagcal convert a.yaml --model f", "tagcal convert a.yaml --model f"),
        ("a--model and --models", "a--model and --models"),
        ("--model", 'model=""'),
        ("state it, --image-size WxH", "state it, tagcal convert --image-size WxH"),
    ],
)
def test_in_python(sentence, said):
    assert tagcal._core._in_python(sentence) == said


def test_findings_and_errors_speak_python(tmp_path):
    dataset = tagcal.read_dataset(LIBRARY.parents[1] / "data-synthetic/golden/desk").dataset
    weak = tagcal.calibrate(dataset, "weak")
    for finding in weak.findings:
        assert "--" not in finding.sentence + repr(finding)
    assert any('model="auto"' in f.sentence for f in weak.findings)
    fisheye = tagcal.Camera.fisheye(500, 500, 9, 9, (20, 20), [0.1])
    with pytest.raises(tagcal.Error, match='model="opencv8" fits one that it has'):
        tagcal.write_camera(tmp_path / "a.cameramodel", fisheye)
