// What features add to the page: views of their own, parts of other views, and what cannot wait.
import { FEATURES } from "./features.js";
import { html } from "./html.js";

/** By name: as the views of page.js; in the rail, one is `after` another. */
export const VIEWS = Object.assign({}, ...FEATURES.map(({ views }) => views));

/** What features have at a place of the page, such as `scenes`. */
export const Added = ({ at, ...props }) => FEATURES.map(({ parts }) => parts?.[at] && html`<${parts[at]} ...${props} />`);

/** What cannot wait in the house, as findings. */
export const urgent = () => FEATURES.flatMap((feature) => feature.urgent?.() ?? []);

/** `titles` of views by their names, with those of features in their places. */
export function withAdded(titles) {
  const added = (name) => Object.entries(VIEWS).filter(([, { after }]) => after === name).map(([own, { title }]) => [own, title]);
  return Object.fromEntries(Object.entries(titles).flatMap(([name, title]) => [[name, title], ...added(name)]));
}
