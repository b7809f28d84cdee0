// Files that somebody drops on the page or chooses: folders and zips looked through, and told apart by what they are.

import { unzipSync } from 'fflate';

/** By its path among those that were given with it: "hand/meshes/palm.stl". */
export interface GivenFile {
  path: string;
  file: Blob;
}

export type Kind = 'hand' | 'object' | 'contacts';

/** What of the files is one model. */
export interface Given {
  kind: Kind;
  mains: string[]; // of which one is read first; the likeliest before the others
  files: GivenFile[];
}

const kMeshes = ['glb', 'gltf', 'obj', 'ply', 'stl', 'dae'];
// Of folders and zips nothing else is taken along; which of them a model may use, the gateway says.
const kTaken = new Set([...kMeshes, 'urdf', 'xacro', 'srdf', 'yaml', 'bin', 'json']);
const kMostFiles = 2000;
const kMostBytes = 256 * 2 ** 20;
const kDeepest = 32;
const kHead = 8192; // bytes that say what a file is

export const typeOf = (path: string): string => /\.([^./]+)$/.exec(path)?.[1]?.toLowerCase() ?? '';
const isJunk = (path: string) => path.split('/').some((part) => part.startsWith('.') || part === '__MACOSX');
const inMiB = (bytes: number) => `${(bytes / 2 ** 20).toFixed(0)} MiB`;

class Gathering {
  readonly files: GivenFile[] = [];
  private bytes = 0;

  add(path: string, file: Blob): void {
    this.take(path, file.size);
    this.files.push({ path, file });
  }

  /** Room for one more. */
  take(path: string, bytes: number): void {
    this.bytes += bytes;
    if (this.files.length >= kMostFiles) throw new Error(`${path}: more than ${kMostFiles} files; drop the hand's own folder`);
    if (this.bytes > kMostBytes) throw new Error(`${path}: with it ${inMiB(this.bytes)}; permitted are ${inMiB(kMostBytes)}`);
  }
}

/** What lies in a zip. Names that lead out of it are refused, not mended. */
async function unzip(name: string, zip: Blob, to: Gathering): Promise<void> {
  if (zip.size > kMostBytes) throw new Error(`${name}: ${inMiB(zip.size)}; permitted are ${inMiB(kMostBytes)}`);
  let bytes = 0;
  let count = 0;
  let inside: Record<string, Uint8Array>;
  try {
    inside = unzipSync(new Uint8Array(await zip.arrayBuffer()), {
      filter: (entry) => {
        const path = entry.name.replaceAll('\\', '/');
        if (path.startsWith('/') || /^[a-z]:/i.test(path) || path.split('/').includes('..')) {
          throw new RangeError(`“${entry.name}” leads out of it; nothing of it is read`);
        }
        if (path.endsWith('/') || isJunk(path) || !kTaken.has(typeOf(path))) return false;
        bytes += entry.originalSize;
        if (bytes > kMostBytes) throw new RangeError(`“${entry.name}”: with it ${inMiB(bytes)} unpacked; permitted are ${inMiB(kMostBytes)}`);
        if (++count > kMostFiles) throw new RangeError(`more than ${kMostFiles} files`);
        return true;
      },
    });
  } catch (error) {
    throw new Error(`${name}: ${error instanceof RangeError ? error.message : 'it cannot be unpacked'}`);
  }
  const folder = name.replace(/\.zip$/i, '');
  for (const [path, content] of Object.entries(inside)) {
    to.add(`${folder}/${path.replaceAll('\\', '/')}`, new Blob([content as Uint8Array<ArrayBuffer>]));
  }
}

async function addFile(path: string, file: File, isAlone: boolean, to: Gathering): Promise<void> {
  if (isAlone && typeOf(path) === 'zip') await unzip(path, file, to);
  else if (isAlone || (!isJunk(path) && kTaken.has(typeOf(path)))) to.add(path, file);
}

async function addEntry(entry: FileSystemEntry, path: string, depth: number, to: Gathering): Promise<void> {
  if (entry.isFile) {
    const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
    await addFile(path, file, depth === 0, to);
    return;
  }
  if (depth >= kDeepest || (depth > 0 && isJunk(entry.name))) return;
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    // A hundred at a time, until there are no more.
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return;
    for (const one of some) await addEntry(one, `${path}/${one.name}`, depth + 1, to);
  }
}

