"""`clearance inverse`: summary, file, JSON, exit status."""

import numpy as np
import pytest

import clearance as cl


def test_summary_and_file(tmp_path, typed, monkeypatch):
    """The summary has torques and forces; the file is complete."""
    monkeypatch.chdir(tmp_path)
    _, text, err = typed("inverse three_loop_chain --until 10s --samples 51")
    assert not err
    assert "three_loop_chain: 51 samples over 10 s" in text
    assert "drive crank    largest torque 2.07177 N m (1.9993 N m without joint friction)" in text
    assert "joint ground-g largest force 243.681 N, friction 0.1228" in text
    assert "power        residual" in text
    with cl.open_result("three_loop_chain_inverse.h5") as result:
        assert result.complete
        assert result.time.size == 51


def test_json(tmp_path, typed):
    """The document of an inverse solution has what the summary has."""
    out = tmp_path / "all.h5"
    words = "inverse three_loop_chain -p where=all -p pin_radius=5mm --until 10 --json -o"
    ended = typed(words, out)
    assert not ended.err
    document = ended.document
    assert (document["status"], document["file"], document["samples"]) == (
        "complete",
        str(out),
        401,
    )
    assert document["parameters"] == {"where": "all", "pin_radius": 0.005}
    assert 1 <= document["friction"]["iterations"] <= 20
    assert 0.0 < document["friction"]["contraction"] < 0.1
    assert document["power_residual"] < 1e-12 * max(1.0, document["power"])
    assert document["loop_s"] < document["solved_s"] < document["wall_s"]
    with cl.open_result(out) as result:
        force, torque = result.joint("e-f").force, result.drive("crank").torque
    assert document["joints"]["e-f"]["force"] == pytest.approx(
        np.linalg.norm(force, axis=1).max(), rel=1e-12
    )
    assert document["drives"]["crank"]["torque"] == np.abs(torque).max()
    # computed before, outside this package
    assert torque[[0, -1]] == pytest.approx([0.999011, 1.164278], abs=5e-7)


def test_a_tree_carries_weight_along_its_axes(tmp_path, typed):
    """Eleven kilograms above the first hinge, at 9.8 m/s2."""
    words = "inverse five_axis_chain --until 3s --json -o"
    document = typed(words, tmp_path / "tree.h5").document
    assert document["method"] == "inverse dynamics"
    assert document["joints"]["1"]["axial_force"] == pytest.approx(107.8)


def test_turns_of_a_constant_drive(tmp_path, typed):
    """A turn of a constant drive; no friction is stated where there is none."""
    document = typed("inverse four_bar --turns 1 --json -o", tmp_path / "r.h5").document
    assert (document["samples"], document["until_s"]) == (401, pytest.approx(0.2))
    assert "friction" not in document
    assert "torque_ideal" not in document["drives"]["crank"]


def test_a_motion_that_ends_part_way(tmp_path, typed):
    """Exit status 1, one line, and what was computed is stored."""
    out = tmp_path / "part.h5"
    ended = typed("inverse three_loop_chain --until 20s --json -o", out, status=1)
    assert ended.err.startswith("clearance: at t = 15.8")
    assert ended.err.count("\n") == 1
    document = ended.document
    assert document["status"] == "failed"
    assert "singular position" in document["message"]
    with cl.open_result(out) as result:
        assert result.status.startswith("partial: ")
        assert result.time[-1] == document["until_s"] == pytest.approx(15.8)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("three_loop_chain --samples 1", "samples must be at least 2, got 1"),
        ("three_loop_chain --samples many", "invalid int value: 'many'"),
        ("three_loop_chain --until 0", "until must be positive, got 0.0"),
        ("three_loop_chain --turns 1", "turns needs a constant-speed rotating drive"),
        ("three_loop_chain --turns 1 --until 1s", "not allowed with argument"),
        ("three_loop_chain -p where=none", "where must be one of driven, all; got 'none'"),
        ("three_loop_chain -p drive=torque", "gives an effort, not a motion"),
        ("three_loop_chain --until 1 --compare", "unrecognized arguments: --compare"),
        ("six_bar_feeder -p model=dry", "has clearance: its motion is not prescribed"),
        ("double_pendulum", "no drive prescribes"),
        ("nosuch", "known: double_pendulum"),
    ],
)
def test_wrong_input_is_one_clear_line(arguments, line, tmp_path, typed, monkeypatch):
    """Wrong arguments: one line, status 2, no file."""
    monkeypatch.chdir(tmp_path)
    assert line in typed.line("inverse", arguments)
    assert not list(tmp_path.iterdir())
