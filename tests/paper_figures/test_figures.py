"""`clearance figures`: every script states what it shows; what is drawn is noted; results are used
again.
"""

import argparse
import json
import logging
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from clearance.paper_figures import gallery, structure, workshop

import clearance as cl
from clearance import cli
from clearance.files.locks import locked

NAMES = workshop.names()


@pytest.mark.parametrize("name", NAMES)
def test_each_script_says_what_it_shows_and_what_cannot_be_compared(name):
    """Each script has a title and all paragraphs."""
    title, about = workshop.about(name)
    assert title
    assert len(title) <= 110
    assert all(len(text) > 3 for text in about.values())
    assert list(about) == list(workshop.PARTS)


def drawn(folder, *arguments):
    status = cli.main(["figures", *arguments, "-o", str(folder), "--json"])
    return status, gallery.read(folder)


def test_pictures_tables_manifest_and_page(tmp_path, capsys):
    """A figure leaves pictures, its result, a manifest and a page."""
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


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_results_are_used_again_unless_fresh(tmp_path):
    """A stored result is used again, but with --fresh."""
    drawn(tmp_path, "feeder_sketch")
    (file,) = (tmp_path / "results").glob("*.h5")
    moment = file.stat().st_mtime_ns
    drawn(tmp_path, "feeder_sketch")
    assert file.stat().st_mtime_ns == moment
    drawn(tmp_path, "feeder_sketch", "--fresh")
    assert file.stat().st_mtime_ns > moment


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_one_run_serves_all_who_ask_for_it(tmp_path):
    """Parameters given as they are by default, and another folder of pictures, lead to the same
    result.
    """
    shared = tmp_path / "shared"
    drawn(tmp_path / "a", "feeder_sketch", "--results", str(shared))
    (file,) = shared.glob("*.h5")
    moment = file.stat().st_mtime_ns
    _, figures = drawn(tmp_path / "b", "feeder_sketch", "--results", str(shared))
    assert file.stat().st_mtime_ns == moment
    (result,) = figures["feeder_sketch"]["results"]
    assert (tmp_path / "b" / result["file"]).resolve() == file.resolve()
    work = workshop.Workshop(tmp_path / "c", "name", results=shared)
    options = {"turns": 1.0, "samples_per_turn": 10}
    for parameters in ({"model": "ideal"}, {"model": "ideal", "joints": "B"}):
        work.run("six_bar_feeder", parameters, **options).close()
    assert len({r["file"] for r in work.results}) == 1


@pytest.mark.usefixtures("undrawn")
def test_a_broken_result_is_made_anew(tmp_path):
    """A damaged result is made again."""
    drawn(tmp_path, "feeder_sketch")
    (file,) = (tmp_path / "results").glob("*.h5")
    file.write_bytes(file.read_bytes()[:5000])
    status, figures = drawn(tmp_path, "feeder_sketch")
    assert (status, figures["feeder_sketch"]["status"]) == (0, "done")


def test_sweeps_are_used_again_unless_fresh_and_not_for_another_case(tmp_path):
    """A stored sweep is used for the same case only."""
    source = "import clearance as cl\n\n\ndef scene(*, mass: float = 1.0) -> cl.Scene:\n    body = "
    source += (
        "cl.Body('b', mass, 1.0)\n    return cl.Scene(cl.Revolute(cl.ground, body, "
        "name='A'), name='one')\n"
    )
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


@pytest.mark.usefixtures("undrawn")
def test_previews_say_so(tmp_path):
    """The page states that pictures are previews."""
    drawn(tmp_path, "feeder_sketch", "--quick")
    assert "coarse preview" in (tmp_path / "index.html").read_text()


def test_one_at_a_time_in_a_folder(tmp_path, typed):
    """A folder in use is refused."""
    with locked(tmp_path, "drawing"):
        assert "is in use" in typed.line("figures feeder_sketch -o", tmp_path)


def test_a_file_is_no_folder(tmp_path, typed):
    """A file in place of the folder is refused."""
    (tmp_path / "f").write_text("")
    assert "is a file" in typed.line("figures feeder_sketch -o", tmp_path / "f")


#: their studies have tests of their own, and compile dozens of mechanisms
LONG = {
    "evidence_physics",
    "evidence_ablation",
    "evidence_work_precision",
    "evidence_films",
    "evidence_stress",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(NAMES) - LONG))
