"""`clearance figures`: every script says what it shows; what is drawn is noted; results are used again."""

import json

import pytest
from clearance.paper_figures import gallery, workshop

import clearance as cl
from clearance import cli
from clearance.results import locked

NAMES = workshop.names()


@pytest.mark.parametrize("name", NAMES)
def test_each_script_says_what_it_shows_and_what_cannot_be_compared(name):
    title, about = workshop.about(name)
    assert title
    assert len(title) <= 110
    assert all(len(text) > 3 for text in about.values())
    assert list(about) == list(workshop.PARTS)


def drawn(folder, *arguments):
    status = cli.main(["figures", *arguments, "-o", str(folder), "--json"])
    return status, gallery.read(folder)


def test_pictures_tables_manifest_and_page(tmp_path, capsys):
    status, figures = drawn(tmp_path, "feeder_sketch")
    document = json.loads(capsys.readouterr().out)
    assert (status, document["status"]) == (0, "complete")
    entry = figures["feeder_sketch"]
    assert {"feeder_sketch.png", "feeder_sketch.pdf"} <= set(entry["files"])
    assert all((tmp_path / f).stat().st_size > 1000 for f in entry["files"])
    (result,) = entry["results"]
    assert (tmp_path / result["file"]).exists()
    assert result["parameters"] == {"model": "ideal"}
    assert "feeder_sketch.png" in (tmp_path / "index.html").read_text()


def test_results_are_used_again_unless_fresh(tmp_path, capsys):
    drawn(tmp_path, "feeder_sketch")
    (file,) = (tmp_path / "results").glob("*.h5")
    made = file.stat().st_mtime_ns
    drawn(tmp_path, "feeder_sketch")
    assert file.stat().st_mtime_ns == made
    drawn(tmp_path, "feeder_sketch", "--fresh")
    assert file.stat().st_mtime_ns > made


def test_a_broken_result_is_made_anew(tmp_path, capsys):
    drawn(tmp_path, "feeder_sketch")
    (file,) = (tmp_path / "results").glob("*.h5")
    file.write_bytes(file.read_bytes()[:5000])
    status, figures = drawn(tmp_path, "feeder_sketch")
    assert (status, figures["feeder_sketch"]["status"]) == (0, "done")


def test_sweeps_are_used_again_unless_fresh_and_not_for_another_case(tmp_path, monkeypatch):
    source = "import clearance as cl\n\n\ndef scene(*, mass: float = 1.0) -> cl.Scene:\n    body = "
    source += "cl.Body('b', mass, 1.0)\n    return cl.Scene(cl.Revolute(cl.ground, body, name='A'), name='one')\n"
    case = tmp_path / "one.py"

    def journals(**more):
        work = workshop.Workshop(tmp_path / "f", "name", **more)
        work.sweep(str(case), cl.grid(mass=[1.0, 2.0]), until=0.1, channels=[], workers=1)
        return {p: p.stat().st_mtime_ns for p in (tmp_path / "f").rglob("journal.jsonl")}

    case.write_text(source)
    first = journals()
    assert journals() == first
    fresh = journals(fresh=True)
    assert fresh.keys() == first.keys()
    assert fresh != first
    case.write_text(source + "# a remark\n")
    assert len(journals()) == 2


def test_previews_say_so(tmp_path, capsys):
    drawn(tmp_path, "feeder_sketch", "--quick")
    assert "coarse preview" in (tmp_path / "index.html").read_text()


def test_one_at_a_time_in_a_folder(tmp_path, capsys):
    with locked(tmp_path, "drawing"):
        assert cli.main(["figures", "feeder_sketch", "-o", str(tmp_path)]) == 2
    assert "is in use" in capsys.readouterr().err


def test_a_file_is_no_folder(tmp_path, capsys):
    (tmp_path / "f").write_text("")
    assert cli.main(["figures", "feeder_sketch", "-o", str(tmp_path / "f")]) == 2
    assert "is a file" in capsys.readouterr().err


#: their studies have tests of their own, and compile dozens of mechanisms
LONG = {"evidence_physics", "evidence_ablation", "evidence_work_precision", "evidence_films", "evidence_stress"}


@pytest.mark.parametrize("name", sorted(set(NAMES) - LONG))
def test_every_script_draws_a_preview(name, tmp_path, capsys):
    status, figures = drawn(tmp_path, name, "--quick")
    assert (status, figures[name]["status"]) == (0, "done")
    assert any(f.endswith(".pdf") for f in figures[name]["files"])


def test_a_figure_that_fails_is_named_and_stops_no_other(tmp_path, monkeypatch, capsys):
    from clearance.paper_figures import feeder_sketch

    def fails(work):
        raise ValueError("no such joint")

    monkeypatch.setattr(feeder_sketch, "draw", fails)
    monkeypatch.setattr(workshop, "names", lambda: ["feeder_sketch", "five_axis_chain"])
    status, figures = drawn(tmp_path)
    assert status == 1
    assert figures["feeder_sketch"]["status"] == "failed: ValueError: no such joint"
    assert "no such joint" in (tmp_path / "feeder_sketch.log").read_text()
    assert figures["five_axis_chain"]["status"] == "done"


def test_unknown_names_are_refused_with_those_there_are(tmp_path, capsys):
    assert cli.main(["figures", "feeder_sketsh", "-o", str(tmp_path / "f")]) == 2
    assert "feeder_sketch" in capsys.readouterr().err
    assert not (tmp_path / "f").exists()


def test_a_folder_with_another_manifest_is_refused(tmp_path, capsys):
    (tmp_path / "manifest.json").write_text('{"format": "other"}')
    assert cli.main(["figures", "feeder_sketch", "-o", str(tmp_path)]) == 2
    assert "not a manifest of figures" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["manifest.json"]


def test_list_gives_names_and_titles(capsys):
    assert cli.main(["figures", "--list", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)) == set(NAMES)
