// Metrics of a sweep over its parameters; a click opens the run of a point.

const NONE = "#f2f2f2";

class SweepMap {
  constructor(page) {
    this.page = page;
    this.facts = FACTS.map;
    this.hold = $("map");
    this.canvas = this.hold.querySelector("canvas");
    this.hold.hidden = false;
    const { parameters, metrics } = this.facts;
    this.selects = {};
    const wide = parameters.filter((p) => p.values.length > 1);
    this.pick(
      "x",
      "across",
      wide.map((p) => [p.name, p.label]),
      this.facts.x,
    );
    this.pick("y", "up", [["", "the metric"], ...wide.map((p) => [p.name, p.label])], this.facts.y);
    this.pick(
      "metric",
      "metric",
      metrics.map((m) => [m.name, m.label]),
      this.facts.metric,
    );
    this.held = {};
    this.hold_others();
    this.canvas.addEventListener("pointermove", (e) => this.say(this.near(e)));
    this.canvas.addEventListener("pointerleave", () => this.say(null));
    this.canvas.addEventListener("click", (e) => {
      const i = this.near(e);
      if (i !== null) page.openPoint(i, e.shiftKey);
    });
  }
  pick(key, text, choices, chosen) {
    const label = document.createElement("label"),
      select = document.createElement("select");
    for (const [value, name] of choices)
      select.add(new Option(name, value, false, value === chosen));
    label.append(`${text} `, select);
    $("axes").append(label);
    select.onchange = () => {
      if (key === "x" || key === "y") this.hold_others();
      this.draw();
    };
    this.selects[key] = select;
  }
  // one value of each parameter of a grid that has no axis
  hold_others() {
    for (const [name, label] of Object.entries(this.held)) {
      label.remove();
      delete this.held[name];
    }
    if (this.facts.drawn) return;
    const taken = [this.selects.x.value, this.selects.y.value],
      free = this.facts.parameters.filter((p) => !taken.includes(p.name) && p.values.length > 1);
    for (const p of free) {
      if (taken.some((t) => p.axis === this.parameter(t)?.axis)) continue;
      const label = document.createElement("label"),
        select = document.createElement("select");
      p.values.forEach((v, i) => select.add(new Option(`${p.label}: ${p.text[i]}`, i)));
      label.append(select);
      select.onchange = () => this.draw();
      $("axes").append(label);
      this.held[p.name] = label;
    }
  }
  parameter(name) {
    return this.facts.parameters.find((p) => p.name === name);
  }
  get metric() {
    return this.facts.metrics.find((m) => m.name === this.selects.metric.value);
  }
  // points that are shown
  points() {
    const held = Object.entries(this.held).map(([name, label]) => [
      this.parameter(name),
      +label.firstChild.value,
    ]);
    return this.facts.status
      .map((_, i) => i)
      .filter((i) => held.every(([p, value]) => p.place[i] === value));
  }
  draw() {
    const [g, width, height] = sheet(this.canvas),
      X = this.parameter(this.selects.x.value),
      Y = this.parameter(this.selects.y.value);
    const box = { x: 74, y: 10, w: width - 74 - (Y ? 84 : 16), h: height - 10 - 38 },
      values = this.metric.values,
      shown = this.points();
    const finite = shown.map((i) => values[i]).filter((v) => v !== null);
    this.low = Math.min(...finite);
    this.high = Math.max(...finite);
    const across = scaleOf(X, box.x, box.w, this.facts.drawn),
      up = Y
        ? scaleOf(Y, box.y + box.h, -box.h, this.facts.drawn)
        : valueScale(this.low, this.high, box);
    g.strokeStyle = "#aaa";
    g.strokeRect(box.x + 0.5, box.y + 0.5, box.w, box.h);
    this.spots = shown.map((i) => ({
      i,
      x: across.at(i),
      y: Y ? up.at(i) : values[i] === null ? box.y + box.h : up.of(values[i]),
      w: across.cell,
      h: Y ? up.cell : 0,
    }));
    if (!Y) this.line(g);
    for (const spot of this.spots) this.spot(g, spot, Y);
    this.labels(g, box, X, Y, across, up);
    if (Y && finite.length) this.bar(g, box);
    this.say(null);
  }
  line(g) {
    if (this.facts.drawn) return;
    g.strokeStyle = "#bbb";
    g.lineWidth = 1;
    trace(
      g,
      [...this.spots]
        .sort((a, b) => a.x - b.x)
        .map((s) => (this.metric.values[s.i] === null ? null : [s.x, s.y])),
    );
    g.stroke();
  }
  spot(g, { i, x, y, w, h }, Y) {
    const value = this.metric.values[i],
      open = this.page.points.indexOf(i);
    g.fillStyle = value === null ? NONE : Y ? css(shade(this.share(value))) : "#555";
    g.beginPath();
    if (Y && w) g.rect(x - w / 2, y - h / 2, w + 0.5, h + 0.5);
    else g.arc(x, y, 4.5, 0, 7);
    g.fill();
    if (this.facts.status[i] !== "done") {
      g.strokeStyle = "#c0392b";
      g.lineWidth = 1.2;
      trace(g, [[x - 4, y - 4], [x + 4, y + 4], null, [x - 4, y + 4], [x + 4, y - 4]]);
      g.stroke();
    }
    if (open >= 0) {
      g.beginPath();
      g.arc(x, y, 6.5, 0, 7);
      g.fillStyle = COLOURS[open % MOST];
      g.strokeStyle = "#fff";
      g.lineWidth = 2;
      g.fill();
      g.stroke();
    }
  }
  share(value) {
    const log = this.low > 0 && this.high > 20 * this.low,
      f = log ? Math.log : (v) => v;
    return this.high > this.low ? (f(value) - f(this.low)) / (f(this.high) - f(this.low)) : 0.5;
  }
  labels(g, box, X, Y, across, up) {
    g.fillStyle = "#555";
    g.font = SMALL;
    g.textAlign = "center";
    g.textBaseline = "top";
    for (const [p, text] of across.ticks) g.fillText(text, p, box.y + box.h + 5);
    g.fillText(X.label, box.x + box.w / 2, box.y + box.h + 21);
    g.textAlign = "right";
    g.textBaseline = "middle";
    for (const [p, text] of up.ticks) g.fillText(text, box.x - 6, p);
    g.save();
    g.translate(9, box.y + box.h / 2);
    g.rotate(-Math.PI / 2);
    g.textAlign = "center";
    g.fillText(Y ? Y.label : this.metric.short, 0, 0);
    g.restore();
  }
  bar(g, box) {
    const x = box.x + box.w + 14,
      steps = 50,
      log = this.low > 0 && this.high > 20 * this.low;
    for (let k = 0; k < steps; k++) {
      g.fillStyle = css(shade((k + 0.5) / steps));
      g.fillRect(x, box.y + box.h * (1 - (k + 1) / steps), 11, box.h / steps + 0.7);
    }
    g.fillStyle = "#555";
    g.textAlign = "left";
    g.textBaseline = "middle";
    g.font = SMALL;
    const values = log
      ? [0, 1 / 3, 2 / 3, 1].map((s) => this.low * (this.high / this.low) ** s)
      : ticks(this.low, this.high, 4).at;
    for (const v of values)
      g.fillText(String(+v.toPrecision(3)), x + 15, box.y + box.h * (1 - this.share(v)));
  }
  near(e) {
    const area = this.canvas.getBoundingClientRect(),
      x = e.clientX - area.left,
      y = e.clientY - area.top;
    let best = null,
      least = Infinity;
    for (const s of this.spots) {
      const d = Math.hypot(x - s.x, y - s.y);
      if (d < least) {
        least = d;
        best = s;
      }
    }
    const inside =
      best &&
      (least < 14 || (Math.abs(x - best.x) <= best.w / 2 && Math.abs(y - best.y) <= best.h / 2));
    return inside ? best.i : null;
  }
  say(i) {
    const f = this.facts;
    if (i === null) {
      $("point").textContent = f.note;
      return;
    }
    const where = f.parameters.map((p) => `${p.label} ${p.text[p.place[i]]}`).join(", "),
      value = this.metric.values[i];
    const more =
      f.status[i] !== "done"
        ? `${f.status[i]}: ${f.reason[i]}`
        : `${this.metric.short} ${value === null ? "–" : reading(value)}`;
    $("point").textContent =
      `${where}: ${more}${f.blocks[i] === null ? " (its run is not in this page)" : ""}`;
  }
}

