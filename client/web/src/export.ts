// Saving: the picture, the link, the session, the page itself.

import { save } from './dom';
import type { PageData } from './link';
import type { Session } from './session';
import type { Stage } from './stage';

// Of what the file holds, and of nothing else.
const kPolicy =
  '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; script-src \'unsafe-inline\'; style-src \'unsafe-inline\'; img-src data: blob:" />';

export type Format = 'png' | 'link' | 'html' | 'session' | 'json' | 'csv' | 'glb';

export async function saveAs(format: Format, session: Session, stage: Stage): Promise<void> {
  const state = session.state;
  const name = state === null ? 'handgraft' : `${state.hand}_${state.object}`;
  switch (format) {
    case 'png': {
      const blob = await stage.png();
      if (blob !== null) save(blob, `${name}.png`);
      return;
    }
    case 'link':
      await navigator.clipboard.writeText(location.href);
      session.notify('The link is in the clipboard.');
      return;
    case 'html':
      save(new Blob([await pageOf(session)], { type: 'text/html' }), `${name}.html`);
      return;
    case 'session': {
      const reply = await session.link.ask<{ text: string }>({ kind: 'save_session', session: { session_id: session.id } });
      save(new Blob([reply.text], { type: 'application/json' }), `${name}.session.json`);
      return;
    }
    default: {
      const reply = await session.link.ask<{ content: string }>({
        kind: 'export',
        export_file: { session_id: session.id, format },
      });
      const bytes = reply.content.match(/../g) ?? [];
      save(new Blob([Uint8Array.from(bytes, (pair) => parseInt(pair, 16))]), `${name}.${format}`);
    }
  }
}

function base64(frame: ArrayBuffer): string {
  const bytes = new Uint8Array(frame);
  let text = '';
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

/** This page and all that it shows, in one file (client/gateway/page_file.cpp writes the same). */
async function pageOf(session: Session): Promise<string> {
  const models = session.models;
  if (session.state === null || session.solution === null || models === null) throw new Error('there is no pose yet');
  const [html, script, style] = await Promise.all(['/', '/page.js', '/page.css'].map(async (path) => (await fetch(path)).text()));
  const data: PageData = {
    state: session.state,
    solution: session.solution,
    settings: session.settings,
    transfer: { patches: session.reports },
    models: {
      hand: base64(models.hand.frame),
      object: base64(models.object.frame),
      [session.motion === null ? 'contacts' : 'motion']: base64(models.contacts.frame),
    },
    past: session.past,
  };
  if (session.motion !== null) {
    const { frames, revision } = session.motion;
    data.solution = null;
    data.motion_frames = { frames, revision, frame_count: frames.length };
  }
  const json = JSON.stringify(data).replaceAll('<', '\\u003c');
  // Functions: what is put in is not read for $ signs.
  return html!
    .replace('<link rel="stylesheet" href="page.css" />', () => `${kPolicy}<style>${style}</style>`)
    .replace('<script src="early.js" async></script>', '')
    .replace('<script type="module" src="page.js"></script>', () => {
      return `<script type="application/json" id="handgraft-data">${json}</script>\n<script type="module">${script!.replaceAll('</script', '<\\/script')}</script>`;
    });
}
