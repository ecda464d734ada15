// One time for everything: the page, its controls and its keys.

const PACES = [
  [1, "a turn in 1 s"],
  [3, "a turn in 3 s"],
  [10, "a turn in 10 s"],
  [30, "a turn in 30 s"],
  [0, "real time"],
];
const OPENED = 2; // turns that a page opens on, at most
const ZOOM = 1e-6; // least part of a run that is shown

const page = {
  runs: [],
  points: [],
  charts: new Map(),
  fields: [],
  kind: "time",
  x: 0,
  window: [0, 1],
  whole: [0, 1],
  playing: false,
  hovered: false,
  get visible() {
    return this.runs.filter((r) => r.shown);
  },
  // runs that are shown and not over at the cursor
  get present() {
    const here = this.visible.filter((r) => r.covers(this.x, this.kind));
    return here.length ? here : this.visible.slice(0, 1);
  },
  channel(path) {
    return FACTS.channels[path];
  },

  // ---- what is shown
  async start() {
    this.machine = new Machine($("machine"), this);
    if (FACTS.map) this.map = new SweepMap(this);
    if (FACTS.map?.blocks.every((block) => block === null)) document.body.className = "bare";
    for (const block of FACTS.open) await this.add(block);
    this.points = FACTS.map ? FACTS.open.map((b) => FACTS.map.blocks.indexOf(b)) : [];
    this.build();
    performance.mark("drawn");
  },
  async add(block) {
    const run = new Run(FACTS.runs[block], await inflated(block));
    run.colour = COLOURS[this.runs.length % MOST];
    this.runs.push(run);
  },
  async openPoint(i, more) {
    const block = FACTS.map.blocks[i],
      { x, kind, window, whole } = this;
    if (block === null || (more && this.points.includes(i))) return;
    if (!more || this.runs.length >= MOST) {
      this.runs = [];
      this.points = [];
    }
    this.points.push(i);
    await this.add(block);
    const share = (x - whole[0]) / (whole[1] - whole[0]);
    this.build();
    if (kind === this.kind && window[1] > window[0])
      this.go(this.whole[0] + share * (this.whole[1] - this.whole[0]));
  },
  build() {
    const kinds = this.runs.every((r) => r.clock.turns) && this.runs.length;
    $("along").hidden = $("opened").hidden = !kinds;
    const even = new Set(this.runs.map((r) => r.turn)).size < 2;
    this.kind = kinds && !even ? "turns" : "time";
    $("along").value = this.kind;
    this.legend();
    this.paces();
    this.curves();
    this.ends();
    this.fieldsOf();
    SIZES.clear();
    this.show(...this.opened());
    this.go(this.window[0]);
    if (this.map) this.map.draw();
  },
  // ends of all runs
  ends() {
    const xs = this.runs.map((r) => r.along(this.kind));
    this.whole = xs.length
      ? [Math.min(...xs.map((v) => v[0])), Math.max(...xs.map((v) => v[v.length - 1]))]
      : [0, 1];
    Object.assign($("time"), { min: this.whole[0], max: this.whole[1] });
  },
  // the settled turns that every run has
  opened() {
    if (!this.runs.length) return this.whole;
    const low = Math.max(...this.runs.map((r) => r.abscissa(r.settled, this.kind))),
      high = Math.min(...this.runs.map((r) => r.abscissa(r.end, this.kind)));
    const turns =
      this.kind === "turns" ? OPENED : this.runs[0].turn ? OPENED * this.runs[0].turn : Infinity;
    return low < high ? [Math.max(low, high - turns), high] : this.whole;
  },
  show(from, to) {
    const [low, high] = this.whole,
      least = ZOOM * (high - low),
      width = Math.min(Math.max(to - from, least), high - low);
    const start = Math.min(Math.max(from, low), high - width);
    this.window = [start, start + width];
    if (!this.due) {
      this.due = true;
      requestAnimationFrame(() => {
        this.due = false;
        this.redraw();
      });
    }
  },
  redraw() {
    for (const chart of this.charts.values()) chart.draw();
    for (const field of this.fields) field.draw();
    this.place();
  },
  legend() {
    $("runs").replaceChildren(
      ...this.runs.map((run) => {
        const label = document.createElement("label"),
          box = Object.assign(document.createElement("input"), {
            type: "checkbox",
            checked: run.shown,
          });
        const swatch = document.createElement("i"),
          text = document.createElement("b");
        swatch.style.background = run.colour;
        text.textContent = run.label;
        box.onchange = () => {
          run.shown = box.checked;
          this.redraw();
        };
        label.append(
          box,
          swatch,
          text,
          ...run.about.map((part) => {
            const span = document.createElement("span");
            span.textContent = part;
            if (/partial:|warning/.test(part)) span.className = "bad";
            return span;
          }),
        );
        return label;
      }),
    );
  },
  paces() {
    const unit = this.runs[0]?.turn ? "a turn" : "the run",
      chosen = $("pace").value || "10";
    $("pace").replaceChildren(
      ...PACES.map(
        ([s, text]) => new Option(text.replace("a turn", unit), s, false, String(s) === chosen),
      ),
    );
  },

  // ---- curves
  curves() {
    const paths = Object.keys(FACTS.channels).filter((p) => this.runs.some((r) => r.columns[p]));
    const wanted = this.charts.size
      ? [...this.charts.keys()].filter((p) => paths.includes(p))
      : FACTS.first.filter((p) => paths.includes(p));
    for (const chart of this.charts.values()) chart.hold.remove();
    this.charts.clear();
    $("choice").replaceChildren(...paths.map((path) => this.box(path, wanted.includes(path))));
    for (const path of wanted) this.charts.set(path, new Chart($("curves"), path, this));
  },
  box(path, checked) {
    const label = document.createElement("label"),
      box = Object.assign(document.createElement("input"), { type: "checkbox", checked });
    const { label: text, unit } = this.channel(path);
    box.dataset.path = path;
    box.onchange = () => {
      if (box.checked) this.take(path);
      else this.leave(path);
    };
    label.append(box, ` ${text}${unit ? ` [${unit}]` : ""}`);
    label.title = path;
    return label;
  },
  take(path) {
    const chart = new Chart($("curves"), path, this);
    this.charts.set(path, chart);
    chart.draw();
    chart.move();
  },
  leave(path) {
    this.charts.get(path).hold.remove();
    this.charts.delete(path);
    for (const box of $("choice").querySelectorAll("input"))
      if (box.dataset.path === path) box.checked = false;
  },
  fieldsOf() {
    for (const field of this.fields) field.hold.remove();
    this.fields = this.runs.flatMap((run) =>
      run.lenses.filter((l) => l.pressure).map((lens) => new Field($("fields"), run, lens, this)),
    );
  },

  // ---- time
  go(x) {
    this.x = Math.min(Math.max(x, this.whole[0]), this.whole[1]);
    this.place();
  },
  place() {
    this.machine.draw();
    for (const chart of this.charts.values()) chart.move();
    for (const field of this.fields) field.move();
    const run = this.visible[0] || this.runs[0];
    $("time").value = this.x;
    if (!run) return;
    const t = run.time_of(this.x, this.kind);
    $("clock").textContent =
      `${t.toFixed(5)} s` +
      (run.clock.turns ? `, turn ${run.abscissa(t, "turns").toFixed(3)}` : "");
  },
  hover(x) {
    for (const chart of this.charts.values()) chart.read(x);
  },
  // abscissa that goes by in a second of playing
  pace() {
    const seconds = +$("pace").value,
      run = this.visible[0] || this.runs[0];
    const one = this.kind === "turns" ? 1 : run.turn || run.end;
    return seconds ? one / seconds : this.kind === "turns" ? 1 / run.turn : 1;
  },
  tick(stamp) {
    if (!this.playing) return;
    if (this.stamp) {
      const [from, to] = this.window,
        inside = this.x >= from && this.x <= to,
        next = this.x + ((stamp - this.stamp) / 1000) * this.pace();
      this.go(inside && next > to ? from : next >= this.whole[1] ? from : next);
    }
    this.stamp = stamp;
    requestAnimationFrame((s) => this.tick(s));
  },
  play() {
    this.playing = !this.playing && this.runs.length > 0;
    this.stamp = 0;
    $("play").textContent = this.playing ? "pause" : "play";
    if (this.playing) requestAnimationFrame((s) => this.tick(s));
  },
  // to a sample of the first run, some further
  sample(by) {
    const xs = (this.visible[0] || this.runs[0]).along(this.kind),
      i = before(xs, this.x * (1 + 1e-12)) + by;
    this.go(xs[Math.min(Math.max(i, 0), xs.length - 1)]);
  },
};

