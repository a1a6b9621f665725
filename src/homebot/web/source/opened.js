// What a view asks homebot for, and again with each new connection.
import { useEffect } from "preact/hooks";
import { connection } from "./door.js";

/** Call `look` while homebot is there, anew when one of `given` is another, and again after the ms that it returns. */
export function useOpen(look, given = []) {
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return undefined;
    let timer = 0;
    let isCurrent = true;
    const again = async () => {
      const wait = await look(() => isCurrent);
      if (wait && isCurrent) timer = setTimeout(again, wait);
    };
    again();
    return () => {
      isCurrent = false;
      clearTimeout(timer);
    };
  }, [isOpen, ...given]);
}
