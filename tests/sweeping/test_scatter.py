"""Scatter: designs, estimates and indices against closed forms."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from clearance.postprocess.scatter import scatter
from scipy import stats

import clearance as cl
from clearance.commands.common import DONE
from clearance.sweeping.scatter import (
    Distribution,
    Estimate,
    Indices,
    Scatter,
    design,
    from_words,
    indices,
    open_scatter,
    probability,
    quantile,
    write,
)

UNIT = {name: Distribution("uniform", (-math.pi, math.pi)) for name in ("x", "y", "z")}


def columns(points):
    return {name: np.array(values) for name, values in points.columns.items()}


def test_ishigami():
    """Ishigami's function, a = 7, b = 0.1: indices of its closed form within 0.03; intervals
    contain them.
    """
    points, n = design(UNIT, 5 * 4096)
    at = columns(points)
    assert n == 4096
    values = np.sin(at["x"]) + 7.0 * np.sin(at["y"]) ** 2 + 0.1 * at["z"] ** 4 * np.sin(at["x"])
    a, b, p = 7.0, 0.1, math.pi
    alone = 0.5 * (1.0 + b * p**4 / 5.0) ** 2, a * a / 8.0, 0.0
    both = b * b * p**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = sum(alone) + both
    first = [v / variance for v in alone]
    total = [first[0] + both / variance, first[1], both / variance]
    actual = indices(values, list(UNIT))
    for name, one, all_of_it in zip(UNIT, first, total, strict=True):
        assert actual[name].first.value == pytest.approx(one, abs=0.03)
        assert actual[name].total.value == pytest.approx(all_of_it, abs=0.03)
        assert actual[name].total.low <= all_of_it <= actual[name].total.high


@pytest.mark.parametrize(("first", "total", "doubtful"), [(0.52, 0.5, True), (0.504, 0.5, False)])
def test_doubtful_indices(first, total, doubtful):
    """A first index above the total counts from two printed digits on."""
    assert Indices(*(Estimate(v, 0.0, 1.0) for v in (first, total))).doubtful is doubtful


def test_indices_are_those_of_scipy():
    """The same estimators: equal to rounding."""
    points, n = design(UNIT, 5 * 64)
    at = columns(points)
    rows = (np.sin(at["x"]) + at["y"] * at["z"]).reshape(5, n)
    centred = rows - rows[:2].mean()
    ready = {"f_A": centred[:1], "f_B": centred[1:2], "f_AB": centred[2:, None]}
    theirs, ours = stats.sobol_indices(func=ready, n=n), indices(rows.ravel(), list(UNIT))
    np.testing.assert_allclose(
        [i.first.value for i in ours.values()], np.ravel(theirs.first_order), rtol=1e-9
    )
    np.testing.assert_allclose(
        [i.total.value for i in ours.values()], np.ravel(theirs.total_order), rtol=1e-9
    )


def test_missing_rows():
    """A run that failed takes its row: indices of a linear function stay, a^2 / (a^2 + b^2)."""
    points, n = design({"x": UNIT["x"], "y": UNIT["y"]}, 4 * 1024)
    at = columns(points)
    values = 3.0 * at["x"] + at["y"]
    values[[5, n + 7, 2 * n + 9]] = np.nan
    actual = indices(values, ["x", "y"])
    assert actual["x"].first.value == pytest.approx(0.9, abs=0.02)
    assert actual["y"].total.value == pytest.approx(0.1, abs=0.02)
    assert indices(np.ones(4096), ["x", "y"]) == {}


@pytest.mark.parametrize(
    ("words", "law"),
    [
        ("normal(3, 2)", stats.norm(3.0, 2.0)),
        ("uniform(-1, 4)", stats.uniform(-1.0, 5.0)),
        ("lognormal(2, 1.5)", stats.lognorm(math.log(1.5), scale=2.0)),
        ("triangular(0, 1, 4)", stats.triang(0.25, 0.0, 4.0)),
        ("truncated(0, 1, -1, 2)", stats.truncnorm(-1.0, 2.0)),
    ],
)
def test_distributions(words, law):
    """Mean and deviation of 2048 points at 5e-3 of the deviation: Sobol' points are even."""
    points, n = design({"x": from_words(words), "y": UNIT["x"]}, 4 * 1024)
    values = columns(points)["x"][: 2 * n]
    assert values.mean() == pytest.approx(law.mean(), abs=5e-3 * law.std())
    assert values.std() == pytest.approx(law.std(), rel=1e-2)
    assert len(set(values)) == 2 * n


