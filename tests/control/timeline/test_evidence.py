from homebot.control.timeline.evidence import SendingPlan, next_step
from homebot.control.timeline.facts import Order, SendingEnded, Sent
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress


def test_a_command_is_sent_again_only_before_its_end() -> None:
    """A wait may last too long, on a busy computer or one that slept."""
    order = Order("c-1", {"on_off": True}, {"on_off": True}, moves=False, has_ramp=False)
    progress = CommandProgress(order, 0.0, {}, {}, DeviceProfile())
    progress.apply(Sent("c-1", order.settings, 0.0), 10.0)
    progress.apply(SendingEnded("c-1", 0.0), 10.0)
    plan = SendingPlan(tries=2, interval=5.0, lasts=10.0)
    assert [next_step(progress, plan, now).kind for now in (1.0, 5.0, 9.9, 10.0, 20.0)] == [
        *("wait", "send", "send"),
        *("done", "done"),
    ]
