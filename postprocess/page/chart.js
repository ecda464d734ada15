// Curves over one abscissa that all charts share; the cursor is an element that moves over them.

const DECADES = 1e-5; // smallest value of a logarithmic axis over the largest one
const MEASURED = "#e0a800";
const EDGE = { left: 58, right: 14, top: 20, bottom: 22 };

class Chart {
  constructor(host, path, page) {
    this.path = path;
    this.page = page;
    this.hold = document.createElement("div");
    this.hold.className = "chart";
    [this.canvas, this.title, this.output, this.now, this.zoomed, this.shut, this.log] = [
      "canvas",
      "b",
      "output",
      "div",
      "div",
      "button",
      "button",
    ].map((tag) => this.hold.appendChild(document.createElement(tag)));
    this.now.className = "now";
    this.zoomed.className = "zoomed";
    this.zoomed.hidden = true;
    this.shut.className = "close";
    this.shut.textContent = "×";
    this.shut.title = "leave out";
    this.shut.onclick = () => page.leave(path);
    this.logged = /film_thickness_ratio$/.test(path);
    this.log.className = "log";
    this.log.textContent = "log";
    this.log.title = "logarithmic";
    this.log.onclick = () => {
      this.logged = !this.logged;
      this.draw();
    };
    host.append(this.hold);
    listen(this.hold, this.canvas, page, this.zoomed, (x) => this.read(x));
  }
  draw() {
    const [g, width, height] = sheet(this.canvas);
    this.width = width;
    const { label, unit, factor } = this.page.channel(this.path);
    this.title.textContent = unit ? `${label} [${unit}]` : label;
    this.title.title = this.stated();
    const runs = this.page.visible.filter((r) => r.columns[this.path]),
      [x0, x1] = this.page.window;
    const box = {
      x: EDGE.left,
      y: EDGE.top,
      w: width - EDGE.left - EDGE.right,
      h: height - EDGE.top - EDGE.bottom,
    };
    const range = this.range(runs, factor),
      log = this.logged && range[1] > 0,
      least = Math.max(range[2], DECADES * range[1]);
    const f = log ? (v) => Math.log(Math.max(v, least)) : (v) => v,
      [low, high] = log ? [f(least), f(range[1])] : padded(range);
    this.largest = Math.max(-range[0], range[1]);
    const px = (x) => box.x + ((x - x0) / (x1 - x0)) * box.w,
      py = (v) => box.y + box.h * (1 - (f(v) - low) / (high - low || 1));
    this.log.setAttribute("aria-pressed", log);
    frame(g, box, [x0, x1], [low, high], px, py, log);
    g.textAlign = "left";
    g.textBaseline = "top";
    g.fillText(this.page.kind === "turns" ? "turns" : "time [s]", 0, box.y + box.h + 5);
    g.save();
    g.beginPath();
    g.rect(box.x, box.y - 1, box.w, box.h + 2);
    g.clip();
    for (const run of [...runs].reverse()) this.curve(g, run, factor, px, py, [x0, x1]);
    for (const run of runs) this.measured(g, run, factor, px, py);
    this.impacts(g, px, box);
    g.restore();
    this.read(null);
  }
  // smallest and largest value in what is shown, and the smallest positive one
  range(runs, factor) {
    let low = Infinity,
      high = -Infinity,
      least = Infinity;
    for (const run of runs) {
      const c = run.channel(this.path),
        [i, j] = this.span(run);
      for (let k = i; k <= j; k++) {
        if (c.low[k] < low) low = c.low[k];
        if (c.high[k] > high) high = c.high[k];
        if (c.low[k] > 0 && c.low[k] < least) least = c.low[k];
      }
      for (const m of this.laid(run)) {
        const inside = m.values.filter((_, k) => this.shows(run.abscissa(m.time[k], this.page.kind)));
        low = Math.min(low, ...inside);
        high = Math.max(high, ...inside);
      }
    }
    return isFinite(low) && isFinite(high)
      ? [factor * low, factor * high, factor * least]
      : [0, 1, 1];
  }
  shows(x) {
    return x >= this.page.window[0] && x <= this.page.window[1];
  }
  // measured data over this channel
  laid(run) {
    return run.measured.filter((m) => m.path === this.path);
  }
  measured(g, run, factor, px, py) {
    g.fillStyle = MEASURED;
    for (const m of this.laid(run)) {
      for (let k = 0; k < m.time.length; k++) {
        const x = run.abscissa(m.time[k], this.page.kind);
        if (!this.shows(x)) continue;
        g.beginPath();
        g.arc(px(x), py(m.values[k] * factor), 2, 0, 2 * Math.PI);
        g.fill();
      }
    }
  }
  // stated errors of this channel, run by run
  stated() {
    return this.page.visible
      .filter((r) => r.errors[this.path] !== undefined)
      .map((r) => `${r.label}: stated error ${r.errors[this.path].toExponential(1)} of the range`)
      .join("\n");
  }
  // samples from the one before to the one after what is shown
  span(run) {
    const xs = run.along(this.page.kind),
      [x0, x1] = this.page.window;
    return [Math.max(before(xs, x0), 0), Math.min(before(xs, x1) + 1, xs.length - 1)];
  }
  // all samples of one pixel make one upright stroke, so that no peak is lost
  curve(g, run, factor, px, py) {
    const xs = run.along(this.page.kind),
      c = run.channel(this.path),
      [i, j] = this.span(run);
    g.beginPath();
    g.strokeStyle = run.colour;
    g.lineWidth = 1.1;
    let column = null,
      low,
      high,
      last,
      open = false;
    const flush = () => {
      if (high > low) {
        g.lineTo(column, py(low * factor));
        g.lineTo(column, py(high * factor));
      }
      g.lineTo(column, py(last * factor));
    };
    for (let k = i; k <= j; k++) {
      if (!isFinite(c.at[k])) {
        if (open) flush();
        open = false;
        continue;
      }
      const exact = px(xs[k]),
        x = j - i > 2 * this.width ? Math.round(exact) : exact;
      if (!open) {
        g.moveTo(x, py(c.at[k] * factor));
        open = true;
      } else if (x !== column) {
        flush();
        g.lineTo(x, py(c.at[k] * factor));
      }
      if (x !== column) {
        column = x;
        low = c.low[k];
        high = c.high[k];
      } else {
        low = Math.min(low, c.low[k]);
        high = Math.max(high, c.high[k]);
      }
      last = c.at[k];
    }
    if (open) flush();
    g.stroke();
  }
  // impacts of this channel's joint, of all joints where it belongs to none
  impacts(g, px, box) {
    const owner = this.path.startsWith("joints/") ? this.path.split("/")[1] : null;
    this.page.visible.forEach((run, row) => {
      const { joints, joint, time } = run.impacts;
      if (owner && !joints.some((j) => j.split("/")[0] === owner)) return;
      g.fillStyle = run.colour;
      for (let k = 0; k < time.length; k++) {
        if (owner && joints[joint[k]].split("/")[0] !== owner) continue;
        const x = px(run.abscissa(time[k], this.page.kind));
        if (x >= box.x && x <= box.x + box.w) g.fillRect(x, box.y + box.h - 6 * (row + 1), 1, 5);
      }
    });
  }
  // values at the pointer, at the cursor where there is none
  read(x) {
    const { factor } = this.page.channel(this.path);
    const runs = this.page.visible.filter((r) => r.columns[this.path]),
      spans = this.output.children;
    while (spans.length > runs.length) this.output.lastChild.remove();
    while (spans.length < runs.length) this.output.append(document.createElement("span"));
    runs.forEach((run, k) => {
      const span = spans[k];
      span.style.color = run.colour;
      const { kind } = this.page,
        place = x ?? this.page.x,
        value = at(run.channel(this.path).at, run.place(place, kind)) * factor;
      span.textContent = run.covers(place, kind) ? reading(value, this.largest) : "–";
    });
  }
  move() {
    follow(this.now, this.width, this.page);
    if (!this.page.hovered) this.read(null);
  }
}

