// roslib, version 1 or 2, at the door of the port given; prints what it was told as JSON.
const [version, port] = process.argv.slice(2);
const library = await import(`roslib-${version}`);
const { Ros, Topic, Service } = library.Ros ? library : library.default;

const ros = new Ros({ url: `ws://127.0.0.1:${port}` });
ros.on("error", (error) => console.error(error.message));
await new Promise((resolve) => ros.on("connection", resolve));

const first = (name, compression) =>
  new Promise((resolve) => {
    const topic = new Topic({ ros, name, messageType: "std_msgs/String", compression });
    topic.subscribe((message) => {
      topic.unsubscribe();
      resolve(message.data);
    });
  });
const call = (name, request) =>
  new Promise((resolve) => {
    new Service({ ros, name, serviceType: "std_srvs/SetBool" }).callService(request, (answer) => resolve(answer.message), resolve);
  });

const told = { latched: {} };
for (const compression of ["none", "png", "cbor"]) {
  told.latched[compression] = await first("/state", compression);
}
const echoed = first("/echoed");
new Topic({ ros, name: "/hello", messageType: "std_msgs/String" }).publish({ data: "hi" });
told.echoed = await echoed;
told.called = await call("/switch", { data: true });
told.absent = await call("/nobody", {});
const mine = new Service({ ros, name: "/mine", serviceType: "std_srvs/SetBool" });
await mine.advertise((request, response) => {
  response.success = request.data;
  response.message = "served by roslib";
  return true;
});
told.served = await call("/mine", { data: true });
const cmdVel = new Topic({ ros, name: "/cmd_vel", messageType: "geometry_msgs/Twist" });
const driven = new Promise((resolve) => cmdVel.subscribe(resolve));
cmdVel.publish({ linear: { x: 0.1, y: 0.2, z: 0.3 }, angular: { x: -0.1, y: -0.2, z: -0.3 } });
told.driven = (await driven).angular.z;
const adder = { ros, name: "/add_two_ints", serviceType: "example_interfaces/AddTwoInts" };
await new Service(adder).advertise((request, response) => {
  response.sum = request.a + request.b;
  return true;
});
told.sum = await new Promise((resolve, reject) => {
  new Service(adder).callService({ a: 1, b: 2 }, (answer) => resolve(answer.sum), reject);
});
console.log(JSON.stringify(told));
process.exit();
