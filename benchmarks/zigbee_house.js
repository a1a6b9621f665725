// Prints what Zigbee2MQTT retains for a house with one device of each model: a JSON list of topic and payload a line.
// `node zigbee_house.js DIRECTORY EACH`: where the npm package zigbee2mqtt is installed, and 1 for every model, 2 for
// every second one. The program itself makes the messages; only its radio and its broker are replaced.
"use strict";

const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");

const BASE = "zigbee2mqtt";
const [directory, each] = process.argv.slice(2);
const load = (name) => require(path.join(path.resolve(directory), "node_modules", name));
const data = fs.mkdtempSync(path.join(os.tmpdir(), "zigbee2mqtt-"));
process.env.ZIGBEE2MQTT_DATA = data;
const CONFIGURATION = {
    version: 5,
    homeassistant: { enabled: true },
    availability: { enabled: true },
    mqtt: { server: "mqtt://127.0.0.1", base_topic: BASE },
    serial: { port: "none" },
    advanced: { log_output: [] },
};
fs.writeFileSync(path.join(data, "configuration.yaml"), JSON.stringify(CONFIGURATION)); // JSON is YAML
const settings = load("zigbee2mqtt/dist/util/settings.js");
settings.reRead();
load("zigbee2mqtt/dist/util/logger.js").default.init();

const { prepareDefinition } = load("zigbee-herdsman-converters");
const models = load("zigbee-herdsman-converters/dist/devices/index.js").default;
const { default: Device } = load("zigbee2mqtt/dist/model/device.js");
const { default: Bridge } = load("zigbee2mqtt/dist/extension/bridge.js");
const { default: HomeAssistant } = load("zigbee2mqtt/dist/extension/homeassistant.js");

class Endpoint {
    meta = {};
    binds = [];
    configuredReportings = [];
    inputClusters = [];
    outputClusters = [];

    constructor(ID, deviceIeeeAddress) {
        Object.assign(this, { ID, deviceIeeeAddress });
    }

    getInputClusters() {
        return [];
    }

    getOutputClusters() {
        return [];
    }

    supportsInputCluster() {
        return true;
    }

    supportsOutputCluster() {
        return true;
    }

    getClusterAttributeValue() {
        return undefined;
    }
}

function makeDevice(model, number) {
    const definition = prepareDefinition(model);
    const ieeeAddr = `0x00158d${number.toString(16).padStart(10, "0")}`;
    const zh = {
        ieeeAddr,
        isDummyDevice: true,
        type: "Router",
        networkAddress: number % 65_000,
        interviewState: "SUCCESSFUL",
        modelID: model.zigbeeModel?.[0] ?? model.fingerprint?.[0]?.modelID,
        manufacturerName: model.vendor,
        powerSource: "Mains (single phase)",
        dateCode: "20260101",
        customClusters: {},
        meta: {},
    };
    zh.endpoints = [new Endpoint(1, ieeeAddr)];
    zh.getEndpoint = (ID) => zh.endpoints.find((endpoint) => endpoint.ID === ID);
    const ids = definition.endpoint ? Object.values(definition.endpoint(zh)) : [];
    zh.endpoints = [...new Set([1, ...ids])].map((ID) => new Endpoint(ID, ieeeAddr));
    const device = new Device(zh);
    device.definition = definition;
    if (device.exposes().some((expose) => expose.name === "battery")) {
        Object.assign(zh, { type: "EndDevice", powerSource: "Battery" });
    }
    const name = `${model.vendor} ${model.model} ${number}`.replaceAll(/[/+#]/g, "-");
    settings.get().devices[ieeeAddr] = { friendly_name: name };
    return device;
}

async function main() {
    const devices = models.map(makeDevice).filter((_, number) => number % Number(each) === 0);
    const lines = [];
    const publish = (topic, payload, options = {}) => lines.push([`${options.baseTopic ?? BASE}/${topic}`, payload]);
    const ignore = () => {};
    const zigbee = {
        devicesIterator: () => devices,
        groupsIterator: () => [],
        devicesAndGroupsIterator: () => devices,
        getCoordinatorVersion: () => ({ type: "EmberZNet", meta: { revision: "7.4.4" } }),
        firstCoordinatorEndpoint: () => new Endpoint(1, "0x00124b0000000000"),
    };
    const mqtt = { publish, subscribe: ignore, unsubscribe: ignore };
    const state = { exists: () => false, get: () => ({}) };
    const events = new Proxy({}, { get: () => ignore });
    const parts = [zigbee, mqtt, state, ignore, events];
    await new Bridge(...parts).publishDevices();
    const { setTimeout } = globalThis;
    let discover;
    globalThis.setTimeout = (callback) => {
        discover = callback; // five seconds later: until then it listens for what the broker has
    };
    await new HomeAssistant(...parts).start();
    globalThis.setTimeout = setTimeout;
    await discover();
    for (const device of devices) {
        publish(`${device.name}/availability`, '{"state":"online"}');
    }
    publish("bridge/state", '{"state":"online"}');
    const publishable = lines.filter(([topic]) => !/[+#]/.test(topic)); // no broker takes the others
    process.stdout.write(publishable.map((line) => `${JSON.stringify(line)}\n`).join(""));
}

main().finally(() => fs.rmSync(data, { recursive: true }));
