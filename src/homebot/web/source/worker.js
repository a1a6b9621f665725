// The shell of the page without homebot: its files, kept by build; never data. homebot puts BUILD and FILES before this text.
const NAME = `homebot-${BUILD}`;
const SHELL = FILES.map((file) => (file === "index.html" ? "./" : file)).filter((file) => file !== "licences.txt");
const PATIENCE = 2000; // ms after which a navigation does not wait for the cache
const PATHS = new Set(SHELL.map((file) => new URL(file, registration.scope).pathname));

addEventListener("install", (event) => event.waitUntil(caches.open(NAME).then((cache) => cache.addAll(SHELL))));

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
  const kept = caches.open(NAME).then((cache) => cache.match(pathname));
  return (await Promise.race([kept, late]).catch(() => undefined)) ?? fetch(request);
}
