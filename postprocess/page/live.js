// Sliders: the mechanism is integrated anew in this browser, by the module that the page has.

const FINEST = 400; // positions of a slider

class Live {
  constructor(page) {
    this.page = page;
    this.facts = FACTS.live;
  }
  async start() {
    const bytes = Uint8Array.from(atob($("module").textContent), (c) => c.charCodeAt(0));
    const { instance } = await WebAssembly.instantiate(bytes, {});
    this.code = instance.exports;
    this.code._initialize?.();
    this.code.reset();
    this.values = this.facts.sliders.map((s) => s.value);
    const hold = document.createElement("div");
    hold.id = "sliders";
    hold.append(...this.facts.sliders.map((s, i) => this.slider(s, i)));
    $("left").prepend(hold);
  }
  slider(facts, i) {
    const label = document.createElement("label"),
      text = document.createElement("span"),
      input = document.createElement("input");
    Object.assign(input, { type: "range", min: -FINEST, max: FINEST, value: 0 });
    input.dataset.name = facts.name;
    const written = () => {
      text.textContent = `${facts.name} ${(this.values[i] / facts.factor).toPrecision(4)} ${facts.unit}`;
    };
    input.oninput = () => {
      this.values[i] = facts.value * facts.range ** (+input.value / FINEST);
      written();
      this.due ??= requestAnimationFrame(() => {
        this.due = null;
        this.redraw();
      });
    };
    written();
    label.append(text, input);
    return label;
  }
  // rows of all outputs at the samples of the page, or null where the run fails
  rows(count) {
    const { code, facts } = this,
      outputs = facts.outputs.length;
    code.reset();
    const numbers = new Float64Array(code.memory.buffer, code.numbers_at(), facts.numbers);
    facts.sliders.forEach((s, i) => (numbers[s.index] = this.values[i]));
    code.begin();
    const speed = facts.speed === null ? 1 : this.values[facts.speed] / facts.sliders[facts.speed].value;
    const end = facts.end / Math.abs(speed),
      rows = facts.outputs.map(() => new Float64Array(count)),
      time = new Float64Array(count);
    for (let k = 0; k < count; k++) {
      time[k] = (end * k) / (count - 1);
      if (code.go(time[k]) !== 0) return null;
      const row = new Float64Array(code.memory.buffer, code.values_at(), outputs);
      for (let i = 0; i < outputs; i++) rows[i][k] = row[i];
    }
    const residual = rows[facts.places["energy/residual"]];
    if (residual) residual.forEach((v, k) => (residual[k] = k ? v - residual[0] : v));
    if (residual) residual[0] = 0;
    for (const i of facts.wrapped)
      for (let k = 1; k < count; k++)
        rows[i][k] += 2 * Math.PI * Math.round((rows[i][k - 1] - rows[i][k]) / (2 * Math.PI));
    return { time, end, speed, of: (path) => rows[facts.places[path]] };
  }
  redraw() {
    const run = this.page.runs[0],
      rows = this.rows(run.clock.time.length);
    $("sliders").className = rows ? "" : "bad";
    if (!rows) return;
    const { page } = this,
      [low, high] = page.whole,
      shares = [...page.window, page.x].map((x) => (x - low) / (high - low));
    this.put(run, rows);
    run.about = [];
    page.legend();
    page.ends();
    const [from, to, x] = shares.map((s) => page.whole[0] + s * (page.whole[1] - page.whole[0]));
    page.show(from, to);
    page.x = x;
    page.redraw();
  }
  put(run, { time, end, speed, of }) {
    run.clock.time = time;
    run.end = end;
    run.settled = 0;
    if (run.turn) {
      run.turn = this.facts.turn / Math.abs(speed);
      run.clock.turns = time.map((t) => t / run.turn);
    }
    for (const [path, [place]] of Object.entries(run.columns)) {
      const values = of(path) || this.size(path, of);
      if (values) run.cache.set(place.join(), values);
    }
    for (const body of Object.keys(run.poses || {}))
      run.poses[body] = ["x", "y", "theta"].map((c) => of(`bodies/${body}/${c}`));
    run.impacts = { joints: run.impacts.joints, joint: [], time: [], force: [] };
    for (const lens of run.lenses) {
      const at = this.facts.clearances[lens.joint];
      if (at !== undefined) lens.clearance = this.values[at];
      lens.path = this.facts.offsets[lens.kind].map((n) => of(`joints/${lens.joint}/${n}`));
      lens.times = time;
      lens.pull = lens.pull && ["x", "y"].map((c) => of(`joints/${lens.joint}/force_${c}`));
      lens.changes = undefined;
    }
  }
  // sizes of vectors
  size(path, of) {
    const group = path.slice(0, path.lastIndexOf("/"));
    if (path.endsWith("/epsilon")) return of(`${group}/eccentricity_ratio`);
    const [x, y] = ["x", "y"].map((c) => of(`${path}_${c}`));
    return x && y && x.map((v, k) => Math.hypot(v, y[k]));
  }
}

if (FACTS.live) {
  page.live = new Live(page);
  page.started = page.started
    .then(() => page.live.start())
    .then(() => {
      SIZES.clear();
      page.redraw();
    });
}
