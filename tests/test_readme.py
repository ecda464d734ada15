"""The README's examples run as printed."""

import re
from pathlib import Path

import clearance as cl
from clearance import cli

TEXT = (Path(__file__).parent.parent / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


def test_python_example(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    example = next(b for b in BLOCKS if "load_case" in b)
    exec(compile(example, "README", "exec"), {})
    assert (tmp_path / "run.h5").exists()
    assert capsys.readouterr().out


def test_sweep_example(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(next(b for b in BLOCKS if "cl.sweep(" in b), "README", "exec"), {})
    assert cl.open_sweep(tmp_path / "map").done.all()
    assert "slider_acceleration_max" in capsys.readouterr().out


def test_joint_friction_example(capsys):
    exec(compile(next(b for b in BLOCKS if "inverse_dynamics(" in b), "README", "exec"), {})
    assert capsys.readouterr().out


def test_own_mechanism(tmp_path, capsys):
    path = tmp_path / "my_mechanism.py"
    path.write_text(next(b for b in BLOCKS if "def scene(" in b))
    assert cli.main(["run", str(path), "--turns", "1", "-o", str(tmp_path / "r.h5"), "--json"]) == 0
    assert cl.open_result(tmp_path / "r.h5").complete


def test_own_law(tmp_path):
    path = tmp_path / "own_law.py"
    block = next(b for b in BLOCKS if "@contact" in b)
    path.write_text(
        "import clearance as cl\n" + block + "\ndef scene():\n"
        "    law = liner(stiffness=1e8, hardening=1e8, damping=200.0)\n"
        "    return cl.Scene(cl.ClearanceRevolute(cl.ground, cl.Body('ball', 0.5, 1e-4), name='J', radius=0.01,\n"
        "        clearance=1e-4, contact=law))\n"
    )
    result = cl.simulate(cl.load_case(path), until=0.02)
    assert (result.joint("J").contact_force >= 0.0).all()
    assert len(result.events["time"]) > 0


def test_first_command_is_the_main_job():
    assert "clearance run six_bar_feeder -p model=lubricated -p joints=B --turns 6 -o run.h5 --plot" in TEXT


def test_pictures_exist():
    for picture in re.findall(r"!\[.*?\]\((.*?)\)", TEXT):
        assert (Path(__file__).parent.parent / picture).exists()
