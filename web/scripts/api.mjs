// Types of the API, from the document that the server's tests keep as a snapshot.
// `node scripts/api.mjs` writes src/api/schema.ts; with `--check` it only says whether that file is stale.
import { readFile, writeFile } from "node:fs/promises";
import openapiTS, { astToString } from "openapi-typescript";

const SNAPSHOT = new URL("../../server/tests/suite/snapshots/suite__routes__openapi.snap", import.meta.url);
const SCHEMA = new URL("../src/api/schema.ts", import.meta.url);
const HEAD = "// Written by `npm run api` from the server's OpenAPI document; do not edit.\n\n";

const snapshot = await readFile(SNAPSHOT, "utf8");
const document = JSON.parse(snapshot.slice(snapshot.indexOf("\n{")));
const schema = HEAD + astToString(await openapiTS(document, { emptyObjectsUnknown: true }));

if (process.argv.includes("--check")) {
  const committed = await readFile(SCHEMA, "utf8").catch(() => "");
  if (committed !== schema) {
    console.error("src/api/schema.ts is not of the server's present OpenAPI document; run `npm run api` and commit it");
    process.exit(1);
  }
} else {
  await writeFile(SCHEMA, schema);
}