def test_every_script_draws_a_preview(name, tmp_path):
    """Each script draws with --quick."""
    status, figures = drawn(tmp_path, name, "--quick")
    assert (status, figures[name]["status"]) == (0, "done")
    assert any(f.endswith(".pdf") for f in figures[name]["files"])


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_figure_that_fails_is_named_and_stops_no_other(tmp_path, monkeypatch):
    """A failure is logged; other figures are drawn."""
    from clearance.paper_figures import feeder_sketch

    def fails(work):
        raise ValueError("no such joint")

    monkeypatch.setattr(feeder_sketch, "draw", fails)
    monkeypatch.setattr(workshop, "names", lambda: ["feeder_sketch", "five_axis_chain"])
    status, figures = drawn(tmp_path, "--workers", "1")
    assert status == 1
    assert figures["feeder_sketch"]["status"] == "failed: ValueError: no such joint"
    assert "no such joint" in (tmp_path / "feeder_sketch.log").read_text()
    assert figures["five_axis_chain"]["status"] == "done"


def test_unknown_names_are_refused_with_those_there_are(tmp_path, typed):
    """An unknown name is answered with the names."""
    assert "feeder_sketch" in typed.line("figures feeder_sketsh -o", tmp_path / "f")
    assert not (tmp_path / "f").exists()


