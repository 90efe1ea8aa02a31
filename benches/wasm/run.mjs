// node run.mjs ROUNDS LABEL=MODULE.wasm .. -- NAME=SCENE.fray .. -- KIND=FILE.rays ..: rows of the table of benches/wasm.sh.
import { readFileSync } from "node:fs";
import { cpuUsage } from "node:process";

const [rounds, ...rest] = process.argv.slice(2);
const lists = [[], [], []];
let list = 0;
for (const argument of rest) {
  if (argument === "--") list += 1;
  else lists[list].push(argument.split(/=(.*)/s).slice(0, 2));
}
const [modules, scenes, rays] = lists;

// Every module with every blob, in an instance of its own.
const runs = [];
for (const [name, path] of scenes) {
  const blob = readFileSync(path);
  for (const [label, module] of modules) {
    const { exports } = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(module)));
    const put = (bytes) => {
      const at = exports.room(bytes.length) >>> 0;
      if (at === 0) throw new Error("no memory");
      new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
      return at;
    };
    // A module may be older than a structure.
    if (!exports.load(put(blob), blob.length)) continue;
    for (const [kind, file] of rays) {
      const bytes = readFileSync(file);
      const [at, count] = [put(bytes), bytes.length / 32];
      for (const query of ["closest", "any"]) runs.push({ name, label, kind, query, at, count, call: exports[query], ns: [] });
    }
  }
}
// In turns; the first round only warms up.
for (let round = 0; round <= Number(rounds); round++) {
  for (const run of runs) {
    // Time on the processor: other programs wait for theirs, too.
    const start = cpuUsage();
    run.hits = run.call(run.at, run.count);
    const { user, system } = cpuUsage(start);
    if (round > 0) run.ns.push(((user + system) * 1000) / run.count);
  }
}
const median = (all) => all.toSorted((a, b) => a - b)[all.length >> 1];
for (const query of ["closest", "any"]) {
  for (const [name] of scenes) {
    for (const [label] of modules) {
      const row = runs.filter((run) => run.name === name && run.label === label && run.query === query);
      if (row.length > 0) console.log(`| ${name} | ${label} | ${query} | ${row.map((run) => median(run.ns).toFixed(0)).join(" | ")} |`);
    }
  }
}
// All modules and structures must agree.
for (const [kind] of rays) {
  const counts = new Set(runs.filter((run) => run.kind === kind).map((run) => run.hits));
  if (counts.size > 1) throw new Error(`${kind}: ${[...counts].join(", ")} hits`);
}
