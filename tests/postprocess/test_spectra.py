"""Amplitudes of known sinusoids, Parseval, full turns, and what cannot have a spectrum."""

import numpy as np
import pytest
from clearance.postprocess.spectra import amplitudes, spectra, spectrum

import clearance as cl
from tests.postprocess.records import Formula

PARTS = {1: 2.0, 2: 0.3, 7: 0.05, 40: 1e-3}  # order of the drive -> amplitude
MEAN = -0.7


def signal(t):
    return MEAN + sum(a * np.sin(2.0 * np.pi * k * t + 0.3 * k) for k, a in PARTS.items())


def series(time, path="joints/C/force_x", **options):
    return Formula(time, {path: signal}, **options)


@pytest.mark.parametrize("window", ["hann", "none"])
@pytest.mark.parametrize("turns", [2.0, 5.0, 7.4])
def test_a_sum_of_sinusoids(window, turns, validated):
    """Over full turns each harmonic stands on a frequency of its own; only rounding is left, 1e-12
    of the largest.

    That holds for the smallest amplitude too, 2000 times smaller than the largest, for the three
    lines of a periodic Hann window do not reach the next harmonic.
    """
    lines = spectrum(series(np.arange(round(400 * turns) + 1) / 400.0), "C.force_x", window=window)
    assert lines.turns == int(turns)
    assert lines.resolution == pytest.approx(1.0 / int(turns), rel=1e-12)
    at = {k: lines.amplitude[k * lines.turns] for k in range(200)}
    assert at.pop(0) == pytest.approx(abs(MEAN), rel=1e-12)
    wanted, source = [PARTS.get(order, 0.0) for order in at], "sinusoids given"
    validated(
        "amplitudes of 199 orders",
        [*at.values()],
        wanted,
        2e-12,
        source=source,
        kind="exact",
        relative=False,
    )


def test_samples_that_do_not_divide_a_turn():
    """150.5 samples a turn are interpolated: amplitudes to 1e-3.

    Four points err by 3 (w h)^4 / 128 at worst, of a sinusoid: 2e-4 at order 7, 0.18 at order 40,
    of which the smallest amplitude is 1e-3, so 2e-4 of the unit again.
    """
    lines = spectrum(series(np.arange(1200) / 150.5), "C.force_x")
    assert lines.turns == 7
    for order, amplitude in PARTS.items():
        assert lines.amplitude[order * 7] == pytest.approx(amplitude, abs=1e-3)


def test_the_last_turns_are_taken():
    """A transient before them leaves no trace."""
    time = np.arange(1601) / 400.0
    late = np.where(time < 1.9, 100.0, signal(time))
    lines = spectrum(Formula(time, {"joints/C/force_x": late}), "C.force_x", settle=1.95)
    assert lines.turns == 2
    assert lines.amplitude[2] == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize("count", [400, 401])
def test_parseval_without_window(count, validated):
    """Mean square = mean^2 + half the squares of the amplitudes (the full square at half the
    sampling rate).
    """
    values = np.random.default_rng(3).normal(size=count) + 2.0
    frequency, amplitude = amplitudes(values, 0.01, "none")
    halves = np.full(len(amplitude), 0.5)
    halves[0] = 1.0
    if count % 2 == 0:
        halves[-1] = 1.0
        assert frequency[-1] == pytest.approx(50.0)
    lines, wanted = halves @ amplitude**2, np.mean(values**2)
    validated("mean square of a spectrum", lines, wanted, 1e-12, source="Parseval", kind="exact")


@pytest.mark.parametrize(("window", "loss"), [("hann", 0.1512), ("none", 0.3634)])
def test_between_two_frequencies(window, loss, validated):
    """Half-way a sinusoid shows 8/(3 pi) or 2/pi of its amplitude; 1e-3 for what leaks from
    negative frequencies.
    """
    t = np.arange(4000)
    _, amplitude = amplitudes(np.cos(2.0 * np.pi * 1000.5 * t / 4000), 1.0, window)
    options = {"source": "8 / (3 pi) and 2 / pi", "kind": "exact", "relative": False}
    validated(
        "amplitude half-way between two frequencies", amplitude.max(), 1.0 - loss, 1e-3, **options
    )


def test_one_turn_has_no_window():
    """A single turn is taken as it is."""
    lines = spectrum(series(np.arange(401) / 400.0), "C.force_x")
    assert (lines.turns, lines.window) == (1, "none")
    assert lines.amplitude[2] == pytest.approx(0.3, rel=1e-9)


