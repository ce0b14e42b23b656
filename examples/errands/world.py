"""A house of symbols for errands: rooms, doors, containers, things, and a robot whose actions take time and fail at
times. A stand-in of ours for a simulator: it has no geometry, and says nothing of any real robot.

A run starts it. `python3 world.py 127.0.0.1:7400` waits there for runs instead, and the house stays as it is.
"""

import random
import sys

from rpl_module import Behaviour, Failure, Module, Symbol

DOORS = {"kitchen-door": "kitchen", "office-door": "office", "yard-door": "yard", "den-door": "den"}
"""Each leads from the corridor into a room."""

PLACES = {
    "corridor": "corridor", "charger": "corridor", "counter": "kitchen", "fridge": "kitchen", "desk": "office",
    "table": "den", "shelf": "den", "dumpster": "yard",
}
CONTAINERS, SPOTS = {"fridge", "dumpster"}, ["counter", "desk", "table", "shelf"]
LEG_S, HAND_S, CHARGE_S = 4.0, 2.0, 10.0
LEG_CHARGE, HAND_CHARGE = 0.03, 0.004

TWO = {"things": {"banana": "desk", "can": "table"}, "goals": {"banana": "fridge", "can": "dumpster"}}
PROBLEMS = {
    1: {"things": {"banana": "desk"}, "goals": {"banana": "counter"}},
    2: {**TWO, "closed": CONTAINERS},
    3: {**TWO, "closed": CONTAINERS | set(DOORS), "slips": 0.2},
    4: {"things": {"banana": "desk", "milk": "table", "can": "counter", "jar": "shelf"},
        "goals": {"banana": "fridge", "milk": "fridge", "can": "dumpster", "jar": "dumpster"},
        "closed": CONTAINERS | set(DOORS), "slips": 0.2, "drains": True},
}

FLUENTS = {"at": "at*", "holding": "holding*", "charge": "charge*"}

module = Module("errands")


def symbol(name):
    return name and Symbol(name)


class World:
    """Where everything is, and what the robot has seen of it."""

    def __init__(self, problem=1, person=False, hidden=False):
        said = PROBLEMS[problem]
        self.chance, self.person = random.Random(f"{module.seed} {problem}"), person
        self.things, self.goals = dict(said["things"]), said["goals"]
        if hidden:
            # Somebody has carried each thing elsewhere, and nobody has told the robot.
            self.things = {thing: self.chance.choice(SPOTS) for thing in self.things}
        self.seen = {} if hidden else dict(self.things)
        self.closed, self.slips = set(said.get("closed", ())), said.get("slips", 0.0)
        self.to_close, self.drains = self.closed & CONTAINERS, said.get("drains", False)
        self.at, self.holding, self.charge, self.least = "charger", None, 0.7, 0.7

    def __setattr__(self, name, value):
        """What plans see of it is told in the step in which it changes."""
        super().__setattr__(name, value)
        if name in FLUENTS:
            module.set(FLUENTS[name], symbol(value) if isinstance(value, str) else value)

    def drain(self, charge):
        self.charge = max(0.0, self.charge - charge * self.drains)
        self.least = min(self.least, self.charge)
        if self.charge == 0:
            raise Failure("battery-empty", "the battery is empty, and the robot stands")

    def may_fail(self, doing, chance):
        if self.chance.random() < chance:
            raise Failure("slipped", f"it did not succeed: {doing}", doing=Symbol(doing))

    def must_be_open(self, what):
        if what in self.closed:
            raise Failure("closed", f"the {what} is closed", what=Symbol(what))

    def must_be_here(self, what, is_here):
        if not is_here:
            raise Failure("not-here", f"the {what} is not here", what=Symbol(what))

    def is_as_wanted(self):
        return all(self.things[thing] == goal for thing, goal in self.goals.items()) and self.to_close <= self.closed


world = World()


class Hand(Behaviour):
    """What the hand does: it takes a while, costs some charge, and slips at times."""

    def work(self, doing):
        self.sleep(HAND_S)
        world.drain(HAND_CHARGE)
        world.may_fail(doing, world.slips)


@module.behaviour("move")
class Move(Behaviour):
    def run(self, to):
        """Through the corridor, as far as the first closed door: from there it goes on the next time."""
        rooms = [PLACES[world.at], PLACES[to]]
        for room, is_way_in in ([] if rooms[0] == rooms[1] else zip(rooms, (False, True))):
            if room == "corridor":
                continue
            self.sleep(LEG_S)
            world.drain(LEG_CHARGE)
            world.may_fail("move", world.slips / 2)
            world.must_be_open(next(door for door in DOORS if DOORS[door] == room))
            world.at = next(place for place in PLACES if PLACES[place] == room) if is_way_in else "corridor"
        self.sleep(LEG_S / 2)
        world.drain(LEG_CHARGE / 2)
        world.at = str(to)


@module.behaviour("pick-up")
class PickUp(Hand):
    def run(self, thing):
        world.must_be_open(world.at)
        self.work("pick-up")
        world.seen.pop(thing, None)
        world.must_be_here(thing, world.things[thing] == world.at)
        world.things[thing], world.holding = "hand", str(thing)
        return Symbol(thing)


@module.behaviour("put-down")
class PutDown(Hand):
    def run(self):
        self.work("put-down")
        world.must_be_open(world.at)
        world.things[world.holding] = world.seen[world.holding] = world.at
        world.holding = None


@module.behaviour("open-up")
class OpenUp(Hand):
    def run(self, what, shut=False):
        world.must_be_here(what, world.at == what or PLACES[world.at] in ("corridor", DOORS.get(what)))
        self.work("close" if shut else "open")
        (world.closed.add if shut else world.closed.discard)(str(what))


@module.behaviour("look")
class Look(Behaviour):
    def run(self):
        self.sleep(HAND_S)
        found = [thing for thing, place in world.things.items() if place == world.at]
        world.seen.update({thing: world.at for thing in found})
        return [Symbol(thing) for thing in found]


@module.behaviour("charge")
class Charge(Behaviour):
    def run(self):
        world.must_be_here("charger", world.at == "charger")
        self.sleep(CHARGE_S)
        world.charge = 1.0


@module.behaviour("begin")
class Begin(Behaviour):
    def run(self, **wanted):
        global world
        world = World(**wanted)


module.query("place-of")(lambda thing: symbol(world.seen.get(thing)))
module.query("closed?")(lambda what: what in world.closed)
module.query("as-wanted?")(lambda: world.is_as_wanted())
module.query("least-charge")(lambda: world.least)


@module.each_tick
def tell(tick):
    if world.person and world.chance.random() < 0.05 * 2 / 60:
        world.closed.add(world.chance.choice(sorted(CONTAINERS | set(DOORS))))
    for name in FLUENTS:
        setattr(world, name, getattr(world, name))


if __name__ == "__main__":
    module.serve(sys.argv[1]) if sys.argv[1:] else module.run()
