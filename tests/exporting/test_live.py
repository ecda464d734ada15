"""The page that computes: numbers of its module, without a browser."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from clearance.exporting import unit
from tests.postprocess.test_view import BROWSER, FLAGS

HERE = Path(__file__).parent
NODE = shutil.which("node")


CHANGES = {"joints/B/clearance": 1.5e-4}


@pytest.fixture(scope="module")
def page_of(tmp_path_factory):
    """Pages of the feeder by its model, each made once."""
    folder = tmp_path_factory.mktemp("pages")

    def page(model):
        path = folder / f"{model}.html"
        if not path.exists():
            assert (
                main(["export", "six_bar_feeder", "-p", f"model={model}", "--page", str(path)]) == 0
            )
        return path

    return page


@pytest.mark.slow
@pytest.mark.skipif(NODE is None, reason="no node")
@pytest.mark.skipif(not unit.has_zig(), reason="no ziglang")
@pytest.mark.parametrize(
    ("model", "changes"),
    [("mixed", {}), ("mixed", CHANGES), ("lubricated", CHANGES | {"drives/crank/speed": 40.0})],
)
def test_numbers_of_the_page(page_of, model, changes):
    """Eccentricities within 1e-9 of the clearance of a run at 1e-10, also behind moved sliders.

    The page has at most 1.5 MB, makes no request, and runs no script but its own.
    """
    path = page_of(model)
    assert path.stat().st_size < 1.5e6
    assert "default-src 'none'; script-src 'wasm-unsafe-eval' 'sha256-" in path.read_text()
    command = [NODE, HERE / "live_in_node.mjs", path, json.dumps(changes)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    answer = json.loads(done.stdout)
    scene = cl.load_case("six_bar_feeder", model=model).replaced(changes)
    run = cl.simulate(scene, turns=2, rtol=1e-10, samples=401)
    clearance = changes.get("joints/B/clearance", 1e-4)
    np.testing.assert_allclose(answer["time"], run.time, rtol=1e-12)
    off = np.abs(answer["x"] - run.joint("B").eccentricity[:, 0])
    assert off.max() < 1e-9 * clearance
    assert answer["path"] == answer["x"]
    assert answer["clearance"] == clearance
    size = np.hypot(*run.joint("B").force.T)
    np.testing.assert_allclose(answer["size"], size, rtol=1e-5)
    assert answer["turn"] == pytest.approx(scene.turn)


@pytest.mark.slow
@pytest.mark.skipif(not unit.has_zig(), reason="no ziglang")
def test_sliders_move_the_picture(page_of):
    """In a browser: a slider changes mechanism and clock, without a request or an error."""
    api = pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
    if not BROWSER:
        pytest.skip("no chromium: apt-get install chromium, or set CHROMIUM")
    asked, errors = [], []
    with api.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=BROWSER, args=FLAGS)
        page = browser.new_page()
        page.on("request", lambda r: asked.append(r.url))
        page.on("pageerror", lambda e: errors.append(str(e)))
        page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        page.goto(page_of("mixed").as_uri())
        page.evaluate("page.started")
        page.evaluate("page.go(0.11)")
        drawn = "document.querySelector('#machine').toDataURL()"
        before = page.evaluate(drawn)
        slider = "document.querySelector('#sliders input[data-name=\"joints/B/clearance\"]')"
        page.evaluate(f"{slider}.value = 300; {slider}.dispatchEvent(new Event('input'))")
        page.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))")
        page.evaluate("page.go(0.11)")
        assert page.evaluate(drawn) != before
        there = page.evaluate("page.runs[0].lenses[0].clearance")
        assert there == pytest.approx(1e-4 * 3**0.75)
        browser.close()
    assert errors == []
    assert all(url.startswith("file:") for url in asked)


@pytest.mark.skipif(not unit.has_zig(), reason="no ziglang")
def test_the_page_in_python(tmp_path):
    """One call writes it, beside C source; without anything to write the call is refused."""
    scene = cl.load_case("slider_crank", model="lubricated")
    exported = cl.export(scene, page=tmp_path / "p.html", c=tmp_path / "c")
    assert exported.page == tmp_path / "p.html"
    assert "WebAssembly" in exported.page.read_text()
    with pytest.raises(ValueError, match="or page=FILE.html"):
        cl.export(scene)
