// Writes the MCAP files of this folder by @mcap/core (npm install @mcap/core), from the messages of
// plain.db3: run write_bags.py before. Chunks are compressed by the program zstd.
import { McapWriter } from "@mcap/core";
import { execFileSync } from "node:child_process";
import { openSync, writeSync, closeSync } from "node:fs";

const sql = (query) =>
  execFileSync("sqlite3", ["plain.db3", query], { encoding: "utf8", maxBuffer: 1 << 26 })
    .trim().split("\n").map((line) => line.split("|"));
const topics = sql("select id, name, type from topics");
const messages = sql("select topic_id, timestamp, hex(data) from messages order by id");

async function write(name, options) {
  const file = openSync(name, "w");
  let at = 0n;
  const writer = new McapWriter({
    writable: {
      position: () => at,
      write: async (bytes) => { writeSync(file, bytes); at += BigInt(bytes.length); },
    },
    chunkSize: 4000,
    ...options,
  });
  await writer.start({ profile: "ros2", library: "@mcap/core" });
  const channels = new Map();
  for (const [id, topic, type] of topics) {
    const schemaId = await writer.registerSchema(
      { name: type, encoding: "ros2msg", data: new TextEncoder().encode("# " + type) });
    channels.set(id, await writer.registerChannel(
      { topic, schemaId, messageEncoding: "cdr", metadata: new Map([["offered_qos_profiles", ""]]) }));
  }
  for (const [id, time, hex] of messages) {
    await writer.addMessage({ channelId: channels.get(id), sequence: 0, logTime: BigInt(time),
                              publishTime: BigInt(time), data: Buffer.from(hex, "hex") });
  }
  await writer.end();
  closeSync(file);
}

const by = (compression, ...options) => ({
  compressChunk: (data) => ({
    compression,
    compressedData: execFileSync("zstd", ["-q", "-c", ...options], { input: data }),
  }),
});
await write("plain.mcap", { useChunks: false });
await write("chunks.mcap", {});
await write("lz4.mcap", by("lz4", "--format=lz4"));
await write("zstd.mcap", by("zstd"));
