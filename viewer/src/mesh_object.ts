// SPDX-License-Identifier: BSD-2-Clause
// A mesh of the model as an object of the scene, coloured by what the user chose.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, FrontSide, Mesh as ThreeMesh, MeshLambertMaterial, Sphere, Vector3,
} from 'three';
import type { Mesh } from './model';
import { amountColour, NO_PLANE, planeColour, type Rgb, SOURCE_COLOURS } from './palette';

export type Colouring = 'plane' | 'normal' | 'height' | 'image' | 'age' | 'sigma' | 'error' | 'source';

/** What amounts are compared with: where the colours begin and end. */
export interface ColourRange {
  low: number;
  high: number;
}

/** Vertices of faces on different planes are split, so that a plane's colour ends where the plane does. */
interface SplitMesh {
  faces: Uint32Array;
  origin: Uint32Array; // vertex of the mesh, by split vertex
  plane: Int32Array; // by split vertex
}

function split(mesh: Mesh): SplitMesh {
  const numVertices = mesh.positions.length / 3;
  const origin: number[] = Array.from({ length: numVertices }, (_, i) => i);
  const plane = new Array<number>(numVertices).fill(-2); // -2: not used yet
  const others = new Map<number, number>(); // (vertex, plane) to its copy
  const faces = new Uint32Array(mesh.faces.length);
  const hasPlanes = mesh.planeIds.length > 0;
  for (let i = 0; i < faces.length; i++) {
    const vertex = mesh.faces[i]!;
    const id = hasPlanes ? mesh.planeIds[Math.floor(i / 3)]! : -1;
    if (plane[vertex] === -2) plane[vertex] = id;
    if (plane[vertex] === id) {
      faces[i] = vertex;
      continue;
    }
    const key = (id + 1) * numVertices + vertex;
    let copy = others.get(key);
    if (copy === undefined) {
      copy = origin.length;
      origin.push(vertex);
      plane.push(id);
      others.set(key, copy);
    }
    faces[i] = copy;
  }
  return { faces, origin: Uint32Array.from(origin), plane: Int32Array.from(plane) };
}

/**
 * Vertices in one cell of a grid become the first of them, and faces that keep three corners stay. A cell's side is
 * that many edges of a face long.
 */
function cluster(positions: Float32Array, faces: Uint32Array, edgesPerCell: number): Uint32Array {
  const CELLS = 131072;
  const SHIFT = 0.37; // floors and walls often lie at round coordinates: not between two layers of cells
  let sum = 0, count = 0;
  const step = 3 * Math.max(1, Math.floor(faces.length / 3 / 1000));
  for (let f = 0; f < faces.length; f += step) {
    const a = 3 * faces[f]!, b = 3 * faces[f + 1]!;
    sum += Math.hypot(
      positions[a]! - positions[b]!, positions[a + 1]! - positions[b + 1]!, positions[a + 2]! - positions[b + 2]!);
    count++;
  }
  const cell = (edgesPerCell * sum) / Math.max(count, 1);
  if (!(cell > 0)) return faces;
  const first = new Map<number, number>(); // vertex, by cell
  const chosen = new Uint32Array(positions.length / 3);
  for (let v = 0; v < chosen.length; v++) {
    let key = 0;
    for (let k = 0; k < 3; k++) {
      key = key * CELLS + Math.floor(positions[3 * v + k]! / cell + SHIFT) + CELLS / 2;
    }
    const known = first.get(key);
    if (known === undefined) first.set(key, v);
    chosen[v] = known ?? v;
  }
  const coarse: number[] = [];
  for (let f = 0; f < faces.length; f += 3) {
    const a = chosen[faces[f]!]!, b = chosen[faces[f + 1]!]!, c = chosen[faces[f + 2]!]!;
    if (a !== b && b !== c && c !== a) coarse.push(a, b, c);
  }
  return Uint32Array.from(coarse);
}

export class MeshObject {
  readonly object: ThreeMesh<BufferGeometry, MeshLambertMaterial>;
  private readonly parts: SplitMesh;
  private readonly colours: Uint8Array;
  private readonly full: BufferGeometry;
  private coarse: { edgesPerCell: number; geometry: BufferGeometry } | null = null;

