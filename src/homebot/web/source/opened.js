// What a view asks homebot for, and again with each new connection.
import { useEffect } from "preact/hooks";
import { connection } from "./door.js";

/** Call `look` while homebot is there, `delay` ms after one of `given` became another, and again after the ms that it returns. */
export function useOpen(look, given = [], delay = 0) {
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return undefined;
    let isCurrent = true;
    const again = async () => {
      const wait = await look(() => isCurrent);
      if (wait && isCurrent) timer = setTimeout(again, wait);
    };
    let timer = setTimeout(again, delay);
    return () => {
      isCurrent = false;
      clearTimeout(timer);
    };
  }, [isOpen, ...given]);
}
