// A dimmable light with a button, on matter.js. SIGUSR2 presses the button, which switches the light too.
import { Seconds, ServerNode, Endpoint } from "@matter/main";
import { DimmableLightDevice } from "@matter/main/devices/dimmable-light";
import { GenericSwitchDevice } from "@matter/main/devices/generic-switch";
import { SwitchServer } from "@matter/main/behaviors/switch";

const node = await ServerNode.create({
  id: "light",
  // Short, so that a server soon notices that the device is gone.
  network: { port: 5540, subscriptionOptions: { maxInterval: Seconds(3), minInterval: Seconds(1), randomizationWindow: Seconds(1) } },
  commissioning: { passcode: 20202021, discriminator: 3840 },
  productDescription: { name: "Hall light", deviceType: DimmableLightDevice.deviceType },
  basicInformation: {
    vendorName: "matter.js",
    vendorId: 0xfff1,
    productId: 0x8000,
    productName: "Test light",
    nodeLabel: "Hall light",
    serialNumber: "peer-1",
  },
});
const light = await node.add(DimmableLightDevice, { id: "light" });
const button = await node.add(GenericSwitchDevice.with(SwitchServer.with("MomentarySwitch")), { id: "button" });

light.events.onOff.onOff$Changed.on(isOn => console.log(`light is ${isOn ? "on" : "off"}`));
light.events.levelControl.currentLevel$Changed.on(level => console.log(`level is ${level}`));
node.lifecycle.commissioned.on(() => console.log("commissioned"));
node.lifecycle.decommissioned.on(() => console.log("decommissioned"));
process.on("SIGUSR2", async () => {
  await button.set({ switch: { currentPosition: 1 } });
  await button.set({ switch: { currentPosition: 0 } });
  await light.set({ onOff: { onOff: !light.state.onOff.onOff } });
});
await node.start();
console.log(`pairing code ${node.state.commissioning.pairingCodes.qrPairingCode}`);
console.log("the light runs");
