"""Folders and files of strangers: opening, drawing and describing them runs nothing of theirs."""

import base64
import hashlib
import html.parser
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

import clearance as cl
from clearance.cli import main
from clearance.commands import common
from clearance.files import sealed
from clearance.files.texts import LONG, shortened
from clearance.machine import store
from tests.seeds import few_of

EVIL = """
from pathlib import Path
import clearance as cl
Path({mark!r}).write_text("ran")

@cl.contact
def liner(penetration, penetration_rate, impact_speed, stiffness):
    return stiffness * penetration if penetration > 0.0 else 0.0
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.h5"
    cl.simulate(cl.load_case("slider_crank"), turns=1.0, path=path).close()
    return path


def as_user(folder, *arguments, **environment):
    """A command in a folder, in a process of its own."""
    words = [sys.executable, "-c", "from clearance.cli import entry; entry()", *map(str, arguments)]
    return subprocess.run(
        words,
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | environment,
        check=False,
    )


def test_S3_new_runs_no_law_of_a_file(tmp_path):
    """A result with a law of its own is refused before its text is run."""
    mark = tmp_path / "ran"
    (tmp_path / "evil_law.py").write_text(EVIL.format(mark=str(mark)))
    (tmp_path / "evil.py").write_text(
        f"import sys\nsys.path.insert(0, {str(tmp_path)!r})\nimport clearance as cl\n"
        "from evil_law import liner\n"
        "def scene():\n"
        "    a = cl.Body('a', 1.0, 1e-3)\n"
        "    joint = cl.ClearanceRevolute(cl.ground, a, name='J', radius=0.01, clearance=1e-4,\n"
        "        length=0.01, contact=liner(stiffness=1e8))\n"
        "    return cl.Scene(joint)\n"
    )
    process = as_user(tmp_path, "run", "evil.py", "--until", "1e-4", "-o", "run.h5")
    assert process.returncode == 0, process.stderr
    mark.unlink()
    (tmp_path / "evil_law.py").unlink()
    done = as_user(tmp_path, "new", "run.h5", "-o", "new.toml")
    assert done.returncode == 2
    assert "laws of evil_law.py in a result are not run by new" in done.stderr
    assert not mark.exists()
    assert not (tmp_path / "new.toml").exists()


SETTINGS = (
    "text.usetex: True",
    "animation.ffmpeg_path: {evil}",
    "animation.writer: {evil}",
    "axes.formatter.use_mathtext: True\nfont.size: 60",
    "figure.figsize: 1, 1\nsavefig.format: nonsense",
)


DRAWING = """
import sys
from clearance.cli import main
assert main(["plot", sys.argv[1], "orbit", "-o", "p.png"]) == 0
assert main(["report", sys.argv[1], "-o", "r.html"]) == 0
"""


def drawn(run, folder):
    """The picture of a run as the settings of a folder have it; its report is made, too."""
    words = [sys.executable, "-c", DRAWING, str(run)]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return (folder / "p.png").read_bytes()


@pytest.fixture(scope="module")
def plain_picture(run, tmp_path_factory):
    return drawn(run, tmp_path_factory.mktemp("empty"))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_S4_pictures_take_no_settings_of_the_folder(run, plain_picture, seed, tmp_path):
    """All settings together and some at random: the picture is that of an empty folder."""
    rng, evil = random.Random(seed), tmp_path / "evil.sh"
    evil.write_text(f"#!/bin/sh\ntouch {tmp_path}/ran\n")
    evil.chmod(0o755)
    chosen = SETTINGS if seed == 0 else rng.sample(SETTINGS, rng.randint(1, 3))
    (tmp_path / "matplotlibrc").write_text("\n".join(chosen).format(evil=evil) + "\n")
    assert drawn(run, tmp_path) == plain_picture
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("seed", few_of(range(3), 1))
def test_S4_films_are_written_by_the_program_of_the_path(run, seed, tmp_path):
    """Not by one that a file of the working folder names. One that fails, having taken any part of
    the film, is named in a line.
    """
    rng, programs = random.Random(seed), tmp_path / "bin"
    taken, status = rng.choice([0, 99, rng.randrange(10**6), 10**9]), rng.randrange(1, 126)
    programs.mkdir()
    for name, folder in (("ffmpeg", programs), ("evil.sh", tmp_path)):
        lines = "#!/bin/sh", f"touch {tmp_path}/{name}.ran", f"head -c {taken} >/dev/null"
        ends = "echo no codec >&2", f"exit {status}"
        (folder / name).write_text("\n".join([*lines, *ends, ""]))
        (folder / name).chmod(0o755)
    (tmp_path / "matplotlibrc").write_text(f"animation.ffmpeg_path: {tmp_path}/evil.sh\n")
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    words = "plot", run, "animation", "--frames", "2", "-o", "a.mp4"
    done = as_user(tmp_path, *words, PATH=path)
    assert done.returncode == 1
    lines = [x for x in done.stderr.splitlines() if x.startswith("clearance:")]
    assert lines == [f"clearance: ffmpeg ended with status {status}: no codec"]
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "a.mp4").exists()
    assert (tmp_path / "ffmpeg.ran").exists()
    assert not (tmp_path / "evil.sh.ran").exists()


def test_S4_texts_of_files_are_not_latex(run, tmp_path):
    """Not even where the user's program has set that."""
    import matplotlib

    with matplotlib.rc_context({"text.usetex": True}):
        assert cl.plot(run, "orbit", output=tmp_path / "p.png").stat().st_size > 1000


