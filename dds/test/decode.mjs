// decode.mjs FILE: the messages of a file that dds_peer has written, read by @foxglove/rosmsg2-serialization with the
// definitions of ROS 2 Humble that @foxglove/rosmsg-msgs-common carries. Prints a line for each topic: its name, its
// type, how many messages there were, and the last of them as JSON. Exit code 77 where a package is missing
// (`npm ci` in dds/test installs them).
import { readFile } from "node:fs/promises";

let common, serialization;
try {
  common = (await import("@foxglove/rosmsg-msgs-common")).default;
  serialization = await import("@foxglove/rosmsg2-serialization");
} catch (error) {
  console.log(`a package is missing: ${error.message}`);
  process.exit(77);
}

// The message and all that it contains, itself first.
function definitions(name) {
  const found = [];
  const open = [name.replace("/msg/", "/")];
  const seen = new Set(open);
  while (open.length > 0) {
    const own = open.shift();
    const definition = common.ros2humble[own];
    if (definition == undefined) throw new Error(`no definition of ${own}`);
    found.push(definition);
    for (const field of definition.definitions) {
      if (!field.isComplex || seen.has(field.type)) continue;
      seen.add(field.type);
      open.push(field.type);
    }
  }
  return found;
}

const { MessageReader } = serialization.default ?? serialization;
const data = await readFile(process.argv[2]);
const topics = new Map();
let place = 0;
function part() {
  const size = data.readUInt32LE(place);
  place += 4 + size;
  if (place > data.length) return undefined;
  return data.subarray(place - size, place);
}
while (place + 8 < data.length) {
  place += 8;
  const [topic, type, bytes] = [part(), part(), part()];
  if (bytes == undefined) break;
  const name = topic.toString();
  if (!topics.has(name)) {
    topics.set(name, { type: type.toString(), num: 0, reader: new MessageReader(definitions(type.toString())) });
  }
  const entry = topics.get(name);
  // Aligned: the reader looks at numbers in place.
  entry.last = entry.reader.readMessage(new Uint8Array(bytes));
  ++entry.num;
}
const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
for (const [name, { type, num, last }] of [...topics].sort()) {
  console.log(`${name} ${type} ${num} ${JSON.stringify(last, plain)}`);
}
