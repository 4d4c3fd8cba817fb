"""One posterior, one claim: every way to ask for an uncertainty gives the same number, to the last
digit that is printed. Asked are the terminal, --json, the camera's file, the pages, the picture,
project, unproject, validate, diff and Python, for six sets of corners."""

import json
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import numpy as np
import pytest
import tagcal
from desk import COMMAND, DESK, SOURCE
from tagcal._residuals import residuals_of

REAL = SOURCE / "tests/data/real_corners"

# Folder, and options as Python takes them. Held parameters have no variance in any of the answers.
SETS: dict[str, tuple[Path, dict[str, Any]]] = {
    "bouguet_left": (REAL / "bouguet_left", {}),
    "opencv_left": (REAL / "opencv_left", {}),
    "euroc_cam0": (REAL / "euroc_cam0", {}),
    "visp_circles": (REAL / "visp_circles", {}),
    "desk": (DESK, {}),
    "desk, held": (DESK, {"model": "opencv5", "fixed": {"cx": 651.0, "k3": 0.0}}),
}


def command(*arguments: object) -> str:
    words = [str(COMMAND), *map(str, arguments)]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def data_of_page(page: Path) -> Any:
    text = page.read_text()
    start = '<script type="application/json" id="data">'
    return json.loads(text[text.index(start) + len(start) :].split("</script>")[0])


def covariance_in_file(text: str, key: str) -> np.ndarray:
    found = re.search(rf"^{key}: .*\n +rows: (\d+)\n +cols: (\d+)\n +dt: d\n +data: \[([^\]]*)\]",
                      text, re.MULTILINE)  # fmt: skip
    assert found, key
    return np.array([float(x) for x in found[3].split(",")]).reshape(int(found[1]), int(found[2]))


def is_printed(text: str, value: Optional[float]) -> bool:
    """True if the number that was printed is the value, to its last digit."""
    if text == "no bound" or value is None:
        return text == "no bound" and value is None
    decimals = len(text.partition(".")[2])
    return f"{value:.{decimals}f}" == text


def is_rounded(shown: Optional[float], value: float, digits: int = 6) -> bool:
    """True if the number in a page is the value, to its significant digits."""
    return shown is None if not np.isfinite(value) else shown == float(f"{value:.{digits}g}")


def shows_texts(svg: str, texts: list[str]) -> bool:
    """True if the picture begins with these texts. Its letters are outlines with numbers: each must
    stand for one letter, and each letter have one outline."""
    written = [re.findall(r'href="#(glyph[-\d]+)"', part) for part in svg.split("<g style=")[1:]]
    written = written[: len(texts)]
    pairs = {p for outlines, text in zip(written, texts, strict=False) for p in zip(outlines, text)}
    outlines, letters = {outline for outline, _ in pairs}, {letter for _, letter in pairs}
    same_lengths = [len(w) for w in written] == [len(t) for t in texts]
    return same_lengths and len(outlines) == len(letters) == len(pairs)


@dataclass
class Answers:
    """What each way says of one set."""

    dataset: tagcal.Dataset
    python: tagcal.Calibration
    terminal: str  # in one line
    json: Any
    file: Path
    from_file: tagcal.UncertainCamera
    page: Any
    page_of_file: Any
    picture: str


