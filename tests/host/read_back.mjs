// Reads an Arrow file with apache-arrow of npm and prints it as JSON. Usage: node read_back.mjs FILE MODULES; ends with 77 where the
// package is not installed.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { join } from "node:path";

let arrow;
try {
  arrow = createRequire(join(process.argv[3], "x.js"))("apache-arrow");
} catch {
  process.exit(77);
}
const table = arrow.tableFromIPC(readFileSync(process.argv[2]));
const text = (v) => {
  if (typeof v !== "number") return v === null ? null : String(v);
  const bits = new DataView(new ArrayBuffer(8));
  bits.setFloat64(0, v);
  return bits.getBigUint64(0).toString(16).padStart(16, "0");
};
const columns = table.schema.fields.map((f) => ({
  name: f.name,
  type: String(f.type),
  values: [...table.getChild(f.name)].map(text),
}));
console.log(JSON.stringify({ rows: table.numRows, metadata: Object.fromEntries(table.schema.metadata), columns }));
