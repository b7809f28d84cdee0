// types_test.mjs PACKAGES SOURCES: TypeScript finds nothing wrong in the page. Without the compiler: 77.

import { spawnSync } from 'node:child_process';
import { existsSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';

const [packages, sources] = process.argv.slice(2).map((path) => resolve(path));
const compiler = join(packages, 'node_modules/typescript/bin/tsc');
if (!existsSync(compiler)) {
  console.log('skipped: typescript is not installed');
  process.exit(77);
}
// Packages lie in the build's folder, the sources do not.
const config = join(packages, 'tsconfig.json');
writeFileSync(
  config,
  JSON.stringify({
    extends: join(sources, 'tsconfig.json'),
    compilerOptions: {
      baseUrl: packages,
      paths: {
        three: ['node_modules/@types/three'],
        'three/*': ['node_modules/@types/three/*'],
        '*': ['node_modules/*'],
      },
      typeRoots: [join(packages, 'node_modules/@types')],
      types: [],
    },
    include: [join(sources, 'src')],
  }),
);
const checked = spawnSync(process.execPath, [compiler, '--project', config], { stdio: 'inherit' });
process.exit(checked.status ?? 1);