const KEYS = {
  " ": () => page.play(),
  ArrowLeft: (e) => page.sample(e.shiftKey ? -10 : -1),
  ArrowRight: (e) => page.sample(e.shiftKey ? 10 : 1),
  Home: () => page.go(page.window[0]),
  End: () => page.go(page.window[1]),
  "?": () => $("keys").showModal(),
};
document.addEventListener("keydown", (e) => {
  if (
    ["INPUT", "SELECT", "BUTTON"].includes(e.target.tagName) &&
    e.target.type !== "checkbox"
  )
    return;
  if (KEYS[e.key] && (page.runs.length || e.key === "?")) {
    e.preventDefault();
    KEYS[e.key](e);
  }
});
$("play").onclick = () => page.play();
$("time").oninput = () => page.go(+$("time").value);
$("whole").onclick = () => page.show(...page.whole);
$("opened").onclick = () => page.show(...page.opened());
$("help").onclick = () => $("keys").showModal();
$("along").onchange = () => {
  const run = page.visible[0] || page.runs[0],
    ends = page.window.map((x) => run.time_of(x, page.kind));
  const t = run.time_of(page.x, page.kind);
  page.kind = $("along").value;
  page.ends();
  page.show(...ends.map((s) => run.abscissa(s, page.kind)));
  page.go(run.abscissa(t, page.kind));
};
$("filter").oninput = () => {
  const words = $("filter").value.toLowerCase().split(" ").filter(Boolean);
  for (const label of $("choice").children)
    label.hidden = !words.every((w) =>
      `${label.textContent} ${label.title}`.toLowerCase().includes(w),
    );
};
addEventListener("resize", () => {
  SIZES.clear();
  page.redraw();
  if (page.map) page.map.draw();
});
page.started = page.start();
