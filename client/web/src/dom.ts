// Elements, in one line each.

type Children = (Node | string | null)[];
type Props = Record<string, unknown>;

/** `on...` are listeners, `class` and `aria-...` attributes, everything else properties. */
export function h<Tag extends keyof HTMLElementTagNameMap>(tag: Tag, props: Props = {}, ...children: Children): HTMLElementTagNameMap[Tag] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (value === undefined || value === null) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value as EventListener);
    else if (name === 'class' || name === 'role' || name.includes('-')) element.setAttribute(name, String(value));
    else if (name === 'style') for (const [key, css] of Object.entries(value as Record<string, string>)) element.style.setProperty(key, css);
    else (element as unknown as Props)[name] = value;
  }
  element.append(...children.filter((child): child is Node | string => child !== null));
  return element;
}

/** Drawn with strokes, 24 by 24. */
export function icon(path: string): SVGSVGElement {
  const space = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(space, 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  const line = document.createElementNS(space, 'path');
  line.setAttribute('d', path);
  svg.append(line);
  return svg;
}

/** To draw labels on. Not by the graphics card, which would be waited for. */
export function sketch(width: number, height: number): CanvasRenderingContext2D {
  return h('canvas', { width, height }).getContext('2d', { willReadFrequently: true })!;
}

export function save(blob: Blob, name: string): void {
  const link = h('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
