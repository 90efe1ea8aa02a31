// node run.mjs MODULE.wasm SCENE.fray: the probe in WebAssembly. Prints what examples/checksum.rs prints.
import { readFileSync } from "node:fs";

const [modulePath, scenePath] = process.argv.slice(2);
if (!scenePath) {
  console.error("usage: node run.mjs MODULE.wasm SCENE.fray");
  process.exit(2);
}

const module = new WebAssembly.Module(readFileSync(modulePath));
console.log(`imports=${WebAssembly.Module.imports(module).length}`);
const { exports: flashray } = new WebAssembly.Instance(module);

// Lend the module the blob.
const blob = readFileSync(scenePath);
const at = flashray.scene_reserve(blob.length) >>> 0;
if (at === 0) throw new Error("no memory");
new Uint8Array(flashray.memory.buffer, at, blob.length).set(blob);
const rule = flashray.scene_load(blob.length);
console.log(`check=${rule === 0 ? "ok" : rule}`);
if (rule !== 0) process.exit(1);

// 8,192 rays, all inside the module.
const crc = flashray.probe_crc() >>> 0;
console.log(`crc=0x${crc.toString(16).padStart(8, "0")}`);
console.log(`hits=${flashray.probe_hits()}`);

// One ray from here: { origin, dir } to { t, u, v, prim }, or null.
function closestHit({ origin, dir, tMin = 0, tMax = Infinity }) {
  const view = new DataView(flashray.memory.buffer, flashray.query_address(), 48);
  [...origin, tMin, ...dir, tMax].forEach((x, i) => view.setFloat32(4 * i, x, true));
  if (!flashray.closest_hit()) return null;
  const [t, u, v] = [32, 36, 40].map((offset) => view.getFloat32(offset, true));
  return { t, u, v, prim: view.getUint32(44, true) };
}

// A ray outwards from far away meets nothing, and so does one without a direction.
const away = closestHit({ origin: [1e9, 1e9, 1e9], dir: [1, 1, 1] });
const nowhere = closestHit({ origin: [0, 0, 0], dir: [0, 0, 0] });
console.log(`misses=${[away, nowhere].filter((hit) => hit === null).length}`);
