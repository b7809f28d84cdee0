// One of everything that a session's picture takes: the graphics card makes its programs while the models are on their way.

import { BufferAttribute, BufferGeometry, CanvasTexture, Color, Group, Mesh as Drawn, Sprite } from 'three';
import { handDepthMaterial, handMaterial, objectMaterial } from './bodies';
import { sketch } from './dom';
import { Lines } from './lines';
import { dotMaterial, fillMaterial } from './marks';

/** Kept, not disposed of: the programs go with the last material that has them. */
export function samples(): Group {
  const group = new Group();
  const shape = new BufferGeometry();
  shape.setAttribute('position', new BufferAttribute(new Float32Array(9), 3));
  shape.setAttribute('normal', new BufferAttribute(new Float32Array(9), 3));
  shape.setIndex(new BufferAttribute(new Uint32Array([0, 1, 2]), 1));
  for (const material of [objectMaterial(), handDepthMaterial(), handMaterial(), fillMaterial()]) group.add(new Drawn(shape, material));
  const lines = new Lines({ width: 1 });
  lines.set([0, 0, 0, 0, 0, 0], [new Color()]);
  const texture = new CanvasTexture(sketch(96, 96).canvas);
  texture.colorSpace = 'srgb';
  group.add(lines.group, new Sprite(dotMaterial(texture)));
  return group;
}