@pytest.fixture(scope="module", params=list(SETS))
def answers(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Answers:
    if not COMMAND.exists():
        pytest.skip("the command is not built")
    folder, options = SETS[request.param]
    words: list[object] = ["calibrate", folder, "--board-warp"]
    if "model" in options:
        words += ["--model", options["model"]]
    for name, value in options.get("fixed", {}).items():
        words += ["--fix", f"{name}={value}"]
    out = tmp_path_factory.mktemp("claim")
    file, page, picture = out / "camera.yaml", out / "page.html", out / "uncertainty.svg"
    terminal = command(*words, "--out", file, "--report", page, "--uncertainty", picture)
    command("report", file, "--out", out / "file.html")
    dataset = tagcal.read_dataset(folder).dataset
    return Answers(
        dataset,
        tagcal.calibrate(dataset, **options),
        " ".join(terminal.split()),
        json.loads(command(*words, "--json")),
        file,
        tagcal.read_camera(file),
        data_of_page(page),
        data_of_page(out / "file.html"),
        picture.read_text(),
    )


def test_the_claim(answers: Answers) -> None:
    """To the last bit: file and JSON have all digits of a number."""
    claim, in_json = answers.python.claim, answers.json["claim"]
    assert claim is not None
    assert (in_json["model"], in_json["parameters"]) == (claim.model, claim.parameters)
    text = answers.file.read_text()
    assert f'claim_model: "{claim.model}"' in text
    for covariance in [
        in_json["covariance"],
        covariance_in_file(text, "claim_covariance"),
        answers.from_file.claim.covariance,
        answers.python.uncertain_camera.claim.covariance,
    ]:
        np.testing.assert_array_equal(covariance, claim.covariance)
    np.testing.assert_array_equal(answers.from_file.covariance, answers.python.covariance)
    held = [claim.parameters.index(name) for name in answers.python.fixed]
    assert not claim.covariance[held].any() and not claim.covariance[:, held].any()
    copied = next(f["text"] for f in answers.page["formats"] if f["name"].startswith("tagcal"))
    np.testing.assert_array_equal(covariance_in_file(copied, "claim_covariance"), claim.covariance)


def test_the_covariance_of_the_answer_follows_from_it(answers: Answers) -> None:
    """Each free parameter is the mean of the lens parameters that it sets."""
    claim = answers.python.claim
    assert claim is not None and answers.python.covariance is not None
    names = {"f": ["fx", "fy"]}
    rows = []
    for name in answers.python.free_parameters:
        of_claim = [n for n in names.get(name, [name]) if n in claim.parameters] or [name]
        rows.append([of_claim.count(n) / len(of_claim) for n in claim.parameters])
    by_claim = np.array(rows)
    scale = np.sqrt(np.diag(answers.python.covariance))
    np.testing.assert_allclose(
        by_claim @ claim.covariance @ by_claim.T / np.outer(scale, scale),
        answers.python.covariance / np.outer(scale, scale),
        atol=1e-9,
    )


def test_parameters(answers: Answers) -> None:
    found = answers.python
    assert answers.from_file.sigmas == found.sigmas
    shown = {p["name"]: p for p in answers.page["parameters"]}
    for page in [answers.page, answers.page_of_file]:
        assert {p["name"]: p["text"] for p in page["parameters"]} == {
            name: p["text"] for name, p in shown.items()
        }
    for i, (name, sigma) in enumerate(found.sigmas.items()):
        if name not in shown:
            assert sigma == 0
            continue
        in_json = answers.json["sigma"]
        assert (in_json[name] if i < 4 else in_json["distortion"][i - 4]) == sigma
        assert is_rounded(shown[name]["sigma"], sigma)
        if sigma == 0:
            assert shown[name]["text"].endswith(", held")
            continue
        printed = re.search(rf" {name} (-?[\d.]+) \+- ([\d.]+)", answers.terminal)
        assert printed, name
        assert is_printed(printed[1], found.camera.parameters[name]), name
        assert is_printed(printed[2], sigma), name
        assert shown[name]["text"] == f"{printed[1]} +- {printed[2]}"


def test_the_projection(answers: Answers) -> None:
    far = answers.python.projection[0]
    assert np.isinf(far.distance_m)
    again = tagcal.projection_uncertainty(answers.from_file)
    np.testing.assert_array_equal(again.sigma_px, far.sigma_px)
    assert again.region_px == far.region_px
    in_json = answers.json["projection"][0]
    numbers = far.region_px, far.sigma_px[6, 10], np.nanmax(far.sigma_px)
    keys = "rms_px", "centre_px", "whole_image_max_px"
    printed = re.search(r"accuracy ([\w. ]+?)(?: px)? where corners were, ([\w. ]+?)(?: px)? in the "
                        r"centre, ([\w. ]+?)(?: px)? at most[^()]*\(sd at infinity\)",
                        answers.terminal)  # fmt: skip
    assert printed
    diagonal = np.hypot(*answers.dataset.size)
    for text, key, number in zip(printed.groups(), keys, numbers, strict=True):
        assert in_json[key] == (number if number <= diagonal else None)
        assert is_printed(text, in_json[key]), key
    for page in [answers.page, answers.page_of_file]:
        on_page = page["projection"][-1]
        assert on_page["distance_m"] is None
        for key, number in zip(["region_px", "centre_px", "max_px"], numbers, strict=True):
            assert is_rounded(on_page[key], number), key
        for shown, sigma in zip(sum(on_page["sigma_px"], []), far.sigma_px.ravel(), strict=True):
            assert is_rounded(shown, sigma, 4)
    nodes = far.sigma_px[1:-1:3, 2:-1:4].ravel()
    labels = ["no ray" if np.isnan(sigma) else f"{sigma:.2g}" if sigma <= diagonal else "no bound"
              for sigma in nodes]  # fmt: skip
    title = "sd of the projection at infinity, pixels per coordinate; dashed: where corners were"
    assert shows_texts(answers.picture, [title, *labels])
    near = answers.python.projection[1]
    assert answers.json["projection"][1]["rms_px"] == near.region_px
    shown = answers.page["projection"][0]
    same = [p for p in answers.python.projection if p.distance_m == shown["distance_m"]]
    assert not same or is_rounded(shown["region_px"], same[0].region_px)


def test_points(answers: Answers, tmp_path: Path) -> None:
    """project and unproject, Python, and J C J' by the claim."""
    camera, claim = answers.python.camera, answers.python.claim
    assert claim is not None
    width, height = answers.dataset.size
    places = [[0.5, 0.5], [0.25, 0.3], [0.7, 0.8]]
    pixels = np.array(places) * [width, height]
    points = 1.5 * camera.unproject(pixels)
    expected, covariances = answers.python.uncertain_camera.project(points)
    _, _, by_claim = camera.jacobians(points, model=claim.model)
    for covariance, jacobian in zip(covariances, by_claim, strict=True):
        exact = jacobian @ claim.covariance @ jacobian.T
        np.testing.assert_allclose(covariance, exact, rtol=1e-6, atol=1e-9 * np.max(exact))
    np.testing.assert_array_equal(answers.from_file.project(points)[1], covariances)
    table = tmp_path / "points.csv"
    np.savetxt(table, points, fmt="%.17g", delimiter=",", header="x_m,y_m,z_m", comments="")
    rows = command("project", table, "--camera", answers.file).splitlines()[1:]
    for row, pixel, s in zip(rows, expected, covariances, strict=True):
        values = [float(x) for x in row.split(",")[3:8]]
        assert values == [*pixel, s[0, 0], s[0, 1], s[1, 1]]
    np.savetxt(table, pixels, fmt="%.17g", delimiter=",", header="u_px,v_px", comments="")
    rows = command("unproject", table, "--camera", answers.file).splitlines()[1:]
    directions, covariances = answers.python.uncertain_camera.direction(pixels)
    for row, direction, s in zip(rows, directions, covariances, strict=True):
        values = [float(x) for x in row.split(",")[2:11]]
        assert values == [*direction, *s[np.triu_indices(3)]]
    assert answers.from_file.camera_error_px == answers.python.camera_error_px  # pose takes it


def test_the_board(answers: Answers) -> None:
    """Terms of the board, and the residuals from it: of the page and of Python."""
    warp = answers.python.board_warp
    in_json, on_page = answers.json["board_warp"], answers.page["warp"]
    assert warp is not None
    assert warp.to_dict() == in_json
    for key, value in in_json.items():
        shown = on_page[key] if isinstance(value, list) else [on_page[key]]
        for number, exact in zip(shown, np.ravel(value), strict=True):
            assert is_rounded(number, exact), key
    printed = re.search(r"board bent by (\S+) \+- (\S+) mm along x, (\S+) \+- (\S+) mm along y, "
                        r"twisted by (\S+) \+- (\S+) mm, longer along y by (\S+) \+- (\S+) %",
                        answers.terminal)  # fmt: skip
    assert printed
    for text, number in zip(
        printed.groups(),
        [warp.bend_mm[0], warp.sigma_mm[0], warp.bend_mm[1], warp.sigma_mm[1],
         warp.twist_mm, warp.sigma_twist_mm, 100 * warp.aspect, 100 * warp.sigma_aspect],
        strict=True,
    ):  # fmt: skip
        assert is_printed(text, number)
    corners = answers.page["corners"]
    takes_part = np.isin(corners["view"], [v.view for v in answers.python.views])
    shown = np.array([corners["du"], corners["dv"]], float).T[takes_part]
    np.testing.assert_allclose(
        shown, residuals_of(answers.python, answers.dataset).vectors, rtol=6e-4, atol=1e-12
    )


def test_validate_and_diff(answers: Answers, tmp_path: Path) -> None:
    sigmas = answers.python.sigmas
    if answers.dataset.truth is not None:
        judged = json.loads(command("validate", answers.file, "--dataset", DESK, "--json"))
        assert {p["name"]: p["sigma"] for p in judged["parameters"]} == sigmas
    differences = json.loads(command("diff", answers.file, answers.file, "--json"))["differences"]
    # Of two independent cameras with this claim, as lengths instead of coordinates.
    expected = 2 * answers.python.projection[0].region_px
    assert differences[0]["expected_px"] == pytest.approx(expected, rel=0.02)  # other samples
    command("report", answers.file, answers.file, "--out", tmp_path / "two.html")
    difference = data_of_page(tmp_path / "two.html")["difference"]
    for p in difference["parameters"]:
        assert is_rounded(p["sigma_a"], sigmas[p["name"]])
    assert is_rounded(difference["maps"][-1]["expected_px"], differences[0]["expected_px"])
