// What Foxglove's and Lichtblick's rosbridge player does, by their libraries, at the door of the port given.
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { WebSocket } from "ws";

globalThis.WebSocket = WebSocket; // as in a browser
const { default: roslib } = await import("@foxglove/roslibjs");

const ros = new roslib.Ros({ url: `ws://127.0.0.1:${process.argv[2]}`, transportLibrary: "websocket" });
ros.on("error", (error) => console.error(error.message ?? error));
await new Promise((resolve) => ros.on("connection", resolve));
const { topics, types, typedefs_full_text: texts } = await new Promise((resolve, reject) =>
  ros.getTopicsAndRawTypes(resolve, reject),
);
const told = {};
for (const name of process.argv.slice(3)) {
  const place = topics.indexOf(name);
  const reader = new MessageReader(parse(texts[place], { ros2: true }));
  const topic = new roslib.Topic({ ros, name, messageType: types[place], compression: "cbor-raw" });
  const raw = await new Promise((resolve) => topic.subscribe(resolve));
  const message = reader.readMessage(raw.bytes);
  const plain = (_, value) =>
    ArrayBuffer.isView(value) ? Array.from(value, Number) : typeof value === "bigint" ? Number(value) : value;
  told[name] = JSON.parse(JSON.stringify(message, plain));
  topic.unsubscribe();
}
console.log(JSON.stringify(told));
process.exit();
