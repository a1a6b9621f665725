// Zigbee2MQTT with a simulated radio: lamps of IKEA in one group, and frames to the group that get lost.
// node lamps.mjs FOLDER BROKER LAMPS LOSS SEED; prints "ready", and in each line what was sent, as JSON.

import { mkdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";

const [folder, server, lamps, loss, seed] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
process.env.ZIGBEE2MQTT_DATA = folder;
const require = createRequire(import.meta.url);
const { Adapter } = require("zigbee-herdsman/dist/adapter/adapter");
const { Zcl } = require("zigbee-herdsman");

const GROUP = 1;
const ieee = (number) => `0x${(0x00158d0000000000n + BigInt(number)).toString(16).padStart(16, "0")}`;
const numbers = Array.from({ length: Number(lamps) }, (_, number) => number + 1);
const state = new Map(numbers.map((number) => [number, { onOff: 0, currentLevel: 254 }]));
let random = Number(seed) * 7919 + 1;
const isLost = () => {
  random = (random * 48271) % 2147483647;
  return random / 2147483647 < Number(loss);
};

const record = (number) => ({
  profId: 260, epId: 1, devId: 257, inClusterList: [0, 3, 4, 5, 6, 8], outClusterList: [25],
  clusters: {}, binds: [], configuredReportings: [], meta: {},
});
const rows = [
  { id: 1000, type: "Coordinator", ieeeAddr: "0x00124b0000000001", nwkAddr: 0, manufId: 0, epList: [1],
    endpoints: { 1: { ...record(0), devId: 5, inClusterList: [], outClusterList: [] } }, interviewCompleted: true, meta: {} },
  ...numbers.map((number) => ({
    id: number, type: "Router", ieeeAddr: ieee(number), nwkAddr: number, manufId: 4476, manufName: "IKEA of Sweden",
    powerSource: "Mains (single phase)", modelId: "TRADFRI bulb E27 WW 806lm", epList: [1], endpoints: { 1: record(number) },
    interviewCompleted: true, interviewState: "SUCCESSFUL", meta: { configured: 1 }, lastSeen: Date.now(),
  })),
  { id: 2000, type: "Group", groupID: GROUP, meta: {},
    members: numbers.map((number) => ({ deviceIeeeAddr: ieee(number), endpointID: 1 })) },
];
writeFileSync(`${folder}/database.db`, rows.map((row) => JSON.stringify(row)).join("\n"));
const devices = numbers.map((number) => `  '${ieee(number)}':\n    friendly_name: lamp_${number}`).join("\n");
writeFileSync(`${folder}/configuration.yaml`, `
version: 5
mqtt: {server: '${server}', base_topic: zigbee2mqtt}
serial: {port: tcp://none:1, adapter: ember}
frontend: {enabled: false}
homeassistant: {enabled: false}
advanced: {network_key: [1,3,5,7,9,11,13,15,0,2,4,6,8,10,12,13], pan_id: 6754, log_output: [console], log_level: error, cache_state: true}
devices:
${devices}
groups:
  '${GROUP}': {friendly_name: living}
`);

class Radio extends Adapter {
  async start() { return "resumed"; }
  async stop() {}
  async getCoordinatorIEEE() { return "0x00124b0000000001"; }
  async getCoordinatorVersion() { return { type: "simulated", meta: {} }; }
  async reset() {}
  async supportsBackup() { return false; }
  async backup() { throw new Error("no backup"); }
  async getNetworkParameters() { return { panID: 6754, extendedPanID: "0xdddddddddddddddd", channel: 11, nwkUpdateID: 0 }; }
  async addInstallCode() {}
  waitFor() { return { promise: new Promise(() => {}), cancel: () => {} }; }
  async sendZdo() { return [0, {}]; }
  async permitJoin() {}
  async sendZclFrameToAll() {}

  async sendZclFrameToEndpoint(_ieee, number, endpoint, frame, _timeout, disableResponse) {
    told({ to: `lamp_${number}`, command: frame.command.name });
    await new Promise((resolve) => setTimeout(resolve, 20));
    const values = state.get(number);
    if (frame.command.name === "read") {
      const found = frame.payload.map(({ attrId }) => ({ attrId, ...valueOf(frame.cluster, attrId, values) }));
      return this.#reply(number, endpoint, frame, "readRsp", found);
    }
    if (frame.header.isSpecific) obey(values, frame);
    return disableResponse ? undefined
      : this.#reply(number, endpoint, frame, "defaultRsp", { cmdId: frame.command.ID, statusCode: 0 });
  }

  async sendZclFrameToGroup(group, frame) {
    const missed = [];
    for (const [number, values] of state) {
      if (isLost()) missed.push(number);
      else obey(values, frame);
    }
    told({ to: `group ${group}`, command: frame.command.name, missed });
  }

  #reply(number, endpoint, frame, command, payload) {
    const made = Zcl.Frame.create(Zcl.FrameType.GLOBAL, Zcl.Direction.SERVER_TO_CLIENT, true, undefined,
      frame.header.transactionSequenceNumber, command, frame.cluster.ID, payload, {});
    const data = made.toBuffer();
    const message = { clusterID: frame.cluster.ID, header: Zcl.Header.fromBuffer(data), address: number, data, endpoint,
      linkquality: 100, groupID: 0, wasBroadcast: false, destinationEndpoint: 1 };
    setImmediate(() => this.emit("zclPayload", message));
    return message;
  }
}

function valueOf(cluster, id, values) {
  const name = Object.values(cluster.attributes).find((one) => one.ID === id)?.name;
  if (name === "onOff") return { status: 0, dataType: Zcl.DataType.BOOLEAN, attrData: values.onOff };
  if (name === "currentLevel") return { status: 0, dataType: Zcl.DataType.UINT8, attrData: values.currentLevel };
  return { status: 0x86 };
}

function obey(values, frame) {
  const { name } = frame.command;
  const { sceneid } = frame.payload;
  if (name === "store") values[`scene ${sceneid}`] = { onOff: values.onOff, currentLevel: values.currentLevel };
  if (name === "recall") Object.assign(values, values[`scene ${sceneid}`]);
  if (name === "on") values.onOff = 1;
  if (name === "off") values.onOff = 0;
  if (name.startsWith("moveToLevel")) {
    values.currentLevel = frame.payload.level;
    if (name.endsWith("WithOnOff")) values.onOff = frame.payload.level > 0 ? 1 : 0;
  }
}

function told(what) {
  console.log(JSON.stringify(what));
}

process.on("SIGUSR2", () => told({ lit: [...state].filter(([, { onOff }]) => onOff).map(([number]) => `lamp_${number}`) }));
Adapter.create = async (...given) => new Radio(...given);
const { Controller } = require("zigbee2mqtt/dist/controller");
const controller = new Controller(() => {}, (code) => process.exit(code));
await controller.start();
told({ ready: true });