def test_without_a_drive():
    """All samples of a run that nothing drives; 0.5 Hz is its resolution."""
    lines = spectrum(series(np.linspace(0.0, 2.0, 401), speed=None), "C.force_x", window="none")
    assert lines.turns is None
    assert lines.resolution == pytest.approx(1.0 / (401 * 0.005), rel=1e-12)
    uneven = np.sort(np.random.default_rng(5).uniform(0.0, 2.0, 3000))
    again = spectrum(series(uneven, speed=None), "C.force_x")
    # 1 Hz; not of complete periods exactly
    assert again.amplitude[2] == pytest.approx(2.0, rel=1e-2)


def test_what_has_no_spectrum():
    """Too little of a run, unknown windows and channels are refused."""
    with pytest.raises(
        ValueError, match="formula has 0.5 turns after turn 0; a spectrum needs one"
    ):
        spectrum(series(np.arange(201) / 400.0), "C.force_x")
    with pytest.raises(ValueError, match="formula has 5 samples after turn 0; a spectrum needs 8"):
        spectrum(series(np.linspace(0.0, 3.0, 5)), "C.force_x")
    with pytest.raises(ValueError, match="window must be one of hann, none; got 'flat'"):
        spectrum(series(np.arange(801) / 400.0), "C.force_x", window="flat")
    with pytest.raises(ValueError, match="no channel 'C.gap'"):
        spectrum(series(np.arange(801) / 400.0), "C.gap")


def test_samples_too_coarse():
    """Noise leaves half of its power unresolved, sinusoids nothing."""
    time = np.arange(801) / 400.0
    noise = np.random.default_rng(2).normal(size=801)
    assert spectrum(series(time), "C.force_x").unresolved < 1e-20
    assert spectrum(
        Formula(time, {"joints/C/force_x": noise}), "C.force_x"
    ).unresolved == pytest.approx(0.5, abs=0.1)
    assert spectrum(Formula(time, {"joints/C/force_x": 0 * noise}), "C.force_x").unresolved == 0.0


def test_acceleration_is_w_times_velocity():
    """Spectra of a run's velocity and acceleration differ by the angular frequency: 1e-3 of the
    first two orders.
    """
    run = cl.simulate(cl.load_case("four_bar"), turns=2.0)
    v, a = (spectrum(run, f"rocker.{n}") for n in ("vx", "ax"))
    for order in (1, 2):
        k = order * v.turns
        assert a.amplitude[k] == pytest.approx(
            2.0 * np.pi * v.frequency[k] * v.amplitude[k], rel=1e-3
        )


def test_the_picture(tmp_path, gallery):
    """Resolution and window of each run; orders of the drive above."""
    runs = [
        cl.simulate(
            cl.load_case("six_bar_feeder", joints="B", clearance=c), turns=t, samples_per_turn=100
        )
        for c, t in ((1e-4, 3.0), (2e-4, 2.5))
    ]
    path = spectra(runs, tmp_path / "s.png", channels=["slider.ax", "B.epsilon"])
    assert path.read_bytes().startswith(b"\x89PNG")
    texts = gallery.texts()
    title = next(t for t in texts if "resolution" in t)
    assert "clearance 0.1 mm: resolution 1.667 Hz (3 turns), Hann window" in title
    assert "clearance 0.2 mm: resolution 2.5 Hz (2 turns), Hann window" in title
    assert {"frequency [Hz]", "order of the drive [-]"} <= set(texts)
    assert gallery.smallest_text() >= 8.0
    (orders,) = gallery.last.axes[0].child_axes
    low, high = gallery.last.axes[0].get_xlim()
    assert orders.get_xlim() == pytest.approx((low * 0.2, high * 0.2))


def test_the_picture_of_a_dry_run_says_that_samples_are_coarse(tmp_path, gallery):
    """Impacts are shorter than the samples."""
    spectra(
        cl.simulate(cl.load_case("slider_crank", model="dry"), turns=2),
        tmp_path / "s.png",
        channels="C.force",
    )
    assert any("samples too coarse" in t for t in gallery.texts())


def test_a_channel_that_is_zero(tmp_path):
    """Its picture is empty, and no error."""
    record = Formula(np.arange(801) / 400.0, {"joints/C/force_x": np.zeros(801)})
    assert spectra(record, tmp_path / "s.png", channels="C.force_x").exists()
