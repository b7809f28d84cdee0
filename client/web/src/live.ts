// Where the gateway listens, and what was begun there before the page was read.

export interface Early {
  socket: WebSocket;
  session: number; // 0: none was asked for
  heard: (string | ArrayBuffer)[];
}

/** `session`: that is shown at once; 0: none. */
export function liveAddress(session = 0): string {
  const token = new URLSearchParams(location.hash.slice(1)).get('token');
  const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
  const asked = [token ? `token=${encodeURIComponent(token)}` : '', session > 0 ? `session=${session}` : ''].filter((one) => one !== '');
  return `${scheme}://${location.host}/live${asked.length > 0 ? `?${asked.join('&')}` : ''}`;
}

/** Once; none where it is gone already. */
export function takeEarly(): Early | null {
  const page = globalThis as unknown as { handgraftEarly?: Early };
  const early = page.handgraftEarly;
  delete page.handgraftEarly;
  return early !== undefined && early.socket.readyState <= WebSocket.OPEN ? early : null;
}