// values of a parameter along an axis: those of a grid at equal distances
function scaleOf(p, start, length, drawn) {
  const count = p.values.length;
  if (drawn && p.numbers) {
    const low = Math.min(...p.values),
      high = Math.max(...p.values),
      room = 0.04 * (high - low) || 1;
    const of = (v) => start + ((v - low + room) / (high - low + 2 * room)) * length,
      t = ticks(low, high, Math.abs(length) / 60);
    return {
      at: (i) => of(p.values[p.place[i]]),
      cell: 0,
      ticks: t.at.map((v) => [of(v), printed(v, t.step)]),
    };
  }
  const step = length / count,
    every = Math.ceil(count / Math.max(Math.abs(length) / (length > 0 ? 46 : 16), 1));
  const of = (k) => start + (k + 0.5) * step;
  return {
    at: (i) => of(p.place[i]),
    cell: Math.abs(step),
    ticks: p.text.map((t, k) => [of(k), t]).filter((_, k) => k % every === 0),
  };
}

function valueScale(low, high, box) {
  const room = 0.06 * (high - low) || 0.05 * Math.abs(high) || 1,
    t = ticks(low, high, box.h / 28);
  const of = (v) => box.y + box.h * (1 - (v - low + room) / (high - low + 2 * room));
  return { of, ticks: t.at.map((v) => [of(v), printed(v, t.step)]) };
}
