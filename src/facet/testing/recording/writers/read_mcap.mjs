// read_mcap.mjs FILE.mcap: reads an uncompressed file through its index by @mcap/core, the reference implementation, and
// its messages by @foxglove/rosmsg2-serialization, with the definitions that the file carries. Prints one line per
// topic: name, type, number of messages, and the first one as JSON. Exit code 77 where a package is missing
// (npm install @mcap/core @foxglove/rosmsg @foxglove/rosmsg2-serialization, and NODE_PATH).
import { createRequire } from "node:module";
import { open } from "node:fs/promises";

const require = createRequire(import.meta.url);
let mcap, rosmsg, serialization;
try {
  mcap = require("@mcap/core");
  rosmsg = require("@foxglove/rosmsg");
  serialization = require("@foxglove/rosmsg2-serialization");
} catch (error) {
  console.log(`a package is missing: ${error.message}`);
  process.exit(77);
}

const handle = await open(process.argv[2]);
const readable = {
  size: async () => BigInt((await handle.stat()).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await handle.read(bytes, 0, Number(length), Number(offset));
    return bytes;
  },
};

const reader = await mcap.McapIndexedReader.Initialize({ readable });
const topics = new Map();
for await (const message of reader.readMessages({ validateCrcs: true })) {
  const channel = reader.channelsById.get(message.channelId);
  const schema = reader.schemasById.get(channel.schemaId);
  let topic = topics.get(channel.topic);
  if (!topic) {
    const definition = rosmsg.parse(new TextDecoder().decode(schema.data), { ros2: true });
    topic = { type: schema.name, num: 0, reader: new serialization.MessageReader(definition) };
    topics.set(channel.topic, topic);
  }
  const content = topic.reader.readMessage(message.data);
  if (topic.num++ === 0) {
    topic.first = JSON.stringify(content, (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value));
  }
}
for (const [name, topic] of [...topics].sort()) {
  console.log(`${name} ${topic.type} ${topic.num} ${topic.first}`);
}
