// SPDX-License-Identifier: BSD-2-Clause
// Distances between two points that the user picks, or from a plane to a point.
import { Vector3 } from 'three';
import type { Model, Plane } from './model';
import type { Hit } from './stage';

export type MeasureMode = 'off' | 'points' | 'plane';

export interface Measurement {
  points: Vector3[];
  text: string;
  /** [m]; signed for planes, positive on the side of the normal; null until all is picked. */
  distance: number | null;
}

export class Measure {
  mode: MeasureMode = 'off';
  plane: Plane | null = null;
  private first: Vector3 | null = null;

  constructor(private readonly model: Model) {}

  setMode(mode: MeasureMode): Measurement {
    this.mode = mode;
    this.first = null;
    this.plane = null;
    const text = { off: '', points: 'Pick a point on the mesh.', plane: 'Pick a plane: its faces or its label.' }[mode];
    return { points: [], text, distance: null };
  }

  setPlane(plane: Plane): Measurement {
    this.plane = plane;
    return { points: [], text: `Plane ${plane.id}, ${plane.label}. Pick a point.`, distance: null };
  }

  add(hit: Hit): Measurement {
    if (this.mode === 'plane') return this.addToPlane(hit);
    if (!this.first) {
      this.first = hit.point.clone();
      return { points: [hit.point], text: `${at(hit.point)}. Pick another point.`, distance: null };
    }
    const a = this.first, b = hit.point, d = b.clone().sub(a);
    this.first = null;
    return {
      points: [a, b],
      distance: d.length(),
      text: `${metres(d.length())} apart; level ${metres(Math.hypot(d.x, d.y))}, height ${metres(d.z)}`,
    };
  }

  private addToPlane(hit: Hit): Measurement {
    if (!this.plane) {
      const plane = this.model.sources[hit.source]?.planes.find((p) => p.id === hit.planeId);
      if (!plane) return { points: [], text: 'There is no plane here. Pick a coloured face or a label.', distance: null };
      return this.setPlane(plane);
    }
    const n = new Vector3(...this.plane.n);
    const distance = n.dot(hit.point) - this.plane.d;
    const foot = hit.point.clone().addScaledVector(n, -distance);
    const sigma = this.plane.sigma_d_m > 0 ? ` ± ${(100 * this.plane.sigma_d_m).toFixed(1)} cm (plane, 1σ)` : '';
    return {
      points: [foot, hit.point],
      distance,
      text: `${metres(distance)}${sigma} from plane ${this.plane.id}, ${this.plane.label}`,
    };
  }
}

function metres(x: number): string {
  return Math.abs(x) < 1 ? `${(100 * x).toFixed(1)} cm` : `${x.toFixed(3)} m`;
}

function at(p: Vector3): string {
  return `x ${p.x.toFixed(2)}, y ${p.y.toFixed(2)}, z ${p.z.toFixed(2)} m`;
}