// a range with room above and below
function padded([low, high]) {
  const room = 0.06 * (high - low) || 0.05 * Math.abs(high) || 1;
  return [low - room, high + room];
}

// axes with numbers and a grid; y0 and y1 are logarithms where the axis is logarithmic
function frame(g, box, [x0, x1], [y0, y1], px, py, log) {
  g.font = SMALL;
  g.lineWidth = 1;
  g.strokeStyle = "#e8e8e8";
  g.fillStyle = "#555";
  g.textAlign = "center";
  g.textBaseline = "top";
  const across = ticks(x0, x1, box.w / 90),
    up = log ? { at: decades(Math.exp(y0), Math.exp(y1)) } : ticks(y0, y1, box.h / 28);
  for (const x of across.at) {
    const p = Math.round(px(x)) + 0.5;
    g.beginPath();
    g.moveTo(p, box.y);
    g.lineTo(p, box.y + box.h);
    g.stroke();
    g.fillText(printed(x, across.step), p, box.y + box.h + 5);
  }
  g.textAlign = "right";
  g.textBaseline = "middle";
  for (const y of up.at) {
    const p = Math.round(py(y)) + 0.5;
    g.beginPath();
    g.moveTo(box.x, p);
    g.lineTo(box.x + box.w, p);
    g.stroke();
    g.fillText(printed(y, up.step || y), box.x - 6, p);
  }
  g.strokeStyle = "#aaa";
  g.strokeRect(box.x + 0.5, box.y + 0.5, box.w, box.h);
}

