"""The plans of the built-in houses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from belvedere.model.plan import Door, HousePlan, RoomPlan, Stair, Window

_FINISHES: dict[str, tuple[str, str, float]] = {
    "living": ("cream_wall", "planks", 0.5), "library": ("green_wall", "planks", 0.5),
    "dining": ("rose_wall", "planks", 0.5), "kitchen": ("sage_wall", "tiles", 1.0),
    "bedroom": ("blue_wall", "planks", 0.5), "guest": ("cream_wall", "planks", 0.5),
    "chamber": ("ochre_wall", "planks", 0.5),
    "bath": ("bath_wall", "checker", 0.8), "study": ("green_wall", "planks", 0.5),
    "music": ("ochre_wall", "planks", 0.5), "nursery": ("yellow_wall", "planks", 0.5),
    "store": ("white_wall", "tiles", 1.0), "dressing": ("rose_wall", "planks", 0.5),
    "corridor": ("white_wall", "planks", 0.5), "hall": ("white_wall", "checker", 0.8),
    "conservatory": ("sage_wall", "tiles", 1.0),
    "flat": ("cream_wall", "planks", 0.5),
}  # fmt: skip

WIDE = 2.2
"""Height of an opening without a leaf."""


def _flat_plan() -> HousePlan:
    """Two rooms: one to live and cook in, one to sleep in.

    +-----------+--------+
    | living      bedroom|
    +-----------+--------+
    """
    return HousePlan(
        (
            RoomPlan("living room", "flat", (0.0, 0.0, 6.4, 4.8)),
            RoomPlan("bedroom", "bedroom", (6.4, 0.0, 10.4, 4.8)),
        ),
        (Door(("living room", "bedroom"), 3.9),),
        (
            Window("living room", "south", 1.7, 1.6),
            Window("living room", "south", 4.5, 1.6),
            Window("bedroom", "south", 8.4, 1.6),
        ),
        2.7,
        entrance=("living room", "west", 3.9),
        finishes=_FINISHES,
    )


def _bungalow_plan() -> HousePlan:
    """Nineteen rooms on one floor, along a passage; 28 doors and openings, 24 windows.

    y=12.4 +--------+-----+-------+----------+--------+--------+-----+-------+
           | bed 1  |bath |bed 2  | music    | study  |nursery |bath | guest |
    y=7.2  +-----+--+-----+-------+----------+--------+--------+-----+-------+
           |dress| west passage   |inner hall|  east passage         |laundry|
    y=5.2  +-----+-+------+-------+----------+--------+--------+----+-+------+
           | living       |library| entrance | dining    | kitchen   |conserv.|
    y=0    +--------------+-------+----------+-----------+-----------+--------+
           x=0           6.6     11.2       15.0        20.2        25.2     29
    """
    rooms = (
        RoomPlan("living room", "living", (0.0, 0.0, 6.6, 5.2)),
        RoomPlan("library", "library", (6.6, 0.0, 11.2, 5.2)),
        RoomPlan("entrance", "hall", (11.2, 0.0, 15.0, 5.2)),
        RoomPlan("dining room", "dining", (15.0, 0.0, 20.2, 5.2)),
        RoomPlan("kitchen", "kitchen", (20.2, 0.0, 25.2, 5.2)),
        RoomPlan("conservatory", "conservatory", (25.2, 0.0, 29.0, 5.2)),
        RoomPlan("dressing room", "dressing", (0.0, 5.2, 3.0, 7.2)),
        RoomPlan("west passage", "corridor", (3.0, 5.2, 11.2, 7.2)),
        RoomPlan("inner hall", "corridor", (11.2, 5.2, 15.0, 7.2)),
        RoomPlan("east passage", "corridor", (15.0, 5.2, 25.2, 7.2)),
        RoomPlan("laundry", "store", (25.2, 5.2, 29.0, 7.2)),
        RoomPlan("first bedroom", "bedroom", (0.0, 7.2, 4.8, 12.4)),
        RoomPlan("first bathroom", "bath", (4.8, 7.2, 7.4, 12.4)),
        RoomPlan("second bedroom", "bedroom", (7.4, 7.2, 11.2, 12.4)),
        RoomPlan("music room", "music", (11.2, 7.2, 16.4, 12.4)),
        RoomPlan("study", "study", (16.4, 7.2, 20.0, 12.4)),
        RoomPlan("nursery", "nursery", (20.0, 7.2, 23.6, 12.4)),
        RoomPlan("second bathroom", "bath", (23.6, 7.2, 25.8, 12.4)),
        RoomPlan("guest room", "guest", (25.8, 7.2, 29.0, 12.4)),
    )
    doors = (
        Door(("living room", "library"), 2.2, 1.5, WIDE, "opening"),
        Door(("library", "entrance"), 2.2),
        Door(("entrance", "dining room"), 2.2, 1.5, WIDE, "opening"),
        Door(("dining room", "kitchen"), 2.2),
        Door(("kitchen", "conservatory"), 2.6, 1.6, WIDE, "opening"),
        Door(("entrance", "inner hall"), 13.1, 1.9, WIDE, "opening"),
        Door(("inner hall", "west passage"), 6.2, 1.2, WIDE, "opening"),
        Door(("inner hall", "east passage"), 6.2, 1.2, WIDE, "opening"),
        Door(("inner hall", "music room"), 13.1, 1.5, WIDE, "opening"),
        Door(("living room", "west passage"), 4.4),
        Door(("library", "west passage"), 9.0),
        Door(("west passage", "dressing room"), 6.2),
        Door(("dressing room", "first bedroom"), 1.6),
        Door(("west passage", "first bedroom"), 3.9, 0.86),
        Door(("west passage", "first bathroom"), 6.1, 0.86),
        Door(("west passage", "second bedroom"), 9.2),
        Door(("east passage", "dining room"), 17.6),
        Door(("east passage", "kitchen"), 22.4),
        Door(("east passage", "study"), 18.2),
        Door(("east passage", "nursery"), 21.8),
        Door(("east passage", "second bathroom"), 24.5, 0.86),
        Door(("east passage", "laundry"), 6.2),
        Door(("laundry", "conservatory"), 27.2),
        Door(("laundry", "guest room"), 27.6),
        Door(("music room", "study"), 9.0),
        Door(("first bathroom", "second bedroom"), 8.4),
        Door(("nursery", "second bathroom"), 10.8, 0.86),
        Door(("second bathroom", "guest room"), 8.4, 0.86),
    )
    windows = (
        Window("living room", "south", 1.9, 1.8),
        Window("living room", "south", 4.7, 1.8),
        Window("living room", "west", 2.6, 1.8),
        Window("library", "south", 8.9, 1.8),
        Window("entrance", "south", 11.95, 0.6, 0.4, 2.1, (1, 4)),
        Window("entrance", "south", 14.25, 0.6, 0.4, 2.1, (1, 4)),
        Window("dining room", "south", 16.5, 1.3),
        Window("dining room", "south", 18.7, 1.3),
        Window("kitchen", "south", 21.6, 1.5, 1.0),
        Window("kitchen", "south", 23.9, 1.5, 1.0),
        Window("conservatory", "south", 27.1, 2.8, 0.45, 2.4, (6, 4)),
        Window("conservatory", "east", 2.6, 3.2, 0.45, 2.4, (6, 4)),
        Window("dressing room", "west", 6.2, 0.9, 1.0),
        Window("laundry", "east", 6.2, 0.9, 1.0),
        Window("first bedroom", "north", 2.4, 1.6),
        Window("first bathroom", "north", 6.1, 0.9, 1.2, 2.2, (2, 2)),
        Window("second bedroom", "north", 9.3, 1.6),
        Window("music room", "north", 12.7, 1.4),
        Window("music room", "north", 14.9, 1.4),
        Window("study", "north", 18.2, 1.5),
        Window("nursery", "north", 21.8, 1.5),
        Window("second bathroom", "north", 24.7, 0.9, 1.2, 2.2, (2, 2)),
        Window("guest room", "north", 27.4, 1.5),
        Window("guest room", "east", 9.8, 1.4),
    )
    return HousePlan(
        rooms, doors, windows, 2.75, entrance=("entrance", "south", 13.1), finishes=_FINISHES
    )


def _villa_plan() -> HousePlan:
    """Seven rooms on two floors round a hall two storeys high; six doors and six windows.

    y=9.2 +------------------+----------+     +--+---------------+----------+
          | hall   <- stair  | kitchen  |     |ga|     void      | study    |
          |                  |          |     |llery - - - - - - |          |
    y=4.6 +--------+---------+----------+     +------------------+--+-------+
          | parlour          | dining   |     | bedroom             |dressing
    y=0   +------------------+----------+     +---------------------+-------+
          x=0               6.6       11.6                         8.2
    """
    rooms = (
        RoomPlan("hall", "hall", (0.0, 4.6, 6.6, 9.2), 0, 2),
        RoomPlan("parlour", "living", (0.0, 0.0, 6.6, 4.6)),
        RoomPlan("dining room", "dining", (6.6, 0.0, 11.6, 4.6)),
        RoomPlan("kitchen", "kitchen", (6.6, 4.6, 11.6, 9.2)),
        RoomPlan("bedroom", "chamber", (0.0, 0.0, 8.2, 4.6), 1),
        RoomPlan("study", "study", (6.6, 4.6, 11.6, 9.2), 1),
        RoomPlan("dressing room", "dressing", (8.2, 0.0, 11.6, 4.6), 1),
    )
    doors = (
        Door(("hall", "parlour"), 3.0, 1.5, WIDE, "opening"),
        Door(("parlour", "dining room"), 2.4, 1.3, WIDE, "opening"),
        Door(("hall", "kitchen"), 5.6),
        Door(("hall", "bedroom"), 3.0),
        Door(("hall", "study"), 5.35),
        Door(("study", "dressing room"), 9.9),
    )
    windows = (
        Window("hall", "west", 6.9, 1.8, 3.5, 5.2, (3, 4)),
        Window("parlour", "south", 3.3, 2.2, panes=(3, 3)),
        Window("dining room", "south", 9.1, 1.9),
        Window("kitchen", "east", 6.9, 1.6, 1.0),
        Window("bedroom", "south", 4.1, 2.4, panes=(4, 3)),
        Window("study", "east", 6.9, 1.6),
    )
    return HousePlan(
        rooms, doors, windows, 2.7, Stair("hall", 5.6, 6.05), ("hall", "west", 6.2), _FINISHES
    )


@dataclass(frozen=True, slots=True)
class HouseKind:
    """A house that can be built."""

    title: str
    """What it is, in a line."""
    plan: Callable[[], HousePlan]
    """Its rooms."""
    polygons: int
    """At detail 1, within 1 %."""
    tour: tuple[str, ...]
    """Rooms in the order in which the recorded walk visits them."""


HOUSES: dict[str, HouseKind] = {
    "flat": HouseKind(
        "two rooms", _flat_plan, 80_000, ("living room", "bedroom", "living room")
    ),
    "bungalow": HouseKind(
        "19 rooms on one storey, 52 doors, windows and openings",
        _bungalow_plan,
        528_000,
        ("living room", "library", "entrance", "inner hall", "music room", "study",
         "east passage", "nursery", "second bathroom", "guest room", "laundry", "conservatory",
         "kitchen", "dining room"),
    ),
    "villa": HouseKind(
        "7 rooms on two storeys, 12 doors, windows and openings",
        _villa_plan,
        214_000,
        ("dining room", "parlour", "kitchen", "hall", "bedroom", "study", "dressing room"),
    ),
}  # fmt: skip
"""The built-in houses by name."""