/** What was dropped. Called while the drop's event lasts: later, it names nothing any more. */
export async function dropped(transfer: DataTransfer): Promise<GivenFile[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  const to = new Gathering();
  for (const entry of entries) await addEntry(entry, entry.name, 0, to);
  return to.files;
}

/** What was chosen, of a folder or not. */
export async function chosen(list: FileList): Promise<GivenFile[]> {
  const to = new Gathering();
  for (const file of list) await addFile(file.webkitRelativePath || file.name, file, file.webkitRelativePath === '', to);
  return to.files;
}

const byDepth = (a: string, b: string) => a.split('/').length - b.split('/').length || (a < b ? -1 : 1);

/** Where that kind is wanted: the same files, with what of them is to be read first. */
export function asKind(kind: Kind, files: GivenFile[]): Given {
  const types = { hand: ['urdf', 'xacro'], object: kMeshes, contacts: ['json', ...kMeshes] }[kind];
  const rank = (path: string) => types.indexOf(typeOf(path));
  const mains = files
    .map((one) => one.path)
    .filter((path) => rank(path) >= 0)
    .sort((a, b) => (kind === 'hand' ? rank(a) - rank(b) : 0) || byDepth(a, b));
  // A single one is what was meant, whatever it is called: the server says what it thinks of it.
  if (mains.length === 0 && files.length === 1) mains.push(files[0]!.path);
  if (mains.length === 0) {
    const wanted = { hand: 'a URDF (.urdf) with its meshes', object: `a mesh (${kMeshes.map((type) => `.${type}`).join(' ')})`, contacts: 'contacts (.json) or a contact map (.ply)' };
    throw new Error(`There is no ${wanted[kind].slice(kind === 'contacts' ? 0 : 2)} among ${files.length === 0 ? 'these files' : `the ${files.length} files`}.`);
  }
  return { kind, mains, files };
}

/** The session that was saved, if one of these is. */
export async function savedSession(files: GivenFile[]): Promise<GivenFile | undefined> {
  for (const one of files) {
    if (typeOf(one.path) === 'json' && (await one.file.slice(0, kHead).text()).includes('"handgraft-session/1"')) return one;
  }
  return undefined;
}

/** Which models these files are. */
export async function sorted(files: GivenFile[]): Promise<Given[]> {
  if (files.length === 0) throw new Error('There is no file among them that can be read here.');
  const given: Given[] = [];
  const hands = files.filter(({ path }) => ['urdf', 'xacro'].includes(typeOf(path)));
  const folders = hands.map(({ path }) => path.split('/')[0]!);
  const isLoose = hands.some(({ path }) => !path.includes('/'));
  // What lies in the hand's folder is the hand's; where its URDF was given without one, all folders are.
  const isOfHand = (path: string) => path.includes('/') && (isLoose || folders.includes(path.split('/')[0]!));
  if (hands.length > 0) given.push(asKind('hand', files.filter(({ path }) => isOfHand(path) || !path.includes('/'))));
  const others = files.filter(({ path }) => !isOfHand(path) && !['urdf', 'xacro', 'srdf', 'yaml'].includes(typeOf(path)));
  const contacts: GivenFile[] = [];
  const objects: GivenFile[] = [];
  for (const one of others) ((await isContacts(one)) ? contacts : objects).push(one);
  if (objects.some(({ path }) => kMeshes.includes(typeOf(path)))) given.push(asKind('object', objects));
  if (contacts.length > 0) given.push(asKind('contacts', contacts));
  if (given.length === 0) given.push(asKind('object', files));
  return given;
}

/** A contact set, or a mesh that has a value for each vertex which says how warm it was. */
async function isContacts({ path, file }: GivenFile): Promise<boolean> {
  if (typeOf(path) === 'json') return true;
  if (typeOf(path) !== 'ply') return false;
  const head = await file.slice(0, kHead).text();
  return /^property\s+\S+\s+(contact|label|link)\s*$/m.test(head.split('end_header')[0]!);
}
