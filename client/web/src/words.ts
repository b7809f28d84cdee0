// What the server calls an edit, as people say it.

const kWays: [RegExp, string][] = [
  [/^root (\S+) (hand|object)$/, 'laid $1 elsewhere on the $2'],
  [/^dir (\S+) (hand|object) ([+-])(\S+)deg$/, 'turned $1 on the $2 by $3$4°'],
  [/^drag (\S+)(?: to .*)?$/, 'moved $1'],
  [/^release all$/, 'let go of all'],
  [/^release (\S+)$/, 'let go of $1'],
  [/^enable (\S+)$/, 'switched $1 on'],
  [/^disable (\S+)$/, 'switched $1 off'],
  [/^weight (\S+) (\S+)$/, 'weighed $1 by $2'],
  [/^limit (\S+) .*$/, 'limited $1'],
  [/^lock (\S+)$/, 'locked $1'],
  [/^unlock (\S+)$/, 'unlocked $1'],
  [/^undo( \d+)?$/, 'undid'],
  [/^redo( \d+)?$/, 'did again'],
  [/^restore (\S+)$/, 'went back to $1'],
  [/^snapshot (\S+)$/, 'kept $1'],
  [/^weights .*$/, 'changed what counts'],
  [/^soft (\S+) off$/, 'let go of $1'],
  [/^soft (\S+) .*$/, 'bent $1'],
  [/^take back \d+$/, 'took an edit at a time back'],
];

const kAlways_s = 1e5; // longer than any motion

/** Unknown ones as they are. */
export function said(edit: string): string {
  const timed = /^(.*) at (\S+) s(?: \+- (\S+)(?: s)?)?$/.exec(edit);
  if (timed !== null) return `${said(timed[1]!)} ${Number(timed[3] ?? 0) >= kAlways_s ? 'all the time' : `at ${timed[2]} s`}`;
  if (edit.startsWith('choose minimum ')) return `took solution ${Number(edit.slice('choose minimum '.length)) + 1}`;
  const way = kWays.find(([pattern]) => pattern.test(edit));
  return way === undefined ? edit : edit.replace(way[0], way[1]);
}

/** "guest 2 switched thumb off". */
export function saidBy(editor: string, edit: string): string {
  const words = said(edit);
  return words === edit ? `${editor}: ${edit}` : `${editor} ${words}`;
}
