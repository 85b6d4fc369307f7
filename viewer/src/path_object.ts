// SPDX-License-Identifier: BSD-2-Clause
// The trajectory: what was flown up to the moment that is shown, the rest of it, keyframes, 3-sigma ellipsoids, truth.
import {
  BufferAttribute, BufferGeometry, Color, Group, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4, MeshBasicMaterial,
  Object3D, Points, PointsMaterial, Quaternion, SphereGeometry, SRGBColorSpace, Vector3,
} from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import type { CameraShape, Frames, StampedPoses } from './model';
import { amountColour } from './palette';

const MAX_ELLIPSOIDS = 60;
const NUM_SIGMAS = 3;

export interface PathColours {
  past: number;
  future: number;
  keyframe: number;
  truth: number;
  frustum: number;
}

export class PathObject {
  readonly group = new Group();
  readonly line = new Group();
  readonly keyframes: Points<BufferGeometry, PointsMaterial>;
  readonly truth = new Group();
  readonly frustum: LineSegments<BufferGeometry, LineBasicMaterial>;
  ellipsoids: InstancedMesh | null = null;
  readonly ellipsoidGroup = new Group();
  private past: Line2 | null = null;
  private future: Line<BufferGeometry, LineBasicMaterial> | null = null;
  /** Number of line segments up to a frame, by frame. */
  private segmentsUpTo: Uint32Array = new Uint32Array(0);
  private readonly pastMaterial: LineMaterial;

