// SPDX-License-Identifier: BSD-2-Clause
// From where a camera sees a whole scene.
import { Box3, Vector3 } from 'three';

/** How far from their centre, in a direction, a camera that looks there has all points in its picture, with a margin. */
export function distanceToSee(fromCentre: Vector3[], direction: Vector3, halfAngle: number, aspect: number): number {
  const MARGIN = 1.08, CLOSEST = 1;
  const right = new Vector3(0, 0, 1).cross(direction).normalize(), up = direction.clone().cross(right);
  const tall = Math.tan(halfAngle) / MARGIN, wide = tall * aspect;
  return fromCentre.reduce((distance, p) => {
    const needed = Math.max(Math.abs(p.dot(right)) / wide, Math.abs(p.dot(up)) / tall);
    return Math.max(distance, p.dot(direction) + needed);
  }, CLOSEST);
}

/** Adds points of a mesh, but not a few strays, which would push the scene into the distance. */
export function addSamples(samples: Vector3[], positions: Float32Array): void {
  const n = positions.length / 3, step = Math.max(1, Math.floor(n / 3000));
  const points: Vector3[] = [];
  for (let i = 0; i < n; i += step) points.push(new Vector3().fromArray(positions, 3 * i));
  if (n === 0) return;
  const limits = (['x', 'y', 'z'] as const).map((axis) => {
    const values = points.map((p) => p[axis]).sort((a, b) => a - b);
    return [values[Math.floor(0.02 * (values.length - 1))]!, values[Math.ceil(0.98 * (values.length - 1))]!] as const;
  });
  const box = new Box3(
    new Vector3(...limits.map((l) => l[0]) as [number, number, number]),
    new Vector3(...limits.map((l) => l[1]) as [number, number, number]));
  samples.push(...points.filter((p) => box.containsPoint(p)));
}
