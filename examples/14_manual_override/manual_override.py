from homebot import App, HandleChange, Light, OccupancySensor
from homebot.apps.rooms import in_room, per_handle, per_room


class ManualOverride(App):
    async def run(self) -> None:
        self.on(self.devices.follow(Light).only("changed"), self.switched, key=per_handle, mode="queued")
        self.on(self.devices.follow(OccupancySensor).became(occupied=True), self.moved, key=per_room)

    async def switched(self, change: HandleChange[Light]) -> None:
        lamp, cause = change.handle.id, await change.cause("on_off")
        if change.before.get("on_off") is not None and cause is not None and cause.may_be_person:
            self.after("2h", self.give_back, args=(lamp,), name=lamp, durable=True)

    async def give_back(self, lamp: str) -> None:
        await self.each(Light.turn_off, await self.devices.find(Light, name=lamp, on=True))

    async def moved(self, change: HandleChange[OccupancySensor]) -> None:
        overridden = {job.name for job in self.jobs}
        lamps = in_room(await self.devices.find(Light, on=False), change.handle.area)
        await self.each(Light.turn_on, [lamp for lamp in lamps if lamp.id not in overridden])
