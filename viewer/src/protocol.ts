// SPDX-License-Identifier: BSD-2-Clause
// Reads the messages that src/facet/viewer/view_message.h describes.

export const PROTOCOL = 1;

export const MessageType = {
  hello: 1, mesh: 2, mapPart: 3, frames: 4, keyframes: 5, planes: 6, points: 7, image: 8, truth: 9, ended: 10,
} as const;

export const Block = {
  text: 1, positions: 2, normals: 3, colours: 4, faces: 5, planeIds: 6, stamps: 7, poses: 8, motion: 9, sigmas: 10,
  flags: 11, stages: 12, counts: 13, sigma: 14, error: 15, image: 16, pixels: 17, depths: 18, triangles: 19, key: 20,
  ids: 21,
} as const;

type Numbers = Uint8Array | Int8Array | Int32Array | Uint32Array | Float32Array | BigInt64Array;

interface BlockData {
  perRow: number;
  rows: number;
  numbers: Numbers;
}

const HEADER_BYTES = 32;
const BLOCK_HEADER_BYTES = 8;
const MAGIC = 0x56544346; // "FCTV"

const CRC_TABLE = (() => {
  const table = new Uint32Array(256 * 4);
  for (let i = 0; i < 256; i++) {
    let c = i;
    for (let k = 0; k < 8; k++) c = c & 1 ? (c >>> 1) ^ 0xedb88320 : c >>> 1;
    table[i] = c >>> 0;
  }
  for (let i = 0; i < 256; i++) {
    for (let slice = 1; slice < 4; slice++) {
      const c = table[(slice - 1) * 256 + i]!;
      table[slice * 256 + i] = (c >>> 8) ^ table[c & 255]!;
    }
  }
  return table;
})();

/** CRC-32 as in zlib; four bytes at a time, since maps have megabytes. */
export function crc32(bytes: Uint8Array): number {
  const table = CRC_TABLE;
  let crc = 0xffffffff;
  let i = 0;
  for (const end = bytes.length - 3; i < end; i += 4) {
    crc ^= bytes[i]! | (bytes[i + 1]! << 8) | (bytes[i + 2]! << 16) | (bytes[i + 3]! << 24);
    crc = table[768 + (crc & 255)]! ^ table[512 + ((crc >>> 8) & 255)]! ^
      table[256 + ((crc >>> 16) & 255)]! ^ table[crc >>> 24]!;
  }
  for (; i < bytes.length; i++) crc = (crc >>> 8) ^ table[(crc ^ bytes[i]!) & 255]!;
  return (crc ^ 0xffffffff) >>> 0;
}

/** One message; throws an Error that says what is wrong with bytes that are none. */
export class Message {
  readonly type: number;
  readonly source: number;
  readonly index: number;
  readonly stampNs: bigint;
  private readonly blocks = new Map<number, BlockData>();

  constructor(buffer: ArrayBuffer) {
    if (buffer.byteLength < HEADER_BYTES) throw new Error('the message ends in its header');
    const view = new DataView(buffer);
    if (view.getUint32(0, true) !== MAGIC) throw new Error('not a message of Facet');
    const version = view.getUint16(4, true);
    if (version !== PROTOCOL) {
      throw new Error(`the program speaks version ${version} of the protocol, the page ${PROTOCOL}; reload the page`);
    }
    this.type = view.getUint16(6, true);
    this.source = view.getUint16(8, true);
    this.stampNs = view.getBigInt64(16, true);
    this.index = view.getUint32(24, true);
    if (view.getUint32(12, true) !== buffer.byteLength) throw new Error('the message is cut off');
    if (view.getUint32(28, true) !== crc32(new Uint8Array(buffer, HEADER_BYTES))) {
      throw new Error('the message is damaged (checksum)');
    }
    this.readBlocks(buffer, view, view.getUint16(10, true));
  }

  private readBlocks(buffer: ArrayBuffer, view: DataView, count: number): void {
    let at = HEADER_BYTES;
    for (let i = 0; i < count; i++) {
      if (at + BLOCK_HEADER_BYTES > buffer.byteLength) throw new Error('a block is cut off');
      const perRow = view.getUint8(at + 3);
      const rows = view.getUint32(at + 4, true);
      const begin = at + BLOCK_HEADER_BYTES;
      const length = perRow * rows;
      const numbers = numbersOf(view.getUint8(at + 2), buffer, begin, length);
      if (numbers) this.blocks.set(view.getUint16(at, true), { perRow, rows, numbers });
      else throw new Error('a block has numbers of an unknown type');
      at = begin + Math.ceil(numbers.byteLength / 8) * 8;
    }
    if (at !== buffer.byteLength) throw new Error('bytes are left behind the last block');
  }

  rows(name: number): number {
    return this.blocks.get(name)?.rows ?? 0;
  }

  private get<T extends Numbers>(name: number, kind: new (length: number) => T): T {
    const block = this.blocks.get(name);
    if (!block) return new kind(0);
    if (!(block.numbers instanceof kind)) throw new Error(`block ${name} has another type of numbers`);
    return block.numbers;
  }
  floats(name: number): Float32Array { return this.get(name, Float32Array); }
  uint32(name: number): Uint32Array { return this.get(name, Uint32Array); }
  int32(name: number): Int32Array { return this.get(name, Int32Array); }
  bytes(name: number): Uint8Array { return this.get(name, Uint8Array); }
  signedBytes(name: number): Int8Array { return this.get(name, Int8Array); }
  stamps(name: number): BigInt64Array { return this.get(name, BigInt64Array); }
  text(): string { return new TextDecoder().decode(this.bytes(Block.text)); }
  json<T>(): T { return JSON.parse(this.text()) as T; }
}

function numbersOf(type: number, buffer: ArrayBuffer, begin: number, length: number): Numbers | null {
  const bytes = [0, 1, 1, 4, 4, 4, 8][type] ?? 0;
  if (begin + bytes * length > buffer.byteLength) throw new Error('a block is cut off');
  switch (type) {
    case 1: return new Uint8Array(buffer, begin, length);
    case 2: return new Int8Array(buffer, begin, length);
    case 3: return new Int32Array(buffer, begin, length);
    case 4: return new Uint32Array(buffer, begin, length);
    case 5: return new Float32Array(buffer, begin, length);
    case 6: return new BigInt64Array(buffer, begin, length);
    default: return null;
  }
}