  constructor(private readonly colours: PathColours) {
    this.pastMaterial = new LineMaterial({ color: colours.past, linewidth: 3 });
    this.keyframes = new Points(
      new BufferGeometry(),
      new PointsMaterial({ color: colours.keyframe, size: 4, sizeAttenuation: false }),
    );
    this.frustum = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: colours.frustum }));
    this.frustum.frustumCulled = false;
    this.group.add(this.line, this.keyframes, this.truth, this.frustum, this.ellipsoidGroup);
  }

  /** Frames with a distance to the truth [m] are coloured by it, from 0 to the largest; without errors all are alike. */
  setFrames(frames: Frames, errors: Float32Array, largestError: number): void {
    const points: number[] = [], colours: number[] = [];
    this.segmentsUpTo = new Uint32Array(frames.count);
    for (let i = 0; i < frames.count; i++) {
      const f = frames.at(i)!;
      if (f.hasPose) {
        points.push(f.pose[0]!, f.pose[1]!, f.pose[2]!);
        const [r, g, b] = amountColour(errors.length > 0 ? errors[i]! / Math.max(largestError, 1e-9) : NaN);
        colours.push(...new Color().setRGB(r / 255, g / 255, b / 255, SRGBColorSpace).toArray());
      }
      this.segmentsUpTo[i] = Math.max(points.length / 3 - 1, 0);
    }
    this.past?.geometry.dispose();
    this.future?.geometry.dispose();
    this.future?.material.dispose();
    this.line.clear();
    this.past = this.future = null;
    if (points.length < 6) return;
    const geometry = new LineGeometry();
    geometry.setPositions(points);
    geometry.setColors(colours);
    this.past = new Line2(geometry, this.pastMaterial);
    this.past.frustumCulled = false;
    const rest = new BufferGeometry();
    rest.setAttribute('position', new BufferAttribute(Float32Array.from(points), 3));
    this.future = new Line(rest, new LineBasicMaterial({ color: this.colours.future, transparent: true, opacity: 0.6 }));
    this.future.frustumCulled = false;
    this.line.add(this.past, this.future);
    this.setEllipsoids(frames);
  }

  private setEllipsoids(frames: Frames): void {
    if (this.ellipsoids) {
      this.ellipsoids.geometry.dispose();
      (this.ellipsoids.material as MeshBasicMaterial).dispose();
      this.ellipsoids.dispose();
    }
    this.ellipsoidGroup.clear();
    const step = Math.max(1, Math.ceil(frames.count / MAX_ELLIPSOIDS));
    const matrices: Matrix4[] = [];
    for (let i = 0; i < frames.count; i += step) {
      const f = frames.at(i)!;
      const s = f.sigmas;
      if (!f.hasPose || !Number.isFinite(s[0]! + s[1]! + s[2]!)) continue;
      const size = [0, 1, 2].map((k) => Math.max(NUM_SIGMAS * s[k]!, 1e-3)) as [number, number, number];
      matrices.push(new Matrix4().compose(
        new Vector3(f.pose[0], f.pose[1], f.pose[2]), new Quaternion(), new Vector3(...size),
      ));
    }
    const material = new MeshBasicMaterial({
      color: this.colours.past, transparent: true, opacity: 0.25, depthWrite: false,
    });
    this.ellipsoids = new InstancedMesh(new SphereGeometry(1, 16, 12), material, matrices.length);
    matrices.forEach((m, i) => this.ellipsoids!.setMatrixAt(i, m));
    this.ellipsoids.frustumCulled = false;
    this.ellipsoidGroup.add(this.ellipsoids);
  }

  /** Everything up to a frame is flown. */
  setCurrent(index: number): void {
    const segments = this.segmentsUpTo[Math.min(index, this.segmentsUpTo.length - 1)] ?? 0;
    if (this.past) this.past.geometry.instanceCount = segments;
  }

  /** Of the path up to the moment, 0 to 255 as the screen shows them; empty where it has one colour. */
  coloursShown(): number[][] {
    if (!this.past || !this.pastMaterial.vertexColors) return [];
    const start = this.past.geometry.getAttribute('instanceColorStart');
    return Array.from({ length: this.segmentsShown }, (_, i) => {
      const c = new Color(start.getX(i), start.getY(i), start.getZ(i)).convertLinearToSRGB();
      return c.toArray().map((x) => Math.round(255 * x));
    });
  }

  get segmentsShown(): number {
    return this.past ? this.past.geometry.instanceCount : 0;
  }

  setKeyframes(keyframes: StampedPoses): void {
    const positions = positionsOf(keyframes);
    this.keyframes.geometry.dispose(); // frees the buffer that is replaced
    this.keyframes.geometry.setAttribute('position', new BufferAttribute(positions, 3));
    this.keyframes.frustumCulled = false;
  }

  setTruth(truth: StampedPoses): void {
    this.truth.traverse((o) => (o instanceof Line ? (o.geometry as BufferGeometry).dispose() : undefined));
    this.truth.clear();
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positionsOf(truth), 3));
    const line = new Line(geometry, new LineBasicMaterial({ color: this.colours.truth }));
    line.frustumCulled = false;
    this.truth.add(line);
  }

  /** The camera's view as a pyramid of the given depth [m]. */
  setFrustum(pose: ArrayLike<number>, camera: CameraShape | undefined, depth: number): void {
    const toWorld = bodyMatrix(pose);
    if (camera) toWorld.multiply(bodyMatrix(camera.T_BC0));
    const w = camera?.width ?? 752, h = camera?.height ?? 480;
    const [fx, fy] = camera?.focal ?? [460, 460];
    const [cx, cy] = camera?.centre ?? [w / 2, h / 2];
    const corner = (x: number, y: number): Vector3 =>
      new Vector3((depth * (x - cx)) / fx, (depth * (y - cy)) / fy, depth).applyMatrix4(toWorld);
    const eye = new Vector3().applyMatrix4(toWorld);
    const c = [corner(0, 0), corner(w, 0), corner(w, h), corner(0, h)];
    const up = [corner(w * 0.4, 0), corner(w * 0.5, -h * 0.15), corner(w * 0.6, 0)];
    const lines: Vector3[] = [];
    for (let i = 0; i < 4; i++) lines.push(eye, c[i]!, c[i]!, c[(i + 1) % 4]!);
    lines.push(up[0]!, up[1]!, up[1]!, up[2]!);
    this.frustum.geometry.dispose();
    this.frustum.geometry = new BufferGeometry().setFromPoints(lines);
  }

  /** The path by its distance to the truth, or all of it in the colour of its result. */
  set byError(byError: boolean) {
    if (this.pastMaterial.vertexColors === byError) return;
    this.pastMaterial.vertexColors = byError;
    this.pastMaterial.color.set(byError ? 0xffffff : this.colours.past);
    this.pastMaterial.needsUpdate = true;
  }

  setResolution(width: number, height: number): void {
    this.pastMaterial.resolution.set(width, height);
  }
}

export function bodyMatrix(pose: ArrayLike<number>): Matrix4 {
  return new Matrix4().compose(
    new Vector3(pose[0], pose[1], pose[2]),
    new Quaternion(pose[4], pose[5], pose[6], pose[3]),
    new Vector3(1, 1, 1),
  );
}

function positionsOf(poses: StampedPoses): Float32Array {
  const n = poses.stamps.length;
  const positions = new Float32Array(3 * n);
  for (let i = 0; i < n; i++) for (let k = 0; k < 3; k++) positions[3 * i + k] = poses.poses[7 * i + k]!;
  return positions;
}

/** Frees what an object and its children hold on the graphics card. */
export function disposeAll(object: Object3D): void {
  object.traverse((o) => {
    const mesh = o as { geometry?: BufferGeometry; material?: { dispose(): void } };
    mesh.geometry?.dispose();
    mesh.material?.dispose();
  });
  object.removeFromParent();
}