// put a cursor over what is shown
function follow(mark, width, page) {
  const [x0, x1] = page.window,
    share = (page.x - x0) / (x1 - x0);
  mark.hidden = share < 0 || share > 1;
  mark.style.transform = `translateX(${EDGE.left + share * (width - EDGE.left - EDGE.right)}px)`;
}

// click, drag, wheel and double click of what has the abscissa of the page
function listen(hold, canvas, page, zoomed, hover) {
  let from = null,
    moved = false,
    shift = false,
    window0 = null;
  const room = () => hold.clientWidth - EDGE.left - EDGE.right;
  const place = (e) => {
    const [x0, x1] = page.window,
      share = (e.clientX - canvas.getBoundingClientRect().left - EDGE.left) / room();
    return x0 + Math.min(Math.max(share, 0), 1) * (x1 - x0);
  };
  canvas.addEventListener("pointerdown", (e) => {
    from = e.clientX;
    moved = false;
    shift = e.shiftKey;
    window0 = page.window;
    canvas.setPointerCapture(e.pointerId);
  });
  canvas.addEventListener("pointermove", (e) => {
    if (from === null) {
      page.hovered = true;
      page.hover(place(e));
      return;
    }
    moved = moved || Math.abs(e.clientX - from) > 4;
    if (!moved) return;
    if (shift) {
      const by = ((from - e.clientX) / room()) * (window0[1] - window0[0]);
      page.show(window0[0] + by, window0[1] + by);
      return;
    }
    const left = Math.min(from, e.clientX) - canvas.getBoundingClientRect().left;
    zoomed.hidden = false;
    zoomed.style.left = `${left}px`;
    zoomed.style.width = `${Math.abs(e.clientX - from)}px`;
  });
  canvas.addEventListener("pointerup", (e) => {
    if (from === null) return;
    const end = place(e),
      start = place({ clientX: from });
    from = null;
    zoomed.hidden = true;
    if (!moved) page.go(end);
    else if (!shift) page.show(Math.min(start, end), Math.max(start, end));
  });
  canvas.addEventListener("pointercancel", () => {
    from = null;
    zoomed.hidden = true;
  });
  canvas.addEventListener("pointerleave", () => {
    page.hovered = false;
    page.hover(null);
  });
  canvas.addEventListener(
    "wheel",
    (e) => {
      e.preventDefault();
      const about = place(e),
        by = Math.exp(0.0015 * e.deltaY),
        [x0, x1] = page.window;
      page.show(about - (about - x0) * by, about + (x1 - about) * by);
    },
    { passive: false },
  );
  canvas.addEventListener("dblclick", () => page.show(...page.whole));
}
