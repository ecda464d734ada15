// Runs the numbers of a page that computes without a browser: prints rows, and the time they took.
import fs from "node:fs";

const text = fs.readFileSync(process.argv[2], "utf8");
const element = (id) => text.match(new RegExp(`id="${id}">([^<]*)<`))[1];
const nothing = () => ({ dataset: {}, append() {}, prepend() {}, replaceChildren() {} });
const script = text.match(/<script>([\s\S]*)<\/script>/)[1];
const part = (from, to) => script.slice(script.indexOf(from), script.indexOf(to));
const code = `
const $ = (id) => ({ get textContent() { return element(id); }, ...nothing() });
const SIZES = new Map();
${part("const FACTS", "const KINDS")}
${part("const KINDS", "async function inflated")}
${part("async function inflated", "// place of x among")}
${part("const FINEST", "if (FACTS.live)")}
const document = { createElement: nothing };
return (async () => {
  const live = new Live({});
  await live.start();
  const run = new Run(FACTS.runs[0], await inflated(0));
  const changes = JSON.parse(process.argv[3]);
  FACTS.live.sliders.forEach((s, i) => { if (s.name in changes) live.values[i] = changes[s.name]; });
  const count = run.clock.time.length;
  live.rows(count);
  const start = performance.now(), rows = live.rows(count), took = performance.now() - start;
  live.put(run, rows);
  const x = [...run.channel("joints/B/eccentricity_x").at];
  return { took, time: [...run.clock.time], x, size: [...run.channel("joints/B/force").at],
    turn: run.turn, clearance: run.lenses[0].clearance, path: [...run.lenses[0].path[0]] };
})();`;
const answer = await new Function("element", "nothing", "process", code)(element, nothing, process);
console.log(JSON.stringify(answer));