def test_a_folder_with_another_manifest_is_refused(tmp_path, typed):
    """A folder of something else is not touched."""
    (tmp_path / "manifest.json").write_text('{"format": "other"}')
    assert "not a manifest of figures" in typed.line("figures feeder_sketch -o", tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["manifest.json"]


def test_list_gives_names_and_titles_by_groups(typed):
    """The list has all names, under their groups."""
    assert list(typed("figures --list --json").document) == NAMES
    lines = typed("figures --list").out.splitlines()
    assert [line for line in lines if line in workshop.GROUPS.values()] == list(
        workshop.GROUPS.values()
    )
    assert [line.split()[0] for line in lines if line.startswith("  ")] == NAMES


def test_names_stand_by_groups_and_in_the_order_asked_for():
    """Names are sorted by groups; requests keep their order."""
    groups = [workshop.about(name)[1]["Group"] for name in NAMES]
    assert list(dict.fromkeys(groups)) == list(workshop.GROUPS)
    assert groups == sorted(groups, key=list(workshop.GROUPS).index)
    asked = ["sweep_map", "evidence_*", "feeder_sketch", "sweep_map"]
    evidence = [n for n in NAMES if n.startswith("evidence_")]
    assert workshop.chosen(asked, NAMES) == ["sweep_map", *evidence, "feeder_sketch"]


def test_figures_that_measure_are_drawn_where_they_are_asked_for(tmp_path, monkeypatch, typed):
    """By name or with --measure, not among all."""
    monkeypatch.setattr(
        gallery, "all_drawn", lambda options, names, *_: print(*names, sep="\n") or []
    )
    measured = [n for n in NAMES if workshop.about(n)[1]["Group"] == workshop.TIMED]
    assert {"evidence_stress", "evidence_work_precision", "wear_jumps"} <= set(measured)
    rest = [n for n in NAMES if n not in measured]
    for words, names in (
        ("", rest),
        ("--measure", NAMES),
        ("wear_jumps frames", ["wear_jumps", "frames"]),
    ):
        assert typed("figures", words, "-o", tmp_path).out.splitlines()[:-1] == names


def test_a_script_without_a_group_is_refused(tmp_path, monkeypatch):
    """A script without a group, or of an unknown one, is refused."""
    text = (
        '"""A figure.\n\n'
        + "\n\n".join(f"{p}: text" for p in workshop.PARTS if p != "Group")
        + '\n"""\n'
    )
    (tmp_path / "new.py").write_text(text)
    monkeypatch.setattr(workshop, "FOLDER", tmp_path)
    with pytest.raises(ValueError, match="no paragraph 'Group"):
        workshop.names()
    (tmp_path / "new.py").write_text(text.replace("Answers", "Group: bearings\n\nAnswers"))
    with pytest.raises(ValueError, match="no group 'bearings'"):
        workshop.names()


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_the_page_has_groups_and_small_pictures_that_lead_to_the_figures(tmp_path):
    """Small pictures lead to the figures, by groups."""
    drawn(tmp_path, "friction_laws", "feeder_sketch", "--quick", "--workers", "1")
    text = (tmp_path / "index.html").read_text()
    titles = re.findall("<h2>(.*?)</h2>", text)
    assert titles == [workshop.GROUPS["feeder"], workshop.GROUPS["joints"]]
    links = re.findall(
        r'<a href="#(\w+)" title="[^"]+"><img src="data:image/png;base64,[^"]+" alt=""', text
    )
    assert links == ["feeder_sketch", "friction_laws"]
    assert all(f'<article id="{name}">' in text for name in links)
    (tmp_path / "feeder_sketch.png").unlink()  # a picture that was taken away
    gallery.page(tmp_path)


@pytest.mark.usefixtures("undrawn")
def test_a_log_has_a_line_at_the_start_of_each_figure(tmp_path, typed):
    """Progress has a line a figure."""
    printed = typed("figures feeder_sketch -o", tmp_path)
    assert "feeder_sketch, 1 of 1" in printed.err
    assert "feeder_sketch" in printed.out


def test_warnings_name_figure_and_run(tmp_path, caplog):
    """Of a run with a force hole; afterwards warnings are as they were."""
    work, log = workshop.Workshop(tmp_path, "feeder_transition"), logging.getLogger("clearance")
    options = {"model": "mixed", "contact": "hertz", "film": "pinkus_sternlicht"}
    with caplog.at_level(logging.WARNING):
        work.run("six_bar_feeder", options, turns=0.01)
        log.warning("later")
    first, *_, last = [r.getMessage() for r in caplog.records]
    run = "six_bar_feeder with model=mixed, contact=hertz, film=pinkus_sternlicht"
    assert first.startswith(f"feeder_transition: {run}: joint B: force hole")
    assert last == "later"


def a_figure(folder, name, *_):
    """In place of `gallery.drawn`: "quick" is done when "slow" has begun, which has a child and
    never ends.
    """
    (folder / name).touch()
    if name == "slow":
        child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(300)"])
        (folder / "child").write_text(str(child.pid))
        (folder / "begun").touch()
        child.wait()
    while not (folder / "begun").exists():
        time.sleep(0.02)
    return name


def is_running(pid: str) -> bool:
    """Zombies, which wait for whoever inherits them, do not run."""
    actual = subprocess.run(["ps", "-o", "stat=", "-p", pid], capture_output=True, text=True).stdout
    return bool(actual) and not actual.startswith("Z")


@pytest.mark.slow
def test_an_interrupt_ends_all_that_draws_and_what_was_done_is_noted(tmp_path, monkeypatch):
    """Processes and their children are gone, and a figure that waited is not begun."""
    monkeypatch.setattr(gallery, "drawn", a_figure)
    options, noted = argparse.Namespace(quick=False, fresh=False, results=None, workers=2), []

    def done(name):
        noted.append(name)
        signal.raise_signal(signal.SIGINT)
        pytest.fail("an interrupt was lost")

    def line(text, always):
        return None

    with pytest.raises(KeyboardInterrupt):
        gallery._side_by_side(options, ["slow", "quick", "waiting"], tmp_path, line, done)
    assert noted == ["quick"]
    assert not (tmp_path / "waiting").exists()
    child = (tmp_path / "child").read_text()
    for _ in range(2400):  # the signal is delivered, not yet acted on
        if not is_running(child):
            break
        time.sleep(0.05)
    assert not is_running(child)


def test_each_folder_has_its_place_in_the_street():
    """All folders and modules of the package, with a sentence each."""
    top = Path(cl.__file__).parent
    inside = {p.name for p in top.iterdir() if (p / "__init__.py").exists()}
    inside |= {p.stem for p in top.glob("*.py")} - {"__init__"}
    names = [name for stretch in structure.STREET.values() for name in stretch]
    assert sorted(names) == sorted(inside | set(workshop.BESIDE))
    assert all(len(structure.sentence(structure.files(name)[0])) > 20 for name in names)


def test_no_arrow_of_the_structure_leads_back():
    """Each folder imports earlier ones; folders of the last stretch each other."""
    counts = structure.counted()
    assert sum(counts.values()) > 300
    *way, last = structure.STREET.values()
    order = [name for stretch in way for name in stretch]
    assert [(a, b) for a, b in counts if a in last and b not in last] == []
    inner = [(a, b) for a, b in counts if a in order and b in order]
    assert [edge for edge in inner if order.index(edge[0]) > order.index(edge[1])] == []


def test_the_structure_shows_a_number_for_each_pair_of_stretches():
    """All imports between stretches are in the picture, none within one."""
    counts = structure.counted()
    stretch = {name: names for names in structure.STREET.values() for name in names}
    wanted = sum(n for (a, b), n in counts.items() if stretch[a] is not stretch[b])
    texts = [t.get_text() for t in structure.picture(counts).axes[0].texts]
    assert sum(int(t) for t in texts if t.isdigit()) == wanted
