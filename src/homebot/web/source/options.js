// The texts that a device takes, such as the floors of a lift; none if it takes no command for them.
import { useEffect, useState } from "preact/hooks";
import { call } from "./door.js";
import { takes } from "./house.js";

export function useOptions(device, capability) {
  const [options, setOptions] = useState([]);
  const isTaken = takes(device, capability);
  useEffect(() => {
    if (!isTaken) return;
    call("/discovery/find_devices", { ids: [device.id] }).then(({ devices }) => setOptions(devices[0]?.parts.flatMap(({ part }) => part.capabilities).find((one) => one.name === capability)?.options ?? []), () => {});
  }, [device.id, isTaken]);
  return options;
}
