// The shell of the page without homebot: its files with one language, kept by build; never data. homebot puts BUILD and
// FILES before this text. A newer one waits until the page says that it is its time.
const LANGUAGE = location.search.slice(1);
const NAME = `homebot-${BUILD}-${LANGUAGE}`;
const OTHERS = new RegExp(`^(?!${LANGUAGE}(_late)?-)[a-z]{2}(_late)?-\\w+\\.js$|^licences\\.txt$`);
const SHELL = FILES.filter((file) => !OTHERS.test(file)).map((file) => (file === "index.html" ? "./" : file));
const PATIENCE = 2000; // ms after which a navigation does not wait for the cache
const PATHS = new Set(SHELL.map((file) => new URL(file, registration.scope).pathname));

addEventListener("install", (event) => {
  if (registration.active && registration.active.scriptURL !== location.href) skipWaiting(); // another language was chosen
  event.waitUntil(caches.open(NAME).then((cache) => cache.addAll(SHELL)));
});
addEventListener("message", (event) => event.data === "take over" && skipWaiting());
addEventListener("activate", (event) =>
  event.waitUntil(
    caches.keys().then((names) => Promise.all(names.filter((name) => name.startsWith("homebot-") && name !== NAME).map((name) => caches.delete(name)))),
  ),
);

addEventListener("fetch", (event) => {
  const { request } = event;
  const { origin, pathname } = new URL(request.url);
  if (request.method !== "GET" || origin !== location.origin || !PATHS.has(pathname)) return;
  event.respondWith(answer(request, pathname));
});

async function answer(request, pathname) {
  const late = new Promise((resolve) => setTimeout(resolve, PATIENCE));
  const kept = caches.open(NAME).then((cache) => cache.match(pathname)).catch(() => undefined);
  return (await Promise.race([kept, late])) ?? fetch(request).catch(async (error) => (await kept) ?? Promise.reject(error));
}
