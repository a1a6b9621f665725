// What features add to the page: views of their own, parts of other views, and numbers of the rail.
import { FEATURES } from "./features.js";
import { html } from "./html.js";

/** By name: as the views of page.js; in the rail, one is `after` another. */
export const VIEWS = Object.assign({}, ...FEATURES.map(({ views }) => views));

/** What features have at a place of the page, such as `scenes`. */
export const Added = ({ at, ...props }) => FEATURES.map(({ parts }) => parts?.[at] && html`<${parts[at]} ...${props} />`);

/** What a view has to tell in the rail, as a number. */
export const addedMark = (view) => FEATURES.reduce((sum, { marks }) => sum + (marks?.[view]?.() ?? 0), 0);

/** `titles` of views by their names, with those of features in their places. */
export function withAdded(titles) {
  const added = (name) => Object.entries(VIEWS).filter(([, { after }]) => after === name).map(([own, { title }]) => [own, title]);
  return Object.fromEntries(Object.entries(titles).flatMap(([name, title]) => [[name, title], ...added(name)]));
}