# --- the store
@pytest.fixture
def private(tmp_path, monkeypatch):
    """The default store of a user, in an empty home."""
    monkeypatch.delenv("CLEARANCE_STORE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(sealed, "_refusing", set())
    return store.folder()


def written(name):
    """A file of the store, made once more or read."""
    return store.stored(name, lambda: b"symbol\ncode")


@pytest.mark.parametrize("umask", [0o000, 0o002, 0o022, 0o077])
def test_S5_the_store_is_the_users_alone(private, umask):
    """Whatever the umask of the process is."""
    before = os.umask(umask)
    try:
        assert written("kernel_x") == (b"symbol\ncode", True)
    finally:
        os.umask(before)
    assert private.stat().st_mode & 0o777 == 0o700
    modes = {p.stat().st_mode & 0o077 for p in private.iterdir()}
    assert modes == {0}
    assert written("kernel_x") == (b"symbol\ncode", False)


@pytest.mark.parametrize("seed", range(20))
def test_S5_files_that_others_may_have_written_are_not_used(private, seed, caplog):
    """Modes drawn at random: a file that others can write is made again, with a line in the log."""
    written("kernel_x")
    path, mode = store.file_of("kernel_x"), 0o600 | random.Random(seed).randrange(0o100)
    path.chmod(mode)
    data, fresh = written("kernel_x")
    assert data == b"symbol\ncode"
    assert fresh == bool(mode & 0o022)
    assert sum("is not used" in r.message for r in caplog.records) == fresh
    assert store.file_of("kernel_x").stat().st_mode & 0o022 == 0


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize("kind", ["file", "folder"])
def test_S5_files_of_others_are_not_used(private, kind, caplog):
    """A file, or the folder: the run goes on, with one line in the log."""
    written("kernel_x")
    path = store.file_of("kernel_x")
    os.chown(path if kind == "file" else path.parent, 12345, -1)
    for _ in range(2):
        assert written("kernel_x")[0] == b"symbol\ncode"
    assert [r.message for r in caplog.records if "it belongs to user 12345" in r.message]
    assert sum("is not used" in r.message for r in caplog.records) == 1


def test_S5_a_shared_folder_is_named(tmp_path, monkeypatch, caplog):
    """That CLEARANCE_STORE names, and that others can write: it stays as it is, and unused."""
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path / "store"))
    monkeypatch.setattr(sealed, "_refusing", set())
    (tmp_path / "store").mkdir()
    (tmp_path / "store").chmod(0o777)
    assert written("kernel_x") == written("kernel_x") == (b"symbol\ncode", True)
    assert not list((tmp_path / "store").iterdir())
    assert sum("others than its owner can write it" in r.message for r in caplog.records) == 1


SETTINGS_OF_NUMBA = """
import numba
from clearance.machine import store
import sys
sys.path.insert(0, "modules")
import doubling
print(store.cached(doubling.doubled, store.float64(store.float64), "one")(2.0))
print(int(numba.config.OPT), numba.config.CACHE_DIR or "none", store.COMPILED)
"""


