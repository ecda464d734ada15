// The pressure of a film over the angle and the axis of its bearing, at the time cursor.

class Field {
  constructor(host, run, lens, page) {
    this.run = run;
    this.lens = lens;
    this.page = page;
    this.seen = -1;
    this.hold = document.createElement("div");
    this.hold.className = "chart field";
    [this.canvas, this.title, this.output] = ["canvas", "b", "output"].map((t) =>
      this.hold.appendChild(document.createElement(t)),
    );
    host.append(this.hold);
    const [across, around] = lens.pressure.shape;
    this.picture = Object.assign(document.createElement("canvas"), {
      width: around + 1,
      height: across,
    });
    const name = page.runs.length > 1 ? `, ${run.label}` : "";
    this.title.textContent = `joint ${lens.joint} film pressure over the bearing${name}`;
  }
  // field last before the cursor
  index() {
    return fieldAt(this.lens, this.run, this.page);
  }
  move() {
    if (this.index() !== this.seen) this.draw();
  }
  draw() {
    const p = this.lens.pressure,
      k = (this.seen = this.index()),
      [across, around] = p.shape,
      scale = p.top[k] / p.largest / 255;
    const inner = this.picture.getContext("2d"),
      image = inner.createImageData(around + 1, across);
    for (let i = 0; i < across; i++)
      for (let j = 0; j <= around; j++) {
        const value = p.steps[(k * across + i) * around + (j % around)] * scale,
          [r, g, b] = shade(value, FILM);
        image.data.set([r, g, b, 255], 4 * ((across - 1 - i) * (around + 1) + j));
      }
    inner.putImageData(image, 0, 0);
    const [g, width, height] = sheet(this.canvas),
      box = {
        x: EDGE.left,
        y: EDGE.top,
        w: width - EDGE.left - EDGE.right - 74,
        h: height - EDGE.top - EDGE.bottom,
      };
    const axial = p.axial.map((z) => 1e3 * z);
    g.imageSmoothingEnabled = true;
    g.drawImage(this.picture, box.x, box.y, box.w, box.h);
    const px = (a) => box.x + (a / 360) * box.w,
      py = (z) => box.y + (box.h * (axial[1] - z)) / (axial[1] - axial[0]);
    marks(g, box, [0, 90, 180, 270, 360], px, axial, py);
    this.bar(g, box, p.largest);
    this.output.textContent = `largest ${reading(1e-6 * p.top[k])} MPa at ${reading(1e3 * p.time[k])} ms`;
  }
  bar(g, box, largest) {
    const x = box.x + box.w + 22,
      steps = 40;
    for (let i = 0; i < steps; i++) {
      g.fillStyle = css(shade((i + 0.5) / steps, FILM));
      g.fillRect(x, box.y + box.h * (1 - (i + 1) / steps), 10, box.h / steps + 0.7);
    }
    g.strokeStyle = "#aaa";
    g.strokeRect(x, box.y, 10, box.h);
    g.fillStyle = "#555";
    g.textAlign = "left";
    g.textBaseline = "middle";
    g.font = SMALL;
    const up = ticks(0, 1e-6 * largest, 3);
    for (const v of up.at)
      g.fillText(printed(v, up.step), x + 14, box.y + box.h * (1 - v / (1e-6 * largest)));
    g.textBaseline = "top";
    g.fillText("MPa", x + 4, box.y + box.h + 5);
  }
}

function marks(g, box, angles, px, axial, py) {
  g.strokeStyle = "#aaa";
  g.lineWidth = 1;
  g.strokeRect(box.x + 0.5, box.y + 0.5, box.w, box.h);
  g.font = SMALL;
  g.fillStyle = "#555";
  g.textAlign = "center";
  g.textBaseline = "top";
  for (const a of angles) g.fillText(`${a}°`, px(a), box.y + box.h + 5);
  g.textAlign = "right";
  g.textBaseline = "middle";
  const up = ticks(...axial, 3);
  for (const z of up.at) g.fillText(printed(z, up.step), box.x - 6, py(z));
  g.save();
  g.translate(14, box.y + box.h / 2);
  g.rotate(-Math.PI / 2);
  g.textAlign = "center";
  g.fillText("axial [mm]", 0, 0);
  g.restore();
}

function fieldAt(lens, run, page) {
  return Math.max(before(lens.pressure.time, run.time_of(page.x, page.kind) * (1 + 1e-12)), 0);
}
