// Numbers of the page: columns of deflated blocks, read when they are needed.

const $ = (id) => document.getElementById(id);
const FACTS = JSON.parse($("facts").textContent);
const KINDS = { f4: Float32Array, f8: Float64Array, u1: Uint8Array };

async function inflated(block) {
  const text = atob($(`block${block}`).textContent),
    bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// bytes of equal rank stand beside each other in a block
function column(bytes, [kind, start, count]) {
  const Kind = KINDS[kind],
    size = Kind.BYTES_PER_ELEMENT;
  if (size === 1) return bytes.subarray(start, start + count);
  const sorted = new Uint8Array(count * size);
  for (let rank = 0; rank < size; rank++) {
    const from = start + rank * count;
    for (let i = 0; i < count; i++) sorted[i * size + rank] = bytes[from + i];
  }
  return new Kind(sorted.buffer);
}

class Run {
  constructor(facts, bytes) {
    Object.assign(this, facts);
    this.bytes = bytes;
    this.cache = new Map();
    this.shown = true;
    const machine = facts.machine;
    if (machine.shapes) {
      this.poses = Object.fromEntries(
        Object.entries(machine.poses).map(([b, p]) => [b, p.map((c) => this.read(c))]),
      );
    }
    this.clock = { time: this.read(facts.time) };
    if (facts.turn) {
      this.clock.turns = facts.turns
        ? this.read(facts.turns)
        : this.clock.time.map((t) => t / facts.turn);
    }
    const c = facts.contacts;
    this.impacts = {
      joints: c.joints,
      joint: this.read(c.joint),
      time: this.read(c.time),
      force: this.read(c.force),
    };
    this.measured = facts.measured.map((m) => ({
      ...m,
      time: this.read(m.time),
      values: this.read(m.values),
    }));
    for (const lens of facts.lenses) this.open(lens);
  }
  open(lens) {
    lens.path = lens.offsets.map((c) => this.read(c));
    lens.times = lens.clock ? this.read(lens.clock) : this.clock.time;
    lens.pull = lens.force && lens.force.map((c) => this.read(c));
    lens.changes = lens.state && this.read(lens.state);
    lens.depths = lens.worn && lens.worn.map((c) => this.read(c));
    const f = lens.fields;
    if (f)
      lens.pressure = {
        ...f,
        time: this.read(f.time),
        top: this.read(f.top),
        steps: this.read(f.steps),
      };
  }
  read(place) {
    const key = place.join(); // an empty column begins where the next one does
    if (!this.cache.has(key)) this.cache.set(key, column(this.bytes, place));
    return this.cache.get(key);
  }
  // first values of a channel, and its smallest and largest ones between samples
  channel(path) {
    const places = this.columns[path];
    if (!places) return null;
    const [at, low, high] = places.map((p) => this.read(p));
    return { at, low: low || at, high: high || at };
  }
  // abscissae of the samples: time [s] or turns
  along(kind) {
    return this.clock[kind] || this.clock.time;
  }
  // sample before a place along the run, and share of the way to the next one
  place(x, kind) {
    return between(this.along(kind), x);
  }
  // time [s] of an abscissa
  time_of(x, kind) {
    return kind === "time" ? x : at(this.clock.time, this.place(x, kind));
  }
  covers(x, kind) {
    const xs = this.along(kind),
      room = 1e-9 * (xs[xs.length - 1] - xs[0]);
    return x >= xs[0] - room && x <= xs[xs.length - 1] + room;
  }
  // a time [s] as an abscissa
  abscissa(t, kind) {
    if (kind === "time" || !this.clock.turns) return t;
    if (!this.turns) return t / this.turn;
    return at(this.clock.turns, this.place(t, "time"));
  }
}

// index of the last of ascending numbers that is not above x, -1 for none
function before(xs, x) {
  let low = -1,
    high = xs.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= x) low = middle;
    else high = middle;
  }
  return low;
}

// place of x among ascending numbers: index of the one before, and share of the way to the next one
function between(xs, x) {
  const i = Math.max(before(xs, x), 0),
    j = Math.min(i + 1, xs.length - 1);
  return [i, j > i ? Math.min(Math.max((x - xs[i]) / (xs[j] - xs[i]), 0), 1) : 0];
}

const at = (values, [i, share]) =>
  values[i] + (share ? share * (values[Math.min(i + 1, values.length - 1)] - values[i]) : 0);