  constructor(readonly mesh: Mesh, readonly source: number) {
    this.parts = split(mesh);
    const n = this.parts.origin.length;
    const positions = new Float32Array(3 * n);
    const normals = new Int8Array(4 * n);
    for (let i = 0; i < n; i++) {
      const from = this.parts.origin[i]!;
      for (let k = 0; k < 3; k++) positions[3 * i + k] = mesh.positions[3 * from + k]!;
      for (let k = 0; k < 3; k++) normals[4 * i + k] = mesh.normals[4 * from + k] ?? 0;
    }
    this.colours = new Uint8Array(4 * n).fill(255);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new BufferAttribute(normals, 4, true));
    geometry.setAttribute('color', new BufferAttribute(this.colours, 4, true));
    geometry.setIndex(new BufferAttribute(this.parts.faces, 1));
    if (n > 0) geometry.computeBoundingSphere();
    else geometry.boundingSphere = new Sphere(new Vector3(), 0);
    this.full = geometry;
    const material = new MeshLambertMaterial({ vertexColors: true, side: FrontSide });
    if (mesh.normals.length === 0) material.flatShading = true;
    this.object = new ThreeMesh(geometry, material);
    this.object.userData['owner'] = this;
  }

  planeOfFace(face: number): number {
    return this.mesh.planeIds[face] ?? -1;
  }

  set bothSides(both: boolean) {
    this.object.material.side = both ? DoubleSide : FrontSide;
    this.object.material.needsUpdate = true;
  }

  /**
   * Fewer and larger faces over the same vertices, for a picture in motion; zero edges per cell: all faces. The first
   * time with other cells takes a while.
   */
  setCoarse(edgesPerCell: number): void {
    if (edgesPerCell > 0 && this.coarse?.edgesPerCell !== edgesPerCell) {
      this.disposeCoarse();
      const geometry = new BufferGeometry();
      for (const [name, attribute] of Object.entries(this.full.attributes)) geometry.setAttribute(name, attribute);
      const positions = this.full.getAttribute('position').array as Float32Array;
      geometry.setIndex(new BufferAttribute(cluster(positions, this.parts.faces, edgesPerCell), 1));
      geometry.boundingSphere = this.full.boundingSphere;
      this.coarse = { edgesPerCell, geometry };
    }
    this.object.geometry = edgesPerCell > 0 ? this.coarse!.geometry : this.full;
  }

  /** Its attributes are those of all faces, and stay. */
  private disposeCoarse(): void {
    if (!this.coarse) return;
    for (const name of Object.keys(this.coarse.geometry.attributes)) this.coarse.geometry.deleteAttribute(name);
    this.coarse.geometry.dispose();
    this.coarse = null;
  }

  recolour(colouring: Colouring, range: ColourRange): void {
    const attribute = this.full.getAttribute('color');
    const linear = LINEAR;
    for (let i = 0; i < this.parts.origin.length; i++) {
      const colour = this.colourOf(i, colouring, range);
      for (let k = 0; k < 3; k++) this.colours[4 * i + k] = linear[Math.round(colour[k]!)]!;
    }
    attribute.needsUpdate = true;
  }

  private colourOf(i: number, colouring: Colouring, range: ColourRange): Rgb {
    const from = this.parts.origin[i]!;
    const amount = (value: number | undefined): Rgb =>
      amountColour(((value ?? NaN) - range.low) / (range.high - range.low));
    switch (colouring) {
      case 'plane': return planeColour(this.parts.plane[i]!);
      case 'source': return SOURCE_COLOURS[this.source] ?? NO_PLANE;
      case 'height': return amount(this.mesh.positions[3 * from + 2]);
      case 'age': return amount(Number(this.mesh.stampNs / 1000000n) / 1e3);
      case 'sigma': return amount(this.mesh.sigma[from]);
      case 'error': return amount(this.mesh.error[from]);
      case 'image': {
        const c = this.mesh.colours;
        return c.length > 0 ? [c[4 * from]!, c[4 * from + 1]!, c[4 * from + 2]!] : NO_PLANE;
      }
      case 'normal': {
        const n = this.mesh.normals;
        return [0, 1, 2].map((k) => 127.5 + (n[4 * from + k] ?? 0)) as Rgb;
      }
    }
  }

  dispose(): void {
    this.object.removeFromParent();
    this.disposeCoarse();
    this.full.dispose();
    this.object.material.dispose();
  }
}

/** The scene is lit in linear light; the palette is what the screen shows. */
const LINEAR = Uint8Array.from({ length: 256 }, (_, i) => {
  const c = new Color(i / 255, 0, 0).convertSRGBToLinear().r;
  return Math.round(255 * c);
});