def test_samples_differ_in_one_parameter():
    """Each block takes one column of the second sample; a seed decides all."""
    points, n = design(UNIT, 5 * 16, seed=3)
    at = np.stack(list(columns(points).values()), axis=1).reshape(5, n, 3)
    for j in range(3):
        np.testing.assert_array_equal(at[2 + j][:, j], at[1][:, j])
        others = [i for i in range(3) if i != j]
        np.testing.assert_array_equal(at[2 + j][:, others], at[0][:, others])
    assert design(UNIT, 5 * 16, seed=3)[0].columns == points.columns
    assert design(UNIT, 5 * 16, seed=4)[0].columns != points.columns


def test_intervals():
    """Of quantiles and probabilities: they contain the truth in at least 93 % of 400 draws of 50
    (95 % requested).
    """
    random, inside, within = np.random.default_rng(0), 0, 0
    for _ in range(400):
        values = random.random(50)
        one, share = quantile(values, 0.9), probability(values > 0.8)
        inside += one.low <= 0.9 <= one.high
        within += share.low <= 0.2 <= share.high
    assert inside >= 372
    assert within >= 372
    assert quantile(np.arange(10.0), 0.99).high == math.inf
    assert probability(np.zeros(20, bool)).low == 0.0


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("normal(1, -2)", "deviation must be positive"),
        ("uniform(2, 1)", "low must be below high"),
        ("normal(1)", "mean, deviation"),
        ("lognormal(1, 0.5)", "factor above 1"),
        ("triangular(0, 3, 2)", "mode must lie between"),
    ],
)
def test_wrong_distributions(words, reason):
    """The message has the reason; words of another kind are left alone."""
    with pytest.raises(ValueError, match=reason):
        from_words(words)
    assert from_words("impact(damping=440)") is None


def test_a_distribution_of_a_word(tmp_path, typed):
    """Words and misspelt distributions are refused in one line."""
    error = "model: a distribution is for numbers with fractions; give one value, as model=dry"
    scatter = "scatter slider_crank -p"
    assert error in typed.line(scatter, "'model=normal(1,2)' -o", tmp_path / "out")
    misspelt = "no distribution 'norml' (did you mean normal?)"
    assert misspelt in typed.line(scatter, "'clearance=norml(50um,5um)'")
    between = "clearance: 50um:60um is no distribution; uniform(50um,60um) is one"
    assert between in typed.line(scatter, "clearance=50um:60um")


def test_too_few_points():
    """The message has the number that is needed."""
    with pytest.raises(ValueError, match="at least 40 for 3 parameters, got 39"):
        design(UNIT, 39)


CRANK = """
import clearance as cl

def scene(*, crank: float = 0.05, rod: float = 0.15) -> cl.Scene:
    \"\"\"A slider-crank with ideal joints.

    crank: length [m]
    rod: length [m]
    \"\"\"
    one = cl.Body("one", 0.3, 1e-4, points={"O": (0, 0), "P": (crank, 0)})
    two = cl.Body("two", 0.2, 5e-4, points={"P": (0, 0), "Q": (rod, 0)}, angle=-0.2)
    block = cl.Body("block", 0.1, 1e-5, points={"Q": (0, 0)})
    return cl.Scene(
        cl.Revolute(cl.ground, one["O"], name="A"), cl.Revolute(one["P"], two["P"], name="B"),
        cl.Revolute(two["Q"], block["Q"], name="C"), cl.Prismatic(cl.ground, block["Q"], name="G"),
        cl.Drive(one, speed=1.0, start=0.0),
    )
"""
PLACE = (
    "def place(run):\n    return float(run['block'].x[-1]), 'm', 'position of the block at the "
    "end'\n"
)


