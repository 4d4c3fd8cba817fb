"""Populations of units and their changes, from arrays."""

import numpy as np
import pytest
import tagcal


def world(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Three quantities with a spread of 2 and an own standard deviation of 1."""
    random = np.random.default_rng(seed)
    values = 100 + np.sqrt(5) * random.normal(size=(count, 3))
    return values, np.tile(np.eye(3), (count, 1, 1))


def test_an_outlying_unit_is_found() -> None:
    values, covariances = world(400)
    values[17, 1] += 10 * np.sqrt(5)
    population = tagcal.estimate_population(values, covariances)
    assert population.status == "ok"
    assert np.allclose(population.spread, 2, atol=0.4)
    distances = tagcal.unit_distances(population, values, covariances)
    worst = min(range(400), key=lambda i: distances[i].p_value)
    assert worst == 17 and distances[17].quantity == 1
    assert distances[17].in_sigmas == pytest.approx(10, abs=2.5)


def test_few_units_and_wrong_shapes() -> None:
    values, covariances = world(12)
    few = tagcal.estimate_population(values, covariances)
    assert few.status == "not_observable" and few.findings[0].code == "few_units"
    with pytest.raises(tagcal.Error, match="population: is no answer"):
        tagcal.unit_distances(few, values, covariances)
    with pytest.raises(tagcal.Error, match="covariances: must have the shape"):
        tagcal.estimate_population(values, covariances[:5])
    with pytest.raises(tagcal.Error, match="values: must have the shape"):
        tagcal.estimate_population(values[0], covariances)


def test_a_trend() -> None:
    random = np.random.default_rng(2)
    days = np.arange(6.0)[:, None] * 30
    values = 100 + days * [0.1, 0, 0] + random.normal(size=(6, 3))
    trend = tagcal.estimate_trend(values, np.tile(np.eye(3), (6, 1, 1)), days)
    assert trend is not None
    assert trend.slopes[0, 0] == pytest.approx(0.1, abs=5 * trend.sigmas[0, 0])
    of_days, of_scatter = tagcal.trend_p_values(trend)
    assert of_days < 1e-6 < 1e-3 < of_scatter
    assert tagcal.repeat_inflation([trend]) == 1
    assert tagcal.estimate_trend(values, np.tile(np.eye(3), (6, 1, 1)), days * 0) is None


def test_a_history() -> None:
    random = np.random.default_rng(4)
    calibrations = [
        tagcal.UncertainCamera(
            tagcal.Camera.pinhole(900 + 5 * k + random.normal(), 900 + 5 * k + random.normal(), 640, 400,
                                  (1280, 800)), "pinhole", np.eye(4))
        for k in range(8)]
    history = tagcal.estimate_history(calibrations)
    assert history.verdict == "trend" and history.false_alarm == 0.01
    fx = history.trend.parameters[0]
    assert fx.name == "fx" and abs(fx.px - 5) < 5 * fx.sigma_px
    assert tagcal.estimate_history(calibrations[:2], [0.0, 1.0]).verdict == "too_few"
    with pytest.raises(tagcal.Error, match="keys: must be 8"):
        tagcal.estimate_history(calibrations, [1.0])
