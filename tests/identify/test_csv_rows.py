"""CSV files as instruments and spreadsheets write them: one reader for `fit` and `identify`."""

import gzip

import numpy as np
import pytest

from clearance.identify import measured, records

UNITS = {"time": "ms", "w": "deg/s", "M": "Nmm"}
COLUMNS = {"time": "time", "rate_z": "w", "torque_z": "M"}


def above(random, mark):
    """Lines that an instrument writes above its table."""
    lines = [
        "Device: DAQ 7; rev. 3, 24 bit\tsingle",
        f"Date{mark}2024-03-12",
        f"Rate [Hz]{mark}1000",
        f"Range{mark}0{mark}10{mark}",
        f"Operator{mark}Anna B.",
        f'Note{mark}a 5" shaft',
        f"Channel{mark}Gain{mark}Offset\n1{mark}2{mark}0\n2{mark}5{mark}1\n3{mark}1{mark}1",
        "# bench = 3",
        "# cleaned, oiled",
        "",
        mark * 3,
    ]
    return [f"sep={mark}"] * random.integers(2) + [
        lines[i] for i in random.permutation(len(lines))[: random.integers(len(lines))]
    ]


def head(random, names, mark):
    """Names with units behind them, in brackets or behind underscores, or in a row below."""
    style = random.integers(6)
    if style == 5:
        ends = {"time": "ms", "w": "deg_s", "M": "N_mm"}
        return [mark.join(f"{n}_{ends[n]}" if n in UNITS else n for n in names)]
    if style < 2:
        ends = ("[]", "()")[style]
        return [mark.join(f"{n} {ends[0]}{UNITS[n]}{ends[1]}" if n in UNITS else n for n in names)]
    ends = ("", "[]", "()")[style - 2]
    units = (f"{ends[:1]}{UNITS[n]}{ends[1:]}" if n in UNITS else "" for n in names)
    return [mark.join(names), mark.join(units)]


def number(random, value, comma, mark):
    """A number as one of several programs writes it."""
    text = (f"{value:.12g}", f"{value:.12E}", f" {value:.12f}")[random.integers(3)]
    text = text.replace(".", ",") if comma else text
    return f'"{text}"' if comma and mark == "," else text


def written(path, seed):
    """A file of random form with values of 60 samples, (3, 60) in SI."""
    random = np.random.default_rng(seed)
    mark, comma = ",;\t"[random.integers(3)], bool(random.integers(2))
    values = np.stack([1e-3 * np.arange(60), *random.normal(size=(2, 60))])
    values[1] *= 0.1
    columns = dict(zip(UNITS, values * [[1e3], [180.0 / np.pi], [1e3]], strict=True))
    names = [str(n) for n in random.permutation([*UNITS, "state"])]
    in_head, in_rows = (mark * random.integers(3) for _ in range(2))
    lines = [*above(random, mark), *(line + in_head for line in head(random, names, mark))]
    for k in range(60):
        numbers = {n: number(random, v[k], comma, mark) for n, v in columns.items()}
        state = ("", "ok", "3")[random.integers(3)]
        lines.append(mark.join(numbers.get(n, state) for n in names) + in_rows)
    lines += ["", mark * 3][: random.integers(3)]
    text = random.choice(["", "\ufeff"]) + random.choice(["\n", "\r\n"]).join(lines)
    path.write_bytes(gzip.compress(text.encode()) if path.suffix == ".gz" else text.encode())
    return values


@pytest.mark.parametrize("seed", range(60))
def test_files_of_any_form(tmp_path, seed):
    """Twelve digits are written: values come to 1e-11 of their size."""
    path = tmp_path / ("bench.csv", "bench.csv.gz")[seed % 2]
    time, rate, torque = written(path, seed)
    record = measured.read(path, "M")
    assert (record.along, record.units, record.column[0]) == ("time", "N m", "M")
    np.testing.assert_allclose(record.x, time, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(record.values, torque, rtol=1e-11, atol=1e-11)
    (trial,) = records.read(path, columns=COLUMNS).trials
    np.testing.assert_allclose(trial.rate[:, 2], rate, rtol=1e-11, atol=1e-11)
    np.testing.assert_array_equal(trial.torque[:, 2], record.values)
