"""The page that moves: its numbers, its policy, and its behaviour in a browser."""

import itertools
import json
import os
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from clearance.postprocess import moving, view_map
from clearance.postprocess.moving import Moving
from clearance.postprocess.packing import Pack, unpacked
from clearance.postprocess.view import document, view

import clearance as cl
from clearance.sweeping.index import open_sweep
from tests.typed import run as command

BROWSER = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
#: a container has no user namespaces for the sandbox of chromium; the pages are ours
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A dry and a lubricated run with pressure fields, a grid with run files, samples without."""
    folder = tmp_path_factory.mktemp("views")
    options = {"turns": 2.0, "samples_per_turn": 60}
    dry = cl.load_case("slider_crank", model="dry", clearance=5e-4)
    cl.simulate(dry, path=folder / "dry.h5", **options)
    oil = cl.load_case("slider_crank", model="lubricated", clearance=5e-4)
    cl.simulate(oil, path=folder / "oil.h5", pressure_fields=4, **options)
    points = cl.grid(speed=[50.0, 100.0, 150.0], clearance=[2e-4, 5e-4])
    cl.sweep("slider_crank", points, folder / "grid", fixed={"model": "dry"}, workers=1, **options)
    drawn = cl.sampled(4, speed=(50.0, 100.0))
    cl.sweep("slider_crank", drawn, folder / "samples", channels=[], workers=1, turns=1.0)
    return folder


def facts_of(path):
    """Facts of a page and its blocks of numbers."""
    text = path.read_text()
    blocks = re.findall(r'<script type="text/plain" id="block\d+">([^<]*)</script>', text)
    return json.loads(re.search(r'id="facts">(.*?)</script>', text)[1]), blocks


# --- numbers
@pytest.mark.parametrize(
    ("kind", "values"), [("f4", [0.5, -3e-9, np.nan, 1e30]), ("f8", [np.pi]), ("u1", [0, 255])]
)
def test_columns_come_back(kind, values):
    """Packed numbers are unpacked as they were, in their precision."""
    pack = Pack()
    pack.add(np.arange(5.0), "f8")
    block = pack.add(np.array(values), kind)
    actual = unpacked(pack.text(), block)
    np.testing.assert_array_equal(actual, np.array(values).astype(actual.dtype))
    assert pack.size == 40 + actual.nbytes


def test_an_unknown_kind_of_column_is_refused():
    """The message lists the kinds."""
    with pytest.raises(ValueError, match="kind must be one of f4, f8, u1, got 'i8'"):
        Pack().add(np.zeros(3), "i8")


def test_a_page_has_all_channels_of_its_runs(folder, tmp_path):
    """As 32-bit floats over times in 64 bits, with sizes of forces and eccentricities."""
    page = view([folder / "dry.h5", folder / "oil.h5"], tmp_path / "both.html")
    facts, blocks = facts_of(page)
    assert len(blocks) == len(facts["runs"]) == 2
    for name, run, block in zip(("dry", "oil"), facts["runs"], blocks, strict=True):
        record = cl.open_result(folder / f"{name}.h5")
        np.testing.assert_array_equal(unpacked(block, run["time"]), record.time)
        kinds = ("bodies", "joints", "drives")
        groups = ["energy", *(f"{kind}/{owner}" for kind in kinds for owner in record.names(kind))]
        paths = {f"{group}/{channel}" for group in groups for channel in record.names(group)}
        assert paths <= set(run["columns"]) <= set(facts["channels"])
        for path in paths:
            np.testing.assert_array_equal(
                unpacked(block, run["columns"][path][0]), record.values(path).astype("f4")
            )
        force = unpacked(block, run["columns"]["joints/C/force"][0])
        np.testing.assert_allclose(force, np.hypot(*record.joint("C").force.T), rtol=1e-6)
        contacts = unpacked(block, run["contacts"]["time"])
        np.testing.assert_array_equal(contacts, np.sort(record.events["time"]))
    assert facts["channels"]["joints/C/gap"]["unit"] in ("mm", "µm")


def test_units_suit_all_runs(folder, tmp_path):
    """A factor leads from SI to the unit that is shown."""
    facts, _ = facts_of(view(folder / "dry.h5", tmp_path / "p.html"))
    assert {"N": 1.0, "kN": 1e-3}[facts["channels"]["joints/C/force"]["unit"]] == facts["channels"][
        "joints/C/force"
    ]["factor"]


def test_pressure_fields_keep_their_peaks(folder):
    """In 255 steps of the largest pressure of each instant."""
    record = cl.open_result(folder / "oil.h5")
    run, fields = Moving(record, "oil"), record.pressure_fields("C")
    (lens,) = run.facts["lenses"]
    text = run.pack.text()
    tops, steps = (unpacked(text, lens["fields"][name]) for name in ("top", "steps"))
    shown = tops[:, None, None] * steps.reshape(len(tops), *lens["fields"]["shape"]) / 255.0
    np.testing.assert_allclose(
        shown, np.maximum(fields.pressure, 0.0), atol=0.51 / 255.0 * tops.max()
    )
    np.testing.assert_array_equal(unpacked(text, lens["fields"]["time"]), fields.time)


def test_thinning_keeps_every_extreme(folder, monkeypatch):
    """Of each stretch the smallest and the largest value; of many contacts the strongest."""
    monkeypatch.setattr(moving, "NUMBERS", 30)
    monkeypatch.setattr(moving, "CONTACTS", 3)
    record = cl.open_result(folder / "dry.h5")
    run = Moving(record, "dry")
    text, starts = run.pack.text(), run.thinning.starts
    assert len(starts) <= 30 // moving.THINNED < len(record.time)
    for path in ("bodies/slider/ax", "joints/C/gap"):
        at, low, high = (unpacked(text, block) for block in run.facts["columns"][path])
        values = record.values(path).astype("f4")
        np.testing.assert_array_equal(at, values[starts])
        parts = np.split(values, starts[1:])
        np.testing.assert_array_equal(low, [part.min() for part in parts])
        np.testing.assert_array_equal(high, [part.max() for part in parts])
    forces = unpacked(text, run.facts["contacts"]["force"])
    assert sorted(forces) == sorted(np.sort(record.events["peak_force"]).astype("f4")[-3:])
    assert run.facts["contacts"]["left_out"] == len(record.events["time"]) - 3


# --- the page
def test_a_page_asks_nothing_of_a_network(folder, tmp_path):
    """Its policy forbids every request; a name can neither end an element nor begin one."""
    page = view(folder / "dry.h5", tmp_path / "p.html", labels="</script><b>&")
    text = page.read_text()
    assert "default-src 'none'; script-src 'sha256-" in text
    assert not re.search(r"https?:|//cdn|\bsrc=|\bhref=|@import|url\(", text)
    assert "</script><b>" not in text
    assert facts_of(page)[0]["runs"][0]["label"] == "</script><b>&"
    assert "<title>&lt;x&gt; @FACTS@</title>" in document({"title": "<x> @FACTS@"}, [])


def test_a_run_without_poses_shows_curves_and_the_reason(folder, tmp_path):
    """Stored channels are shown; the machine names the missing ones."""
    scene = cl.load_case("slider_crank", model="dry", clearance=5e-4)
    few = cl.simulate(scene, turns=0.2, samples_per_turn=60, channels=["bodies/slider/ax"])
    (run,) = facts_of(cl.view(few, tmp_path / "few.html"))[0]["runs"]
    assert "bodies/crank/x" in run["machine"]["missing"]
    assert list(run["columns"]) == ["bodies/slider/ax"]
    assert run["lenses"] == []


def bench(record, path):
    """Every fifth sample of an acceleration from a fifth of the run on, as a record over time."""
    rows = np.arange(len(record.time) // 5, len(record.time), 5)
    times, values = record.time[rows], record["slider"].ax[rows]
    lines = [f"{1e3 * (t - times[0]):.17g},{a:.17g}" for t, a in zip(times, values, strict=True)]
    path.write_text("\n".join(["time [ms],ax [m/s2]", *lines]))
    return path, rows


def test_measured_data_lie_over_their_channel(folder, tmp_path):
    """Data taken from the run lie on its curve (32-bit floats), where it begins (1e-9 s)."""
    record = cl.open_result(folder / "oil.h5")
    data, rows = bench(record, tmp_path / "bench.csv")
    compared = cl.compare(record, data, "slider.ax", shift=record.time[rows[0]])
    facts, blocks = facts_of(view(record, tmp_path / "p.html", measured=compared))
    (laid,) = facts["runs"][0]["measured"]
    assert (laid["path"], facts["first"][0]) == ("bodies/slider/ax", "bodies/slider/ax")
    np.testing.assert_allclose(unpacked(blocks[0], laid["time"]), record.time[rows], atol=1e-9)
    np.testing.assert_array_equal(
        unpacked(blocks[0], laid["values"]), record["slider"].ax[rows].astype("f4")
    )
    assert "rms error" in facts["runs"][0]["about"][-1]
    with pytest.raises(ValueError, match="measured data are for runs"):
        view(folder / "grid", tmp_path / "map.html", measured=compared)


def test_worn_outlines_go_with_their_joint(tmp_path):
    """Depths of both surfaces as 32-bit floats, of which the browser makes the edge of the room."""
    scene = cl.load_case("slider_crank", model="dry", contact="winkler", clearance=1e-4)
    depths = {"bearing": 3e-5 * np.exp(-(((np.arange(360.0) - 200.0) / 20.0) ** 2))}
    depths["journal"] = np.roll(depths["bearing"], 110) / 3.0
    joints = {j.name: j for j in scene.joints}
    joints["C"] = replace(joints["C"], outline=cl.worn(**depths))
    run = cl.simulate(cl.Scene(*joints.values(), *scene.loads), turns=0.1)
    facts, blocks = facts_of(cl.view(run, tmp_path / "worn.html"))
    (lens,) = facts["runs"][0]["lenses"]
    for block, values in zip(lens["worn"], depths.values(), strict=True):
        np.testing.assert_array_equal(unpacked(blocks[0], block), values.astype("f4"))
    (fresh,) = facts_of(cl.view(cl.simulate(scene, turns=0.1), tmp_path / "new.html"))[0]["runs"]
    assert "worn" not in fresh["lenses"][0]


def test_a_run_that_sums_wear_has_a_page(tmp_path):
    """Sums of wear stand beside the channels of their joint and are none."""
    scene = cl.load_case("slider_crank", model="dry", contact="winkler", wear=1e-16)
    run = cl.simulate(scene, turns=0.1)
    assert run.facts("joints/C/wear")
    (moving_run,) = facts_of(cl.view(run, tmp_path / "worn.html"))[0]["runs"]
    assert "joints/C/wear_volume_bearing" in moving_run["columns"]
    assert "joints/C/wear" not in moving_run["columns"]


def test_curves_have_their_stated_errors(folder, tmp_path):
    """As the file has them; a dry run states none."""
    facts, _ = facts_of(view([folder / "dry.h5", folder / "oil.h5"], tmp_path / "both.html"))
    dry, oil = facts["runs"]
    assert dry["errors"] == {}
    shares = cl.open_result(folder / "oil.h5").errors.channels
    assert oil["errors"]["bodies/slider/ax"] == shares["bodies/slider/ax"] > 0.0


@pytest.mark.parametrize("name", ["grid", "samples"])
def test_the_page_of_a_sweep_has_its_points(name, folder, tmp_path):
    """Metrics in a unit that suits them, and a block for each run that has a file."""
    sweep = open_sweep(folder / name)
    facts, blocks = facts_of(view(sweep, tmp_path / "map.html"))
    points = facts["map"]
    metric = next(m for m in points["metrics"] if m["name"] == "drive_crank_torque_rms")
    np.testing.assert_allclose(metric["values"], sweep.metrics["drive_crank_torque_rms"], rtol=1e-5)
    assert points["status"] == ["done"] * len(sweep)
    if name == "samples":
        assert (blocks, points["x"], points["drawn"]) == ([], "speed", True)
        assert "keeps no files" in points["note"]
        return
    assert (points["x"], points["y"]) == ("speed", "clearance")
    assert sorted(points["blocks"]) == list(range(6))
    parameter = next(p for p in points["parameters"] if p["name"] == "clearance")
    assert parameter["label"] == "clearance [mm]"
    np.testing.assert_allclose(
        np.array(parameter["values"])[parameter["place"]], 1e3 * sweep.columns["clearance"]
    )
    point = points["blocks"].index(4)
    record = sweep.run(point)
    run = facts["runs"][4]
    time = unpacked(blocks[4], run["time"])
    np.testing.assert_array_equal(time, record.time[-len(time) :])


def test_a_sweep_with_many_runs_keeps_what_there_is_room_for(folder, monkeypatch):
    """Spread over the points, the first one among them; the page states so."""
    monkeypatch.setattr(view_map, "ROOM", 60_000)
    facts, blocks = view_map.of_sweep(open_sweep(folder / "grid"))
    having = [i for i, block in enumerate(facts["map"]["blocks"]) if block is not None]
    assert 0 in having
    assert 1 < len(having) == len(blocks) < 6
    assert f"{len(having)} of 6 runs are in this page" in facts["map"]["note"]
    assert view_map._spread([*range(6)]) == [0, 4, 2, 1, 3, 5]


def test_the_command_takes_measured_data(folder, tmp_path, capsys):
    """Names that only go with data are refused without them."""
    data, _ = bench(cl.open_result(folder / "oil.h5"), tmp_path / "bench.csv")
    page = tmp_path / "page.html"
    options = ["--measured", data, "--channels", "slider.ax", "--shift", "5 ms", "-o", page]
    assert command("view", folder / "oil.h5", *options, capsys=capsys)[0] == 0
    (laid,) = facts_of(page)[0]["runs"][0]["measured"]
    assert laid["label"] == "bench.csv, ax"
    status, _, err = command("view", folder / "oil.h5", "--column", "ax", capsys=capsys)
    assert status == 2
    assert "--column needs --measured" in err


def test_the_command_writes_a_page(folder, tmp_path, capsys):
    """Beside the file by itself, with the curves requested first."""
    shutil.copy(folder / "dry.h5", tmp_path / "dry.h5")
    status, text, err = command(
        "view", tmp_path / "dry.h5", "--channels", "slider.ay,C.epsilon", "--json", capsys=capsys
    )
    assert (status, err) == (0, "")
    path = tmp_path / "dry.view.html"
    assert json.loads(text) == {
        "status": "complete",
        "page": str(path),
        "bytes": path.stat().st_size,
    }
    assert facts_of(path)[0]["first"] == ["bodies/slider/ay", "joints/C/epsilon"]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        (["nowhere.h5"], "no file or directory nowhere.h5"),
        (["dry.h5", "-o", "page.txt"], "its name must end in .html"),
        (["dry.h5", "--channels", "slider.nothing"], "dry.h5 has no channel 'slider.nothing'"),
        (["dry.h5", "grid"], "a sweep has a page by itself"),
        (["grid", "--settle", "1"], "settle, labels and measured data are for runs"),
        (["dry.h5"] * 7, "7 runs, a page lays at most 6 over each other"),
    ],
)
def test_wrong_input_is_one_line(inputs, message, folder, monkeypatch, capsys):
    """Exit status 2 and one line with the reason."""
    monkeypatch.chdir(folder)
    status, _, err = command("view", *inputs, capsys=capsys)
    assert status == 2
    assert message in err
    assert err.count("\n") == 1


# --- in a browser
@pytest.fixture(scope="module")
def browser():
    """A headless chromium: pip install playwright, apt-get install chromium or set CHROMIUM."""
    api = pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
    if not BROWSER:
        pytest.skip("no chromium: apt-get install chromium, or set CHROMIUM")
    with api.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=BROWSER, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def shown(browser, folder, tmp_path_factory):
    """Opens a page and returns it when it is drawn; it loads its file only, without errors."""
    asked, errors = [], []

    def opened(*sources, **options):
        output = tmp_path_factory.mktemp("page") / "page.html"
        path = view([folder / s for s in sources], output, **options)
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.on("request", lambda r: asked.append(r.url))
        page.on("pageerror", lambda e: errors.append(str(e)))
        page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        page.goto(path.as_uri())
        page.evaluate("page.started")
        return page

    yield opened
    assert all(url.startswith("file:") for url in asked)
    assert errors == []


@pytest.fixture(scope="module")
def runs(shown):
    return shown("dry.h5", "oil.h5")


def picture(page, selector="#machine"):
    return page.evaluate(f"document.querySelector('{selector}').toDataURL()")


def test_the_browser_reads_the_numbers_of_the_file(runs, folder):
    """Values at the cursor are interpolated between the samples as numpy does (32-bit floats)."""
    record = cl.open_result(folder / "oil.h5")
    for share in (0.0, 0.317, 1.0):
        time = share * record.time[-1]
        actual = runs.evaluate(
            f"at(page.runs[1].channel('joints/C/gap').at, page.runs[1].place({time}, 'time'))"
        )
        assert actual == pytest.approx(
            np.interp(time, record.time, record.joint("C").gap), rel=1e-6
        )


def test_the_browser_draws_measured_data(shown, folder, tmp_path):
    """In their colour, over the curve."""
    data, rows = bench(cl.open_result(folder / "oil.h5"), tmp_path / "bench.csv")
    compared = cl.compare(cl.open_result(folder / "oil.h5"), data, "slider.ax")
    page = shown("oil.h5", measured=compared)
    laid = page.evaluate("page.charts.get('bodies/slider/ax').laid(page.runs[0])[0].time")
    assert len(laid) == len(rows)
    painted = """(() => {
        const c = page.charts.get('bodies/slider/ax').canvas;
        const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
        let n = 0;
        for (let i = 0; i < p.length; i += 4)
          n += p[i] === 224 && p[i + 1] === 168 && p[i + 2] === 0;
        return n })()"""
    assert page.evaluate(painted) > len(rows) / 4  # those of the turns that are shown


def test_it_opens_on_the_settled_turns(runs, folder):
    """The first turn is left out."""
    turn = cl.open_result(folder / "dry.h5").turn
    assert runs.evaluate("page.window") == pytest.approx([turn, 2.0 * turn])


def test_the_cursor_moves_everything(runs):
    """Mechanism, cursors of all curves, pressure field, clock."""
    runs.evaluate("page.go(page.window[0])")
    before = picture(runs), picture(runs, ".field canvas"), runs.locator("#clock").text_content()
    runs.evaluate("page.go(0.3 * page.window[0] + 0.7 * page.window[1])")
    after = picture(runs), picture(runs, ".field canvas"), runs.locator("#clock").text_content()
    assert all(a != b for a, b in zip(before, after, strict=True))
    places = runs.evaluate("[...page.charts.values()].map(c => c.now.style.transform)")
    assert len(places) >= 3
    assert len(set(places)) == 1


def test_it_plays_and_takes_keys(runs):
    """The space bar plays and stops; arrows go from sample to sample."""
    runs.evaluate("page.go(page.window[0])")
    runs.keyboard.press("Space")
    runs.wait_for_timeout(200)
    runs.keyboard.press("Space")
    assert runs.evaluate("page.x > page.window[0] && !page.playing")
    sample = runs.evaluate("page.runs[0].place(page.x, page.kind)[0]")
    runs.keyboard.press("ArrowRight")
    assert runs.evaluate("page.runs[0].place(page.x, page.kind)") == [sample + 1, 0]


def test_users25_the_key_of_help(runs):
    """? opens the list of keys, as the guide states it."""
    runs.keyboard.press("?")
    assert runs.evaluate("document.getElementById('keys').open")
    runs.keyboard.press("Escape")


def test_users25_a_telephone(shown):
    """At 390 pixels nothing lies beside the screen: mechanism and curves are as wide as it."""
    page = shown("dry.h5", "oil.h5")
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_timeout(100)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for selector in ("#machine", "#help", ".chart canvas"):
        box = page.locator(selector).first.bounding_box()
        assert box["x"] >= 0.0
        assert box["x"] + box["width"] <= 390.0
    assert page.locator("#machine").bounding_box()["width"] > 380.0


def test_users25_a_sweep_without_run_files_is_its_map(shown):
    """No half of the page is empty: the map is as wide as the page, and nothing plays."""
    page = shown("samples")
    assert page.locator("#map canvas").bounding_box()["width"] > 1300.0
    assert not page.locator("#right").is_visible()
    assert not page.locator("footer").is_visible()


def test_users25_lines_to_lenses_do_not_cross(shown, folder):
    """At the start of the feeder with three joints, named in another order than they lie."""
    scene = cl.load_case("six_bar_feeder", model="dry", joints="E,C,B")
    cl.simulate(scene, turns=1.0, samples_per_turn=60, path=folder / "three.h5", error=None)
    page = shown("three.h5")
    page.evaluate("page.go(page.window[0])")
    ends = page.evaluate(
        """(() => {
          const lines = [], draw = Machine.prototype.leader;
          Machine.prototype.leader = function (g, a, b) { lines.push([...a, ...b]); };
          page.machine.draw();
          Machine.prototype.leader = draw;
          return lines;
        })()"""
    )
    assert len(ends) == 3
    for (ax, ay, bx, by), (cx, cy, dx, dy) in itertools.combinations(ends, 2):
        sides = [
            np.sign((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))
            for p, q, r in (
                ((ax, ay), (bx, by), (cx, cy)),
                ((ax, ay), (bx, by), (dx, dy)),
                ((cx, cy), (dx, dy), (ax, ay)),
                ((cx, cy), (dx, dy), (bx, by)),
            )
        ]
        assert sides[0] == sides[1] or sides[2] == sides[3]


def test_a_drag_zooms_all_curves_and_a_click_sets_the_time(runs):
    """Both follow the pointer, to a hundredth of the window."""
    box = runs.locator("#curves canvas").first.bounding_box()
    at = [box["x"] + 58 + share * (box["width"] - 72) for share in (0.25, 0.75)]
    before = runs.evaluate("page.window")
    runs.mouse.move(at[0], box["y"] + 60)
    runs.mouse.down()
    runs.mouse.move(at[1], box["y"] + 60, steps=4)
    runs.mouse.up()
    low, high = runs.evaluate("page.window")
    length = before[1] - before[0]
    assert [low, high] == pytest.approx(
        [before[0] + 0.25 * length, before[0] + 0.75 * length], abs=0.01 * length
    )
    runs.mouse.click(at[0], box["y"] + 60)
    assert runs.evaluate("page.x") == pytest.approx(low + 0.25 * (high - low), abs=0.01 * length)
    runs.mouse.dblclick(at[0], box["y"] + 60)
    assert runs.evaluate("page.window") == pytest.approx(runs.evaluate("page.whole"))


def test_curves_come_and_go(runs):
    """A ticked channel has a curve, and its cross takes it away."""
    count = runs.locator("#curves .chart").count()
    runs.evaluate("document.getElementById('more').open = true")
    runs.fill("#filter", "joint C gap")
    box = runs.locator("#choice label:visible input[data-path='joints/C/gap']")
    box.check()
    assert runs.locator("#curves .chart").count() == count + 1
    runs.locator("#curves .chart .close").last.click()
    assert runs.locator("#curves .chart").count() == count
    assert runs.locator("#choice input:checked").count() == count


def test_points_of_a_map_open_their_runs(shown):
    """A click on a cell opens its run, with shift it is laid over."""
    page = shown("grid")
    spot = page.evaluate(
        "(() => { const s = page.map.spots.find(s => s.i === 5); return [s.x, s.y] })()"
    )
    page.locator("#map canvas").click(position={"x": spot[0], "y": spot[1]})
    page.wait_for_timeout(100)
    assert page.evaluate("page.points") == [5]
    spot = page.evaluate(
        "(() => { const s = page.map.spots.find(s => s.i === 0); return [s.x, s.y] })()"
    )
    page.locator("#map canvas").click(position={"x": spot[0], "y": spot[1]}, modifiers=["Shift"])
    page.wait_for_timeout(100)
    assert page.evaluate("page.points") == [5, 0]
    assert page.evaluate("page.kind") == "turns"  # of runs with different speeds
    assert page.locator("#runs label").count() == 2
