// The mechanism at the time cursor, and its clearances under lenses below it.

const REST = { x: 0, y: 0, c: 1, s: 0 };

class Machine {
  constructor(canvas, page) {
    this.canvas = canvas;
    this.page = page;
    this.zoom = 1;
    this.shift = [0, 0];
    let from = null;
    canvas.addEventListener(
      "wheel",
      (e) => {
        e.preventDefault();
        this.closer(e, Math.exp(-0.0015 * e.deltaY));
      },
      { passive: false },
    );
    canvas.addEventListener("pointerdown", (e) => {
      from = [e.clientX, e.clientY];
      canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener("pointermove", (e) => {
      if (!from) return;
      this.shift = [this.shift[0] + e.clientX - from[0], this.shift[1] + e.clientY - from[1]];
      from = [e.clientX, e.clientY];
      this.draw();
    });
    canvas.addEventListener("pointerup", () => (from = null));
    canvas.addEventListener("pointercancel", () => (from = null));
    canvas.addEventListener("dblclick", () => {
      this.zoom = 1;
      this.shift = [0, 0];
      this.draw();
    });
  }
  closer(e, by) {
    const box = this.canvas.getBoundingClientRect();
    const off = [
      e.clientX - box.left - this.middle[0] - this.shift[0],
      e.clientY - box.top - this.middle[1] - this.shift[1],
    ];
    by = Math.min(Math.max(this.zoom * by, 0.5), 200) / this.zoom;
    this.zoom *= by;
    this.shift = this.shift.map((s, i) => s + off[i] * (1 - by));
    this.draw();
  }
  draw() {
    const [g, width, height] = sheet(this.canvas),
      runs = this.page.present;
    if (!runs.length) {
      note(g, width, height, "no run is shown");
      return;
    }
    const first = runs[0],
      rows = lensRows(first.lenses, width, height);
    const room = height - rows.height;
    g.save();
    g.beginPath();
    g.rect(0, 0, width, room);
    g.clip();
    const place = first.machine.shapes ? this.mechanism(g, runs, width, room) : null;
    if (!place) note(g, width, room, `mechanism not drawn: ${first.machine.missing}`);
    g.restore();
    const places = ordered(first, rows, place, `${width} ${height}`),
      when = first.place(this.page.x, this.page.kind);
    if (place)
      first.lenses.forEach((lens, i) => this.leader(g, place(tip(first, lens, when)), label(lens, rows, places[i])));
    first.lenses.forEach((lens, i) => this.lens(g, runs, lens, places[i], rows.radius));
  }

  // ---- mechanism
  mechanism(g, runs, width, height) {
    const [left, bottom, right, top] = runs[0].machine.box,
      pad = 34;
    const fit = Math.min(
      (width - 2 * pad) / (right - left || 1e-9),
      (height - 2 * pad) / (top - bottom || 1e-9),
    );
    const scale = fit * this.zoom;
    this.middle = [width / 2, height / 2];
    const px = ([x, y]) => [
      width / 2 + this.shift[0] + (x - (left + right) / 2) * scale,
      height / 2 + this.shift[1] - (y - (bottom + top) / 2) * scale,
    ];
    for (const run of [...runs].reverse()) {
      if (!run.machine.shapes) continue;
      const when = run.place(this.page.x, this.page.kind),
        ghost = run !== runs[0];
      for (const shape of run.machine.shapes)
        if (!ghost || outlined(shape)) this.shape(g, run, shape, when, px, ghost);
    }
    this.names(g, runs[0], px);
    this.ruler(g, scale, width, height);
    return px;
  }
  shape(g, run, shape, when, px, ghost) {
    const points = shape.spring ? spring(run, shape, when) : placed(run, shape, when);
    g.lineWidth = shape.width;
    g.strokeStyle = shape.edge;
    if (ghost) {
      g.lineWidth = 1;
      g.strokeStyle = run.colour;
      g.setLineDash([4, 3]);
    }
    if (shape.dot) {
      const [x, y] = px(points[0]);
      g.beginPath();
      g.arc(x, y, shape.dot, 0, 7);
      g.fillStyle = shape.fill;
      if (!ghost) g.fill();
      if (shape.ring && !ghost) {
        g.strokeStyle = stateOf(run, shape.ring, when)?.[1] || shape.edge;
        g.lineWidth = 2.5;
      }
    } else {
      trace(
        g,
        points.map((p) => p && px(p)),
        Boolean(shape.fill),
      );
      if (shape.fill && !ghost) {
        g.fillStyle = shape.fill;
        g.fill();
      }
    }
    g.stroke();
    g.setLineDash([]);
  }
  names(g, run, px) {
    const when = run.place(this.page.x, this.page.kind),
      loose = new Set(run.lenses.map((l) => l.joint));
    g.textAlign = "center";
    g.textBaseline = "middle";
    for (const label of run.machine.labels) {
      const [x, y] = px(placed(run, label, when)[0]),
        [dx, dy] = label.offset;
      g.font = loose.has(label.text) ? `bold ${LETTERS}` : SMALL;
      g.fillStyle = loose.has(label.text) ? "#222" : "#777";
      g.fillText(label.text, x + 1.2 * dx, y - 1.2 * dy);
    }
  }
  ruler(g, scale, width, height) {
    const step = ticks(0, 100 / scale, 1).step,
      length = step * scale;
    g.strokeStyle = "#555";
    g.lineWidth = 1;
    g.fillStyle = "#555";
    g.font = SMALL;
    g.textAlign = "center";
    g.textBaseline = "bottom";
    trace(g, [
      [12, height - 12],
      [12, height - 8],
      [12 + length, height - 8],
      [12 + length, height - 12],
    ]);
    g.stroke();
    g.fillText(`${+(1e3 * step).toPrecision(3)} mm`, 12 + length / 2, height - 10);
  }

  // ---- lenses
  lens(g, runs, lens, [x, y], radius) {
    const run = runs[0],
      when = run.place(this.page.x, this.page.kind),
      state = stateOf(run, lens.joint, when);
    const others = runs
      .map((r) => [r, r.lenses.find((l) => l.joint === lens.joint && l.kind === lens.kind)])
      .filter(([, l]) => l);
    if (lens.kind === "slide") guide(g, others, [x, y], radius, this.page);
    else journal(g, others, [x, y], radius, this.page);
    g.fillStyle = "#222";
    g.textAlign = "center";
    g.textBaseline = "bottom";
    g.font = LETTERS;
    g.fillText(
      `${lens.joint}: c = ${reading(1e6 * lens.clearance)} µm`,
      x,
      y - radius - (lens.pressure ? 0.3 * radius : 5),
    );
    g.textBaseline = "top";
    g.font = SMALL;
    const pull = lens.pull && Math.hypot(at(lens.pull[0], when), at(lens.pull[1], when));
    const words = [
      state && state[0],
      pull === undefined
        ? ""
        : pull < 1e-6 * lens.strong
          ? "0 N"
          : `${reading(+pull.toPrecision(3))} N`,
    ];
    g.fillStyle = state ? state[1] : "#222";
    g.fillText(words.filter(Boolean).join(", "), x, y + radius + (lens.pressure ? 0.3 * radius : 5));
  }
  leader(g, from, to) {
    g.strokeStyle = "#aaa";
    g.lineWidth = 1;
    g.setLineDash([2, 3]);
    g.beginPath();
    g.moveTo(...from);
    g.lineTo(...to);
    g.stroke();
    g.setLineDash([]);
  }
}

// shapes that stand for the bodies of a run that is laid over another one
const outlined = (shape) =>
  !shape.spring && shape.turn !== "ground" && (shape.fill || shape.width > 6);

// rows of lenses: their height in all, their radius and where each one is
function lensRows(lenses, width, height) {
  const count = lenses.length;
  if (!count) return { height: 0, radius: 0, at: () => [0, 0] };
  let best = { radius: 0 };
  for (let rows = 1; rows <= count; rows++) {
    const line = Math.ceil(count / rows),
      cell = [width / line, (0.46 * height) / rows];
    const radius = Math.min((0.5 * cell[0]) / 1.45, (0.5 * cell[1] - 18) / 1.3, 105);
    if (radius > best.radius)
      best = { radius, line, rows, cell: [width / line, 2 * (1.3 * radius + 18)] };
  }
  const { radius, line, rows, cell } = best;
  const at = (i) => {
    const row = Math.floor(i / line),
      here = Math.min(line, count - row * line);
    return [(width * (i - row * line + 0.5)) / here, height - cell[1] * (rows - row - 0.5)];
  };
  return { height: rows * cell[1], radius, at };
}

// where a joint is, and where its line ends above its lens
const tip = (run, lens, when) => world(pose(run, lens.end[0], when), lens.end.slice(1));
const label = (lens, { radius }, [x, y]) => [
  x,
  y - radius - (lens.pressure ? 0.3 * radius : 5) - 16,
];

// places of the lenses: lines to their joints are short over the run, and so they seldom cross
function ordered(run, rows, px, size) {
  if (run.order?.size === size) return run.order.places;
  const { lenses } = run,
    places = lenses.map((_, i) => rows.at(i));
  if (!px) return places;
  const count = Object.values(run.poses)[0]?.[0].length ?? 1,
    instants = Array.from({ length: 12 }, (_, j) => [Math.floor((j * count) / 12), 0]),
    joints = lenses.map((lens) => instants.map((when) => px(tip(run, lens, when))));
  const far = (i, to) =>
    joints[i].reduce((sum, [x, y]) => sum + Math.hypot(x - to[0], y - to[1]), 0);
  for (let round = 0; round < lenses.length; round++)
    for (let i = 0; i < lenses.length; i++)
      for (let j = 0; j < i; j++) {
        const [a, b] = [places[i], places[j]];
        if (far(i, b) + far(j, a) < far(i, a) + far(j, b)) [places[i], places[j]] = [b, a];
      }
  run.order = { size, places };
  return places;
}

// name and colour of the state of a joint
function stateOf(run, joint, when) {
  const lens = run.lenses.find((l) => l.joint === joint);
  return lens && lens.changes
    ? lens.states[lens.changes[Math.min(when[0] + (when[1] > 0), lens.changes.length - 1)]]
    : null;
}

// ---- clearance circle, trail and centre of a journal, force on it, pressure round it
function journal(g, laid, [x, y], radius, page) {
  const [run, lens] = laid[0],
    when = run.place(page.x, page.kind),
    slot = lens.kind === "slot";
  g.beginPath();
  g.fillStyle = "#fffdf5";
  g.arc(x, y, radius, 0, 7);
  g.fill();
  g.strokeStyle = "#444";
  g.lineWidth = 1;
  if (slot)
    for (const side of [-1, 1]) {
      trace(g, [
        [x - radius, y + side * radius],
        [x + radius, y + side * radius],
      ]);
      g.stroke();
    }
  else {
    g.beginPath();
    g.arc(x, y, radius, 0, 7);
    g.stroke();
  }
  if (lens.depths) worn(g, run, lens, when, [x, y], radius);
  const state = stateOf(run, lens.joint, when);
  if (state && !slot) {
    g.beginPath();
    g.strokeStyle = state[1];
    g.lineWidth = 3;
    g.arc(x, y, radius + 3, 0, 7);
    g.stroke();
  }
  g.strokeStyle = "#bbb";
  g.lineWidth = 1;
  trace(g, [[x - 5, y], [x + 5, y], null, [x, y - 5], [x, y + 5]]);
  g.stroke();
  if (lens.pressure) rim(g, run, lens, [x, y], radius, page);
  for (const [r, l] of [...laid].reverse()) trail(g, r, l, [x, y], radius, page);
  laid.forEach(([r, l], k) => {
    const here = r.place(page.x, page.kind),
      p = centre(l, r.time_of(page.x, page.kind), [x, y], radius);
    if (l.pull)
      arrow(
        g,
        p,
        l.pull.map((f) => (at(f, here) / lens.strong) * radius),
        radius,
        k ? r.colour : "#222",
      );
    g.beginPath();
    g.arc(...p, 4.5, 0, 7);
    g.fillStyle = r.colour;
    g.fill();
    g.strokeStyle = "#222";
    g.lineWidth = 1;
    g.stroke();
  });
}

// the edge of the room that wear has left to the centre of the journal
function worn(g, run, lens, when, [x, y], radius) {
  const [bearing, journal] = lens.depths,
    turns = [lens.end[0], lens.turning].map((body) => angleOf(run, body, when)),
    deep = (depths, angle) => {
      const n = depths.length,
        place = (((angle / (2 * Math.PI)) % 1) + 1) * n;
      return at([depths[Math.floor(place) % n], depths[(Math.floor(place) + 1) % n]], [0, place % 1]);
    };
  const points = Array.from({ length: 361 }, (_, j) => {
    const angle = (j / 180) * Math.PI,
      depth = deep(bearing, angle - turns[0]) + deep(journal, angle - turns[1]),
      out = radius * (1 + depth / lens.clearance);
    return [x + out * Math.cos(angle), y - out * Math.sin(angle)];
  });
  g.fillStyle = "#fffdf5";
  g.strokeStyle = "#a33";
  g.lineWidth = 1;
  trace(g, points, true);
  g.fill();
  g.stroke();
}

// angle of a body [rad]
function angleOf(run, body, when) {
  return body === "ground" ? 0 : at(run.poses?.[body]?.[2] || [0], when);
}

// centre of a journal; of a pin only its place across the slot counts
function centre(lens, time, [x, y], radius) {
  const scale = radius / lens.clearance,
    when = between(lens.times, time),
    e = lens.path.map((p) => at(p, when) * scale);
  return lens.kind === "slot" ? [x, y - e[0]] : [x + e[0], y - e[1]];
}

// the path over the last turn before the cursor
function trail(g, run, lens, [x, y], radius, page) {
  if (lens.kind === "slot") return;
  const [from, time] = [
    page.kind === "turns" ? page.x - 1 : page.x - (run.turn || run.end),
    page.x,
  ].map((s) => run.time_of(s, page.kind));
  const scale = radius / lens.clearance,
    last = before(lens.times, time);
  g.strokeStyle = run.colour;
  g.globalAlpha = 0.75;
  g.lineWidth = 1.1;
  g.beginPath();
  g.moveTo(...centre(lens, from, [x, y], radius));
  for (let k = Math.max(before(lens.times, from) + 1, 0); k <= last; k++)
    g.lineTo(x + lens.path[0][k] * scale, y - lens.path[1][k] * scale);
  g.lineTo(...centre(lens, time, [x, y], radius));
  g.stroke();
  g.globalAlpha = 1;
}

function arrow(g, [x, y], force, most, colour) {
  const size = Math.hypot(...force),
    share = size > most ? most / size : 1,
    dx = force[0] * share,
    dy = -force[1] * share;
  const length = Math.hypot(dx, dy);
  if (length < 2) return;
  const head = Math.min(8, 0.5 * length),
    ux = dx / length,
    uy = dy / length,
    tip = [x + dx, y + dy];
  g.strokeStyle = colour;
  g.lineWidth = 1.6;
  trace(g, [
    [x, y],
    tip,
    null,
    [tip[0] - head * (ux + 0.5 * uy), tip[1] - head * (uy - 0.5 * ux)],
    tip,
    [tip[0] - head * (ux - 0.5 * uy), tip[1] - head * (uy + 0.5 * ux)],
  ]);
  g.stroke();
}

// pressure in the middle of the bearing, outwards from its wall
function rim(g, run, lens, [x, y], radius, page) {
  const p = lens.pressure,
    [across, around] = p.shape,
    k = fieldAt(lens, run, page),
    turned = angleOf(run, lens.end[0], run.place(page.x, page.kind));
  const row = (k * across + (across >> 1)) * around,
    scale = (0.28 * p.top[k]) / p.largest / 255;
  const points = Array.from({ length: around + 1 }, (_, j) => {
    const angle = (j / around) * 2 * Math.PI + turned,
      out = radius * (1.06 + Math.min(p.steps[row + (j % around)] * scale, 0.3));
    return [x + out * Math.cos(angle), y - out * Math.sin(angle)];
  });
  g.fillStyle = "#7b2d8b30";
  g.strokeStyle = "#7b2d8b";
  g.lineWidth = 1.2;
  trace(g, points, true);
  g.stroke();
  g.beginPath();
  points.forEach((q, j) => g[j ? "lineTo" : "moveTo"](...q));
  g.arc(x, y, 1.06 * radius, 0, 2 * Math.PI, true);
  g.fill("evenodd");
}

// ---- a block in its guide; its clearance is magnified, and with it offset and tilt
function guide(g, laid, [x, y], radius, page) {
  const [, lens] = laid[0],
    a = lens.overlap / 2,
    b = lens.height / 2,
    room = lens.magnified * b;
  const scale = Math.min((radius * 1.25) / (1.25 * a), (radius * 0.9) / (b + room));
  g.strokeStyle = "#444";
  g.lineWidth = 1.2;
  for (const side of [-1, 1]) {
    trace(g, [
      [x - 1.25 * a * scale, y + side * (b + room) * scale],
      [x + 1.25 * a * scale, y + side * (b + room) * scale],
    ]);
    g.stroke();
  }
  for (const [run, lens_of] of [...laid].reverse()) {
    const when = run.place(page.x, page.kind),
      [e, tilt] = lens_of.path.map((p) => at(p, when) / lens_of.clearance);
    const corners = [0, 1, 3, 2]
      .map((i) => lens_of.corners[i])
      .map(([sx, sy]) => [
        x + sx * a * scale,
        y - (room * (e + sx * 0.5 * lens_of.overlap * tilt) + sy * b) * scale,
      ]);
    const state = stateOf(run, lens_of.joint, when);
    g.strokeStyle = run === laid[0][0] && state ? state[1] : run.colour;
    g.lineWidth = 2;
    g.fillStyle = "#ffffffb0";
    trace(g, corners, true);
    g.fill();
    g.stroke();
  }
}

// ---- places
function pose(run, body, when) {
  if (body === "ground") return REST;
  const [x, y, q] = run.poses[body].map((v) => at(v, when));
  return { x, y, c: Math.cos(q), s: Math.sin(q) };
}
const world = (p, [x, y]) => [p.x + p.c * x - p.s * y, p.y + p.s * x + p.c * y];

function placed(run, shape, when) {
  const turn = pose(run, shape.turn, when);
  let from = turn;
  if (shape.at) {
    const [x, y] = world(pose(run, shape.at[0], when), shape.at.slice(1));
    from = { ...turn, x, y };
  }
  return shape.points.map((p) => p && world(from, p));
}

function spring(run, shape, when) {
  const [a, b] = [placed(run, shape.a, when)[0], placed(run, shape.b, when)[0]];
  const line = [b[0] - a[0], b[1] - a[1]],
    length = Math.hypot(...line) || 1e-300;
  return shape.spring.map(
    (p) =>
      p && [
        a[0] + p[0] * line[0] - (p[1] * line[1]) / length,
        a[1] + p[0] * line[1] + (p[1] * line[0]) / length,
      ],
  );
}

// a path through points; null is a gap
function trace(g, points, closed) {
  g.beginPath();
  let open = false;
  for (const p of points) {
    if (p) g[open ? "lineTo" : "moveTo"](...p);
    open = Boolean(p);
  }
  if (closed) g.closePath();
}

function note(g, width, height, text) {
  g.fillStyle = "#777";
  g.textAlign = "center";
  g.textBaseline = "middle";
  const words = text.split(" "),
    lines = [""];
  for (const word of words) {
    if (g.measureText(`${lines.at(-1)} ${word}`).width > width - 40) lines.push("");
    lines[lines.length - 1] += `${word} `;
  }
  lines.forEach((line, i) => g.fillText(line, width / 2, height / 2 + 16 * (i - lines.length / 2)));
}