def test_S7_numba_takes_nothing_from_the_working_folder(tmp_path):
    """Neither settings nor compiled functions; where the environment names a folder, that one."""
    pytest.importorskip("yaml")
    (tmp_path / ".numba_config.yaml").write_text("cache_dir: ./cache\nopt: 0\ndisable_jit: 1\n")
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / "doubling.py").write_text("def doubled(x):\n    return 2.0 * x\n")
    environment = {n: v for n, v in os.environ.items() if not n.startswith("NUMBA_")}
    environment["CLEARANCE_STORE"] = str(tmp_path / "store")
    for more, folder in (({}, "store/numba"), ({"NUMBA_CACHE_DIR": str(tmp_path / "e")}, "e")):
        done = subprocess.run(
            [sys.executable, "-c", SETTINGS_OF_NUMBA],
            cwd=tmp_path,
            env=environment | more,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.stdout.splitlines() == ["4.0", f"3 {more.get('NUMBA_CACHE_DIR', 'none')} True"]
        assert list((tmp_path / folder).rglob("*.nbi"))
        assert not (tmp_path / "cache").exists()
        assert not (tmp_path / "modules" / "__pycache__").is_dir() or not list(
            (tmp_path / "modules").rglob("*.nbi")
        )


# --- small
class Page(html.parser.HTMLParser):
    """The policy of a page, and the digests of its scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.policy, self.inside, self.texts = "", "", {"script": [], "style": []}
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        about = dict(attributes)
        if about.get("http-equiv") == "Content-Security-Policy":
            assert not any(self.texts.values())  # nothing before it
            self.policy = about["content"]
        runs = about.get("type") not in ("text/plain", "application/json")
        self.inside = tag if tag in self.texts and runs else ""
        assert not [n for n in about if n.startswith("on")]

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, data):
        if self.inside:
            self.texts[self.inside].append(data)

    def sources(self, name):
        return next(p.split()[1:] for p in self.policy.split("; ") if p.split()[0] == name)


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("command", ["view", "report"])
def test_pages_have_a_policy(run, command, tmp_path):
    """Reports as views: a browser runs and loads nothing but what the package wrote."""
    path = tmp_path / "page.html"
    assert main([command, str(run), "-o", str(path)]) == 0
    page = Page(path.read_text())
    assert page.sources("default-src") == page.sources("base-uri") == ["'none'"]
    for kind, texts in page.texts.items():
        digests = [hashlib.sha256(t.encode()).digest() for t in texts]
        assert page.sources(f"{kind}-src") == [
            f"'sha256-{base64.b64encode(d).decode()}'" for d in digests
        ]


@pytest.mark.parametrize("source", ["/dev/zero", "/dev/null", "pipe", "folder"])
def test_only_plain_files_are_read(source, tmp_path, capsys):
    """Of memberships, measurements, scene files: no device, no pipe, no folder."""
    path = Path(source) if source.startswith("/") else tmp_path / source
    if source == "pipe":
        os.mkfifo(path)
    elif source == "folder":
        path.mkdir()
    scene = ["-p", "model=mixed", "-p", "transition=fuzzy", "-p", f"memberships={path}"]
    link = tmp_path / "link.toml"
    link.symlink_to(path)
    for command in (["run", "slider_crank", *scene], ["run", link], ["identify", "--data", path]):
        try:
            status = main([str(word) for word in command])
        except SystemExit as request:
            status = request.code
        assert status == 2
        assert capsys.readouterr().err.count("clearance:") == 1


def test_a_text_beyond_reason_is_not_read(tmp_path):
    """A text of more bytes than any has is refused."""
    from clearance.files import texts

    path = tmp_path / "large.csv"
    with path.open("wb") as file:
        file.truncate(texts.LARGEST + 1)
    with pytest.raises(ValueError, match="large.csv has .* bytes; a text may have"):
        texts.text_of(path)


@pytest.mark.parametrize(
    "command",
    [
        "report {run} --section crank={x}",
        "scatter slider_crank --points {x}",
        "sweep slider_crank -p speed=1,2 --workers {x}",
        "inverse slider_crank --samples {x}",
        "run slider_crank -p speed={x}",
        "run slider_crank -p {x}=1",
        "run {x}",
        "{x}",
        "plot {run} --channels {x}",
        "run slider_crank --turns {x}",
        "run slider_crank -p contact={x}",
        "wear slider_crank --turns 3 -o w -p memberships={x}",
        "follow slider_crank -p speed={x}:3",
        "film pressure --cavitation {x}",
    ],
)
@pytest.mark.parametrize("seed", range(3))
def test_long_values_are_quoted_shortened(run, command, seed, tmp_path, capsys, monkeypatch):
    """The reason stays readable, whatever the value consists of and however long it is."""
    monkeypatch.chdir(tmp_path)
    rng = random.Random(seed)
    value = "".join(rng.choices("abc xyz" if seed else "x", k=rng.randint(1000, 5000)))
    words = [word.format(run=run, x=value) for word in command.split()]
    try:
        status = main(words)
    except SystemExit as request:
        status = request.code
    (line,) = (x for x in capsys.readouterr().err.splitlines() if x.startswith("clearance:"))
    assert status == 2
    assert len(line) < 1500
    assert not any(value[i : i + 300] in line for i in range(0, len(value) - 300, 100))


def test_short_messages_stay_as_they_are():
    """Words, paths and quoted values up to the bound, drawn at random."""
    rng = random.Random(1)
    for _ in range(200):
        words = ["".join(rng.choices("abcdé/.=_", k=rng.randrange(1, LONG))) for _ in range(9)]
        text = " ".join(f"'{w[: LONG - 2]}'" if rng.random() < 0.3 else w for w in words)
        assert shortened(text) == text
    assert common.shortened is shortened
