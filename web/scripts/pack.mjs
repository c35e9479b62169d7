// Writes the gzipped twin of every text of the page, and fails if a first visit loads more than 80 kB.
import { readdir, readFile, writeFile } from "node:fs/promises";
import { gzipSync } from "node:zlib";

const LIMIT = 80_000;
const DIST = new URL("../dist/", import.meta.url);

const entries = await readdir(DIST, { recursive: true, withFileTypes: true });
const files = entries.filter((entry) => entry.isFile() && !entry.name.startsWith(".") && !entry.name.endsWith(".gz"));
let total = 0;
for (const { parentPath, name } of files) {
  const bytes = await readFile(`${parentPath}/${name}`);
  const packed = name.endsWith(".woff2") ? bytes : gzipSync(bytes, { level: 9 });
  if (packed !== bytes) await writeFile(`${parentPath}/${name}.gz`, packed);
  total += packed.length;
}
console.log(`a first visit loads ${(total / 1000).toFixed(1)} kB, of at most ${LIMIT / 1000} kB`);
process.exit(total > LIMIT ? 1 : 0);
