// A consumer on Eclipse Thingweb node-wot: reads the list of a directory, a thing of it, and sets that; one JSON text.
// Descriptions are fetched without requestThingDescription(), which in 0.9.2 accepts the context of TD 1.0 alone.
import httpBinding from "@node-wot/binding-http";
import core from "@node-wot/core";

const [url, title] = process.argv.slice(2);
const servient = new core.Servient();
servient.addClientFactory(new httpBinding.HttpClientFactory(null));
const wot = await servient.start();
const directory = await wot.consume(await (await fetch(`${url}/.well-known/wot`)).json());
const listed = await (await directory.readProperty("things", { uriVariables: { offset: 0, limit: 10 } })).value();
const lamp = await wot.consume(listed.find((thing) => thing.title === title));
const before = await (await lamp.readProperty("level")).value();
await lamp.writeProperty("level", 70);
await lamp.writeProperty("on_off", false);
const after = {};
for (const [name, value] of await lamp.readAllProperties()) {
  after[name] = await value.value();
}
console.log(JSON.stringify({ titles: listed.map((thing) => thing.title), before, after }));
process.exit(0);
