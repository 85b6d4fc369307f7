// SPDX-License-Identifier: BSD-2-Clause
// Colours that people with any kind of colour vision tell apart: Okabe and Ito's for kinds, viridis for amounts.

export type Rgb = [number, number, number];

const KINDS: Rgb[] = [
  [86, 180, 233], [230, 159, 0], [0, 158, 115], [240, 228, 66], [204, 121, 167], [213, 94, 0], [0, 114, 178],
  [148, 203, 236], [220, 205, 125], [126, 41, 84], [93, 168, 153], [194, 106, 119],
];

export const NO_PLANE: Rgb = [150, 156, 164];

export function planeColour(id: number): Rgb {
  return id < 0 ? NO_PLANE : KINDS[id % KINDS.length]!;
}

export const STAGE_COLOURS = KINDS;

const VIRIDIS: Rgb[] = [
  [68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121],
  [110, 206, 88], [181, 222, 43], [253, 231, 37],
];

/** A colour for an amount from 0 to 1; what is not a number is grey. */
export function amountColour(amount: number): Rgb {
  if (!Number.isFinite(amount)) return NO_PLANE;
  const x = Math.min(Math.max(amount, 0), 1) * (VIRIDIS.length - 1);
  const i = Math.min(Math.floor(x), VIRIDIS.length - 2);
  const a = VIRIDIS[i]!, b = VIRIDIS[i + 1]!, t = x - i;
  return [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])];
}

export function css(colour: Rgb): string {
  return `rgb(${colour.map((c) => Math.round(c)).join(', ')})`;
}

export const AMOUNT_GRADIENT = `linear-gradient(90deg, ${VIRIDIS.map(css).join(', ')})`;

export const SOURCE_COLOURS: [Rgb, Rgb] = [[0, 114, 178], [213, 94, 0]];

export const STATUS_NAMES = ['initialising', 'ok', 'degraded', 'lost'] as const;
export const STATUS_COLOURS: [Rgb, Rgb, Rgb, Rgb] = [[130, 136, 145], [0, 158, 115], [230, 159, 0], [213, 94, 0]];
