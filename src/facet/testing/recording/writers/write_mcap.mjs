// write_mcap.mjs OUT.mcap [CHUNK_SIZE]: an MCAP file by @mcap/core, the reference implementation; for write_mcap.py.
// Exit code 77 where @mcap/core is missing (npm install @mcap/core, and NODE_PATH).
import { createRequire } from "node:module";
import { open } from "node:fs/promises";
import { createInterface } from "node:readline";

// Modules that are imported are not sought in NODE_PATH, those that are required are.
const require = createRequire(import.meta.url);
let mcap;
try {
  mcap = require("@mcap/core");
} catch (error) {
  console.log(`no @mcap/core: ${error.message}`);
  process.exit(77);
}

class FileWritable {
  constructor(handle) {
    this.handle = handle;
    this.size = 0;
  }
  async write(buffer) {
    await this.handle.writeFile(buffer);
    this.size += buffer.byteLength;
  }
  position() {
    return BigInt(this.size);
  }
}

// Lines of JSON on the standard input: {topic, type, stamp, data in base64}.
const [out, chunkSize] = process.argv.slice(2);
const file = await open(out, "w");
const writer = new mcap.McapWriter({
  writable: new FileWritable(file),
  useChunks: chunkSize !== "0",
  chunkSize: Number(chunkSize ?? 1 << 20),
});
await writer.start({ profile: "ros2", library: "facet test" });
const channels = new Map();
let sequence = 0;
for await (const line of createInterface({ input: process.stdin })) {
  const message = JSON.parse(line);
  if (!channels.has(message.topic)) {
    const schemaId = await writer.registerSchema({
      name: message.type,
      encoding: "ros2msg",
      data: new TextEncoder().encode(""),
    });
    channels.set(
      message.topic,
      await writer.registerChannel({
        schemaId,
        topic: message.topic,
        messageEncoding: "cdr",
        metadata: new Map(),
      }),
    );
  }
  await writer.addMessage({
    channelId: channels.get(message.topic),
    sequence: sequence++,
    logTime: BigInt(message.stamp),
    publishTime: BigInt(message.stamp),
    data: Buffer.from(message.data, "base64"),
  });
}
await writer.end();
await file.close();
