// All that is known of a device, which the list of devices does not tell; such as the texts that it takes.
import { useState } from "preact/hooks";
import { call } from "./door.js";
import { takes } from "./house.js";
import { useOpen } from "./opened.js";

const GATHER = 200; // ms for which changes are gathered

/** A device with its parts, asked for where *isWanted*, and again after it changed; null until homebot answers. */
export function useFull(id, isWanted, changedAt = 0) {
  const [full, setFull] = useState(null);
  useOpen(() => {
    if (isWanted) call("/discovery/find_devices", { ids: [id] }).then((answer) => setFull(answer.devices[0] ?? null), () => {});
  }, [id, isWanted, changedAt], changedAt ? GATHER : 0);
  return full;
}

/** The texts that a device takes, such as the floors of a lift; none if it takes no command for them. */
export const useOptions = (device, capability) =>
  useFull(device.id, takes(device, capability))?.parts.flatMap(({ part }) => part.capabilities).find((one) => one.name === capability)?.options ?? [];
