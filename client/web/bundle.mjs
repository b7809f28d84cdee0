// bundle.mjs OUT: the page as index.html, early.js, page.js and page.css, and each of them gzipped; what the page
// does not use of its libraries is left out. Run where package.json and node_modules are.

import { mkdirSync, readFileSync, writeFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));
const { build } = createRequire(join(process.cwd(), 'package.json'))('esbuild');
const out = resolve(process.argv[2] ?? 'dist');

const result = await build({
  entryPoints: { page: join(here, 'src/main.ts'), early: join(here, 'src/early.ts') },
  bundle: true,
  minify: true,
  format: 'esm',
  target: 'es2022',
  legalComments: 'none',
  nodePaths: [join(process.cwd(), 'node_modules')],
  outdir: out,
  write: false,
  logLevel: 'warning',
});
const style = await build({
  entryPoints: { page: join(here, 'src/page.css') },
  bundle: true,
  minify: true,
  nodePaths: [join(process.cwd(), 'node_modules')],
  outdir: out,
  write: false,
  logLevel: 'warning',
});
const files = new Map([
  ['index.html', readFileSync(join(here, 'index.html'))],
  ...['early.js', 'page.js'].map((name) => [name, Buffer.from(result.outputFiles.find((file) => file.path.endsWith(`/${name}`)).contents)]),
  ['page.css', Buffer.from(style.outputFiles[0].contents)],
]);
// The licences of what is bundled go along with it.
const licences = ['three', 'three-mesh-bvh', 'camera-controls', 'uplot', 'fflate'].map((name) => {
  const text = readFileSync(join(process.cwd(), 'node_modules', name, 'LICENSE'), 'utf8');
  return `=== ${name}\n\n${text}\n`;
});
files.set('licences.txt', Buffer.from(licences.join('\n')));

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
let total = 0;
for (const [name, bytes] of files) {
  writeFileSync(join(out, name), bytes);
  const zipped = gzipSync(bytes, { level: 9 });
  writeFileSync(join(out, `${name}.gz`), zipped);
  if (name !== 'licences.txt') total += zipped.length;
}
console.log(`the page: ${(total / 1000).toFixed(0)} kB gzipped`);
