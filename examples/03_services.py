"""A service, its answer, and the three ways in which it can fail to give one."""

import asyncio

from homebot import Graph, Node, ServiceError
from homebot.messages import SetBool
from homebot.messages.std_srvs import SetBoolRequest, SetBoolResponse


async def switch(request: SetBoolRequest) -> SetBoolResponse:
    """Switch, but never off on a Sunday."""
    if not request.data:
        raise RuntimeError("it is Sunday")
    await asyncio.sleep(0.2)
    return SetBoolResponse(success=True, message="done")


async def main() -> None:
    """Call well, too impatiently, in vain, and where nobody is."""
    async with Node(Graph(), "kitchen") as kitchen:
        service = kitchen.create_service(SetBool, "switch", switch)
        client = kitchen.create_client(SetBool, "switch")
        print(await client.call(SetBoolRequest(data=True), timeout=1))
        for data, timeout in ((True, 0.1), (False, 1.0)):
            try:
                await client.call(SetBoolRequest(data=data), timeout=timeout)
            except ServiceError as exc:
                print(f"{type(exc).__name__}: {exc}")
        service.close()
        try:
            await client.call(SetBoolRequest(data=True))
        except ServiceError as exc:
            print(f"{type(exc).__name__}: {exc}")


if __name__ == "__main__":
    asyncio.run(main())