@pytest.mark.slow
def test_slider_crank_with_tolerances(tmp_path):
    """x = r cos a + s, s = sqrt(l^2 - r^2 sin^2 a): dx/dr = cos a - r sin^2 a / s, dx/dl = l / s,
    by hand.

    Deviation within 3 % and shares within 0.03 of the linear theory: 64 points, tolerances of 1e-3.
    """
    (tmp_path / "crank.py").write_text(CRANK)
    (tmp_path / "place.py").write_text(PLACE)
    r, length, a, tolerance = 0.05, 0.15, 1.0, (5e-5, 5e-5)
    actual = cl.scatter(
        tmp_path / "crank.py",
        {"crank": f"normal({r}, {tolerance[0]})", "rod": f"normal({length}, {tolerance[1]})"},
        tmp_path / "out",
        points=256,
        until=a,
        samples=3,
        workers=1,
        metrics=[f"{tmp_path / 'place.py'}:place"],
        limits={"place": 0.17},
    )
    s = math.sqrt(length**2 - (r * math.sin(a)) ** 2)
    parts = [(math.cos(a) - r * math.sin(a) ** 2 / s) * tolerance[0], length / s * tolerance[1]]
    deviation = math.hypot(*parts)
    numbers = actual.summary("place")
    assert numbers["mean"] == pytest.approx(r * math.cos(a) + s, abs=0.1 * deviation)
    assert numbers["deviation"] == pytest.approx(deviation, rel=0.03)
    for name, part in zip(("crank", "rod"), parts, strict=True):
        assert actual.indices("place")[name].first.value == pytest.approx(
            (part / deviation) ** 2, abs=0.03
        )
    exact = stats.norm(r * math.cos(a) + s, deviation).sf(0.17)
    assert actual.beyond("place").low <= exact <= actual.beyond("place").high
    again = open_scatter(tmp_path / "out")
    assert again.summary("place") == numbers
    with pytest.raises(ValueError, match="no metric 'plac' .did you mean place"):
        again.values("plac")


SPREAD = """scatter slider_crank -p model=lubricated -p film=pinkus_sternlicht -p speed=25
-p 'clearance=uniform(200um,400um)' --turns 1"""


def test_the_command(tmp_path, typed):
    """Words with units, limits, a picture; JSON with indices of each parameter."""
    words = "-p 'viscosity=normal(0.4,0.02)' --points 32 --workers 1 --limit joint_C_gap_min=10um"
    line = SPREAD, words, "-o", tmp_path / "out"
    document = typed(*line, "--json", status=DONE).document
    assert document["spread"] == {
        "clearance": "uniform(200 um, 400 um)",
        "viscosity": "normal(0.4, 0.02)",
    }
    assert (document["points"], document["independent"]) == (32, 16)
    gap = document["metrics"]["joint_C_gap_min"]
    assert set(gap["indices"]) == {"clearance", "viscosity"}
    assert gap["limit"] == pytest.approx(1e-5, rel=1e-12)
    assert 0.0 <= gap["beyond"]["low"] <= gap["beyond"]["high"] <= 1.0
    assert (tmp_path / "out" / "scatter.png").stat().st_size > 10_000
    assert repr(open_scatter(tmp_path / "out")) == (
        f"<scatter of clearance, viscosity: {cl.open_sweep(tmp_path / 'out')!r}>"
    )
    histogram, right, *_ = scatter(open_scatter(tmp_path / "out"), metrics=["joint_C_gap_min"]).axes
    assert histogram.get_xlabel() == "smallest gap of joint C, negative in contact [mm]"
    median = gap["quantiles"]["0.5"]["value"]
    assert histogram.lines[1].get_xdata()[0] == pytest.approx(1e3 * median, rel=1e-12)
    assert "beyond 0.01 mm: " in histogram.get_title(loc="left")
    above = [n for n, i in gap["indices"].items() if i["doubtful"]]
    assert ("first above total" in right.get_title(loc="left")) is bool(above)
    printed = typed(*line, status=DONE).out
    assert ("no exact index is" in printed) is any(
        i["doubtful"] for m in list(document["metrics"].values())[:6] for i in m["indices"].values()
    )
    first = gap["indices"]["clearance"]["first"]
    words = f"{first['value']:.2f} ({first['low']:.2f} to {first['high']:.2f})"
    assert f"clearance {words}" in " ".join(printed.split())
    (tmp_path / "out" / "scatter.png").unlink()
    picture = tmp_path / "gap.png"
    typed("plot", tmp_path / "out", "--metrics '*_gap_min' -o", picture)
    typed("plot", tmp_path / "out", status=DONE)
    assert (tmp_path / "out" / "scatter.png").stat().st_size > picture.stat().st_size > 10_000


