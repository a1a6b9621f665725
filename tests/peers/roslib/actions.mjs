// The actions of roslib 2, as client of /fib and as server of /mine, at the door of the port given.
import { Action, Ros } from "roslib-2";

const ros = new Ros({ url: `ws://127.0.0.1:${process.argv[2]}` });
await new Promise((resolve) => ros.on("connection", resolve));
ros.on("error", (error) => console.error(error.message));

const perform = (action, order, cancelled = false) =>
  new Promise((resolve) => {
    const feedback = [];
    const end = (kind) => (value) => resolve([kind, value, feedback]);
    const id = action.sendGoal({ order }, end("result"), (one) => feedback.push(one.sequence), end("failed"));
    if (cancelled) action.cancelGoal(id);
  });
const actionType = "example_interfaces/action/Fibonacci";
const told = {};
const fib = new Action({ ros, name: "/fib", actionType });
told.client = [await perform(fib, 3), await perform(fib, 50, true), await perform(fib, 7), await perform(fib, -1)];

const mine = new Action({ ros, name: "/mine", actionType });
mine.advertise(
  (goal, id) => {
    mine.sendFeedback(id, { sequence: [goal.order] });
    if (goal.order === 2) mine.setSucceeded(id, { sequence: [0, 1] });
    if (goal.order === 7) mine.setFailed(id);
  },
  (id) => mine.setCanceled(id, { sequence: [9] }),
);
const user = new Action({ ros, name: "/mine", actionType });
told.server = [await perform(user, 2), await perform(user, 50, true), await perform(user, 7)];
console.log(JSON.stringify(told));
process.exit();
