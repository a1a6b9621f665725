// Texts and controls of a view, or of an open sheet, that leave their card, or lie on each other, with text of so many per cent.
document.documentElement.style.fontSize = `${arguments[0]}%`;
const OUTSIDE = "svg, select, .tabs, .scenes, .scroll, [inert]"; // what scrolls by itself, or is drawn to scale
const isClipped = (node) => node && (getComputedStyle(node).clipPath !== "none" || isClipped(node.parentElement));
const isShown = (node) => node.checkVisibility({ contentVisibilityAuto: true }) && !node.closest(OUTSIDE) && !isClipped(node);
const boxOf = (node) => node.getBoundingClientRect();
const outerOf = (node) => boxOf(node.closest(".card, section, .tile, .guard") ?? place);
const meet = (a, b) =>
  Math.min(a.right, b.right) - Math.max(a.left, b.left) > 4 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 4;

const place = document.querySelector(".sheet") ?? document.querySelector("main");
const texts = [];
const walker = document.createTreeWalker(place, NodeFilter.SHOW_TEXT);
for (let node = walker.nextNode(); node; node = walker.nextNode()) {
  if (!node.data.trim() || !isShown(node.parentElement)) continue;
  const range = document.createRange();
  range.selectNodeContents(node);
  for (const box of range.getClientRects()) if (box.width) texts.push({ node, box, text: node.data.trim() });
}
const controls = [...place.querySelectorAll(":is(button, a, input)")].filter((one) => isShown(one) && !one.matches(".main, .range, .about"));
const isOf = (node, control) => control.contains(node) || node.parentElement.closest("label, li, p")?.contains(control);
const leaves = (node, box) => box.right > outerOf(node.parentElement).right + 1;

return [
  ...texts.filter(({ node, box }) => leaves(node, box)).map(({ text }) => `${text} leaves its card`),
  ...controls.filter((one) => leaves(one, boxOf(one))).map((one) => `${one.outerHTML} leaves its card`),
  ...texts.flatMap((a, at) => texts.slice(at + 1).filter((b) => meet(a.box, b.box)).map((b) => `${a.text} lies on ${b.text}`)),
  ...controls.flatMap((one) => texts.filter(({ node, box }) => !isOf(node, one) && meet(box, boxOf(one))).map(({ text }) => `${text} lies below ${one.outerHTML}`)),
];