def test_rounding_is_no_result():
    """Deviations far below their natural size have no indices; small changes of numbers have."""
    noise = np.linspace(0.0, 1.0, 24)
    metrics = {
        "yoke_position_deviation_max": 7e-15 * noise,
        "yoke_acceleration_deviation_rms": 1e-12 * noise,
        "yoke_acceleration_max": 9.0 + 1e-9 * noise,
        "drive_crank_torque_max": 9.0 + 2e-15 * noise,
    }
    units = {
        n: ("m/s2" if "acceleration" in n else "m" if "position" in n else "N m", n)
        for n in metrics
    }
    swept = SimpleNamespace(metrics=metrics, known=units)
    result = Scatter(swept, {"speed": Distribution("uniform", (1.0, 2.0))}, 8, {})
    assert result.metrics == ["yoke_acceleration_max"]
    assert set(result.indices("yoke_acceleration_max")) == {"speed"}
    assert result.summary("yoke_position_deviation_max")["indices"] == {}


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ("joint_C_gap_min=3N", "limit of joint_C_gap_min: '3N' is in N, expected m"),
        ("joint_C_gap_min=3N*m", "this metric is in m, such as 2 m"),
        ("drive_crank_torque_max=11N/s", "this metric is in N m, such as 2 N m"),
        ("joint_C_gap_mim=3um", "no metric 'joint_C_gap_mim' (did you mean joint_C_gap_min"),
    ],
)
def test_wrong_limits(limit, message, tmp_path, typed):
    """Refused before the first point is run."""
    folder = tmp_path / "out"
    assert message in typed.line(SPREAD, f"--points 64 --limit {limit} -o", folder)
    assert not folder.exists()


@pytest.mark.parametrize("seed", range(3))
def test_no_damage_of_a_scatter_turns_into_numbers(tmp_path, monkeypatch, seed):
    """Flipped bits of scatter.json, and entries of another kind: one line, or what was written."""
    rng = np.random.default_rng(seed)
    monkeypatch.setattr("clearance.sweeping.scatter.open_sweep", lambda folder: None)
    spread = {"clearance": Distribution("normal", (1e-4, 1e-5))}
    write(SimpleNamespace(spread=spread, n=32, limits={"peak": 1e3}), tmp_path)
    path, written = tmp_path / "scatter.json", (tmp_path / "scatter.json").read_bytes()
    assert open_scatter(tmp_path).spread == spread
    damaged = []
    for at, bit in zip(rng.integers(0, len(written), 60), rng.integers(0, 8, 60), strict=True):
        damaged.append(bytearray(written))
        damaged[-1][at] ^= 1 << bit
    document = json.loads(written)
    document.pop("crc32")
    for name in ("spread", "n", "limits"):
        damaged += [json.dumps(document | {name: other}).encode() for other in ("x", [1], None)]
    damaged.append(json.dumps(document | {"spread": {"clearance": ["normal"]}}).encode())
    messages, read = [], 0
    for content in damaged:
        path.write_bytes(content)
        try:
            again = open_scatter(tmp_path)
        except ValueError as error:
            messages.append(str(error))
        else:  # a blank that became another
            read += 1
            assert (again.spread, again.n, again.limits) == (spread, 32, {"peak": 1e3})
    assert read < 30
    assert all("scatter.json" in message and "\n" not in message for message in messages)
