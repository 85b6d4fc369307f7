// SPDX-License-Identifier: BSD-2-Clause
// What is known of the run, or of the two results: plain data that the messages fill and the page draws.
import { Block, Message, MessageType } from './protocol';

export interface Plane {
  id: number;
  n: [number, number, number];
  d: number;
  centre: [number, number, number];
  orientation: string;
  label: string;
  area_m2: number;
  sigma_normal_rad: number;
  sigma_d_m: number;
  landmarks: number;
  outline: [number, number, number][];
}

export interface CameraShape {
  T_BC0: number[]; // p, q (wxyz)
  width: number;
  height: number;
  focal: [number, number];
  centre: [number, number];
}

export interface SourceHello {
  name: string;
  summary?: Record<string, unknown>;
  evaluation?: Record<string, unknown>;
  downloads: string[];
  horizon?: { stamp_ns: string; name: string }[];
  images?: number; // how many images of the recording can be asked for
  camera?: CameraShape;
}

export interface Hello {
  mode: 'live' | 'finished';
  stages: string[];
  sources: SourceHello[];
  history?: number; // how often a live run has thinned its frames
}

export interface Mesh {
  positions: Float32Array;
  normals: Int8Array;
  colours: Uint8Array;
  faces: Uint32Array;
  planeIds: Int32Array;
  sigma: Float32Array;
  error: Float32Array;
  stampNs: bigint;
}

interface FrameGroup {
  stamps: BigInt64Array;
  poses: Float32Array;
  motion: Float32Array;
  sigmas: Float32Array;
  flags: Uint32Array;
  stages: Float32Array;
  counts: Float32Array;
  reasons: Record<string, string>;
}

export interface Frame {
  stampNs: bigint;
  hasPose: boolean;
  isKeyframe: boolean;
  status: number;
  segment: number;
  pose: Float32Array; // p, q (wxyz)
  motion: Float32Array; // v, b_g, b_a
  sigmas: Float32Array; // p, theta, v, b_g, b_a
  stages: Float32Array;
  counts: Float32Array; // wall ms, latency ms, landmarks, planes, constraints
  reason: string;
}

const GROUP = 64;

/** The frames in order of time; the program sends them in groups of 64. */
export class Frames {
  private groups: FrameGroup[] = [];
  numStages = 0;

  get count(): number {
    const last = this.groups[this.groups.length - 1];
    return last ? (this.groups.length - 1) * GROUP + last.stamps.length : 0;
  }

  set(m: Message): void {
    const group: FrameGroup = {
      stamps: m.stamps(Block.stamps),
      poses: m.floats(Block.poses),
      motion: m.floats(Block.motion),
      sigmas: m.floats(Block.sigmas),
      flags: m.uint32(Block.flags),
      stages: m.floats(Block.stages),
      counts: m.floats(Block.counts),
      reasons: m.json<Record<string, string>>(),
    };
    const n = group.stamps.length;
    if (group.poses.length !== 7 * n || group.flags.length !== n || group.sigmas.length !== 15 * n) {
      throw new Error('a group of frames has columns of different lengths');
    }
    if (m.index > this.groups.length) return; // what is before it comes again
    this.numStages = n > 0 ? group.stages.length / n : this.numStages;
    this.groups.length = Math.max(this.groups.length, m.index + 1);
    this.groups[m.index] = group;
  }

  clear(): void {
    this.groups = [];
  }

  at(i: number): Frame | undefined {
    const g = this.groups[Math.floor(i / GROUP)];
    const row = i % GROUP;
    if (i < 0 || !g || row >= g.stamps.length) return undefined;
    const flags = g.flags[row]!;
    return {
      stampNs: g.stamps[row]!,
      hasPose: (flags & 1) !== 0,
      isKeyframe: (flags & 2) !== 0,
      status: (flags >> 8) & 3,
      segment: flags >>> 16,
      pose: g.poses.subarray(7 * row, 7 * row + 7),
      motion: g.motion.subarray(9 * row, 9 * row + 9),
      sigmas: g.sigmas.subarray(15 * row, 15 * row + 15),
      stages: g.stages.subarray(this.numStages * row, this.numStages * (row + 1)),
      counts: g.counts.subarray(5 * row, 5 * row + 5),
      reason: g.reasons[String(row)] ?? '',
    };
  }

  stampNs(i: number): bigint {
    return this.groups[Math.floor(i / GROUP)]?.stamps[i % GROUP] ?? 0n;
  }

  /** The last frame at or before a moment; 0 before the first. */
  indexAt(stampNs: bigint): number {
    let low = 0, high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.stampNs(middle) <= stampNs) low = middle;
      else high = middle - 1;
    }
    return Math.max(low, 0);
  }
}

export interface StampedPoses {
  stamps: BigInt64Array;
  poses: Float32Array;
}

export interface CameraImage {
  jpeg: Uint8Array;
  pixels: Float32Array;
  depths: Float32Array;
  triangles: Uint32Array;
  planeIds: Int32Array; // by triangle; empty: not known
  of: string; // what the triangles are of; empty: between tracks
  stampNs: bigint;
}

/** Distance of each frame's position to the true one of the same stamp [m]; nan where that is not known. */
function errorsAlong(frames: Frames, truth: StampedPoses | null): Float32Array {
  const errors = new Float32Array(frames.count).fill(NaN);
  if (!truth) return errors;
  let k = 0;
  for (let i = 0; i < errors.length; i++) {
    const f = frames.at(i)!;
    while (k < truth.stamps.length && truth.stamps[k]! < f.stampNs) k++;
    if (!f.hasPose || truth.stamps[k] !== f.stampNs) continue;
    errors[i] = Math.hypot(...[0, 1, 2].map((axis) => f.pose[axis]! - truth.poses[7 * k + axis]!));
  }
  return errors;
}

/** One result, or the live run. */
export class Source {
  hello: SourceHello = { name: '', downloads: [] };
  readonly frames = new Frames();
  readonly meshes = new Map<string, Mesh>(); // 'map', 'horizon', and 'map:x,y,z' for its parts
  keyframes: StampedPoses | null = null;
  truth: StampedPoses | null = null;
  errors = new Float32Array(0); // by frame
  largestError = 0;
  planes: Plane[] = [];
  points = new Float32Array(0);
  image: CameraImage | null = null;

  /** After frames or the truth have come. */
  updateErrors(): void {
    this.errors = errorsAlong(this.frames, this.truth);
    this.largestError = this.errors.reduce((most, e) => (e > most ? e : most), 0);
  }
}

export type Change =
  | 'hello' | 'mesh' | 'frames' | 'keyframes' | 'truth' | 'planes' | 'points' | 'image' | 'ended' | 'reset';

export class Model {
  mode: 'live' | 'finished' = 'finished';
  stages: string[] = [];
  sources: Source[] = [];
  ended: { code: number; message: string } | null = null;
  numMessages = 0;
  private history = 0;

  /** Throws an Error where the message contradicts itself. */
  apply(m: Message): { change: Change; source: number; mesh?: string } {
    this.numMessages++;
    if (m.type === MessageType.hello) return this.applyHello(m);
    const source = this.sources[m.source];
    if (!source) throw new Error(`a message belongs to result ${m.source}, which there is not`);
    const at = { source: m.source };
    switch (m.type) {
      case MessageType.mesh: {
        const name = m.index === 0 ? 'map' : 'horizon';
        source.meshes.set(name, meshOf(m));
        return { change: 'mesh', mesh: name, ...at };
      }
      case MessageType.mapPart: {
        const name = `map:${m.int32(Block.key).join(',')}`;
        const mesh = meshOf(m);
        if (mesh.faces.length > 0) source.meshes.set(name, mesh);
        else source.meshes.delete(name);
        return { change: 'mesh', mesh: name, ...at };
      }
      case MessageType.frames:
        source.frames.set(m);
        return { change: 'frames', ...at };
      case MessageType.keyframes:
      case MessageType.truth: {
        const poses = { stamps: m.stamps(Block.stamps), poses: m.floats(Block.poses) };
        if (m.type === MessageType.truth) source.truth = poses;
        else source.keyframes = poses;
        return { change: m.type === MessageType.truth ? 'truth' : 'keyframes', ...at };
      }
      case MessageType.planes:
        source.planes = m.json<Plane[]>();
        return { change: 'planes', ...at };
      case MessageType.points:
        source.points = m.floats(Block.positions);
        return { change: 'points', ...at };
      case MessageType.image:
        source.image = imageOf(m);
        return { change: 'image', ...at };
      case MessageType.ended:
        this.ended = m.json<{ code: number; message: string }>();
        return { change: 'ended', ...at };
      default:
        return { change: 'hello', ...at }; // a type of a later program
    }
  }

  private applyHello(m: Message): { change: Change; source: number } {
    const hello = m.json<Hello>();
    // The same run again after a broken connection: what is there stays until it is replaced.
    const isSame = hello.mode === this.mode && hello.sources.length === this.sources.length &&
      hello.sources.every((s, i) => s.name === this.sources[i]!.hello.name);
    this.mode = hello.mode;
    this.stages = hello.stages;
    if (!isSame) {
      this.sources = hello.sources.map(() => new Source());
      this.ended = null;
    }
    // The program has thinned the frames; all of them come again.
    if ((hello.history ?? 0) !== this.history) this.sources.forEach((s) => s.frames.clear());
    this.history = hello.history ?? 0;
    hello.sources.forEach((s, i) => (this.sources[i]!.hello = s));
    return { change: isSame ? 'hello' : 'reset', source: 0 };
  }

  /** Of all sources, so that their paths have the same colours [m]. */
  get largestError(): number {
    return Math.max(0, ...this.sources.map((s) => s.largestError));
  }

  /** From the first to the last frame of any source [ns]. */
  range(): [bigint, bigint] {
    let first = 0n, last = 0n, any = false;
    for (const { frames } of this.sources) {
      if (frames.count === 0) continue;
      const a = frames.stampNs(0), b = frames.stampNs(frames.count - 1);
      first = any && first < a ? first : a;
      last = any && last > b ? last : b;
      any = true;
    }
    return [first, last];
  }
}

export function imageOf(m: Message): CameraImage {
  return {
    jpeg: m.bytes(Block.image),
    pixels: m.floats(Block.pixels),
    depths: m.floats(Block.depths),
    triangles: m.uint32(Block.triangles),
    planeIds: m.int32(Block.planeIds),
    of: m.text(),
    stampNs: m.stampNs,
  };
}

export function meshOf(m: Message): Mesh {
  const mesh: Mesh = {
    positions: m.floats(Block.positions),
    normals: m.signedBytes(Block.normals),
    colours: m.bytes(Block.colours),
    faces: m.uint32(Block.faces),
    planeIds: m.int32(Block.planeIds),
    sigma: m.floats(Block.sigma),
    error: m.floats(Block.error),
    stampNs: m.stampNs,
  };
  const numVertices = mesh.positions.length / 3;
  for (const corner of mesh.faces) {
    if (corner >= numVertices) throw new Error(`a face has corner ${corner} of ${numVertices} vertices`);
  }
  if (mesh.planeIds.length > 0 && mesh.planeIds.length !== mesh.faces.length / 3) {
    throw new Error('a mesh has not one plane for each face');
  }
  return mesh;
}
