"""IFC read: geometry, rooms, openings, doors, and what is refused."""

from __future__ import annotations

import builtins
import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("ifcopenshell", reason="needs ifcopenshell (pip install 'belvedere[ifc]')")

from belvedere.ground.color import srgb_to_linear
from belvedere.ground.errors import FileFormatError, InputError, MissingDependencyError
from belvedere.model import Building, ImportedModel, Opening, read_model
from belvedere.model._ifc_rooms import inside, section
from tests.model.ifc_files import Ifc, add_rooms, flat


def said(model: ImportedModel, words: str) -> bool:
    return any(words in line for line in model.dropped)


def area(rings: tuple[np.ndarray, ...]) -> float:
    return sum(
        abs(float(np.sum(r[:, 0] * np.roll(r[:, 1], -1) - r[:, 1] * np.roll(r[:, 0], -1)))) / 2
        for r in rings
    )


def building(model: ImportedModel) -> Building:
    assert model.building is not None
    return model.building


def by_name(model: ImportedModel, name: str) -> Opening:
    return next(o for o in building(model).openings if o.name == name)


@pytest.fixture(scope="module")
def office(tmp_path_factory: pytest.TempPathFactory) -> ImportedModel:
    ifc = flat()
    add_rooms(ifc)
    return read_model(ifc.write(tmp_path_factory.mktemp("ifc") / "office.ifc"))


def test_millimetres_become_metres(office: ImportedModel) -> None:
    np.testing.assert_allclose(office.mesh.bounds, [[-0.2, -0.2, -0.3], [8.4, 6.2, 2.8]], atol=1e-9)
    assert (office.source.format, office.source.up) == ("IFC4", "z")
    assert not office.origin.any()


def test_spaces_become_rooms_and_not_surfaces(office: ImportedModel) -> None:
    rooms = building(office).rooms
    assert [r.name for r in rooms] == ["Office (1)", "Office (2)", "Corridor"]
    assert [r.storey for r in rooms] == ["Ground floor"] * 3
    assert [area(r.rings) for r in rooms] == pytest.approx([16, 16, 16.4])
    assert [(r.floor, r.ceiling) for r in rooms] == [pytest.approx((0, 2.5))] * 3
    assert not any("IfcSpace" in name for name in office.names)


def test_openings_stand_in_the_middle_of_their_wall(office: ImportedModel) -> None:
    door, window, hatch = (by_name(office, name) for name in ("D", "W", "hatch"))
    assert (door.kind, window.kind, hatch.kind) == ("door", "window", "opening")
    for opening, low, high in (
        (door, [4.1, 1.0, 0.0], [4.1, 1.9, 2.05]),
        (window, [1.0, -0.1, 0.9], [2.5, -0.1, 2.1]),
        (hatch, [4.1, 2.5, 1.0], [4.1, 3.5, 2.0]),
    ):
        np.testing.assert_allclose(opening.corners.min(axis=0), low, atol=1e-6)
        np.testing.assert_allclose(opening.corners.max(axis=0), high, atol=1e-6)
        assert opening.corners[0, 2] == opening.corners[1, 2] < opening.corners[2, 2]
    assert set(door.rooms) == set(hatch.rooms) == {"Office (1)", "Office (2)"}
    assert set(window.rooms) == {"Office (1)", None}


def test_pipes_and_niches_are_no_openings(office: ImportedModel) -> None:
    assert not {"pipe", "niche"} & {o.name for o in building(office).openings}
    assert said(office, "1 opening smaller than 0.3 m: for pipes")
    assert said(office, "1 recess not through the whole wall")


def test_rooms_without_a_wall_between_are_joined(office: ImportedModel) -> None:
    joins = [o for o in building(office).openings if " - " in o.name]
    assert {o.rooms for o in joins} == {("Office (1)", "Corridor"), ("Office (2)", "Corridor")}
    for join in joins:
        assert join.kind == "opening"
        np.testing.assert_allclose(join.corners[:, 1], 4.0, atol=1e-6)
        assert np.ptp(join.corners[:, 0]) == pytest.approx(4.0, abs=1e-6)
        np.testing.assert_allclose(np.sort(join.corners[:, 2]), [0, 0, 2.5, 2.5], atol=1e-6)


def test_a_wall_that_two_outlines_share_parts_them(tmp_path: Path) -> None:
    ifc = Ifc()
    ifc.element("IfcWall", "w", (3.9, 0.0, 0.0, 4.1, 3.0, 2.5))  # 3 of 4 metres
    for name, box in (("a", (0, 0, 0, 4, 4, 2.5)), ("b", (4, 0, 0, 8, 4, 2.5))):
        ifc.element("IfcSpace", name, box)
    (join,) = building(read_model(ifc.write(tmp_path / "a.ifc"))).openings
    assert join.corners[:, 1].min() == pytest.approx(3.0, abs=0.15)  # the probes' spacing
    assert join.corners[:, 1].max() == pytest.approx(4.0)


def rays_through_the_door(model: ImportedModel) -> np.ndarray:
    pytest.importorskip("embreex")
    from belvedere.model import RayCaster

    y, z = np.meshgrid(np.linspace(1.06, 1.84, 20), np.linspace(0.01, 1.99, 40))
    start = np.stack([np.full(y.size, 2.0), y.ravel(), z.ravel()], axis=1)
    return RayCaster(model.mesh).blocked(start, np.tile([1.0, 0, 0], (y.size, 1)), 4.0)


def test_doors_stand_open_unless_they_are_asked_to_be_closed(
    office: ImportedModel, tmp_path: Path
) -> None:
    assert not rays_through_the_door(office).any()
    assert said(office, "1 door without leaves")
    door = next(k for k, name in enumerate(office.names) if name.startswith("IfcDoor"))
    assert np.count_nonzero(office.object_of_face == door) == 36  # jambs and head
    ifc = flat()
    add_rooms(ifc)
    closed = read_model(ifc.write(tmp_path / "a.ifc"), doors="closed")
    assert rays_through_the_door(closed).all()
    with pytest.raises(InputError, match="doors is 'ajar', expected one of 'open', 'closed'"):
        read_model(tmp_path / "a.ifc", doors="ajar")  # type: ignore[arg-type]


def test_a_leaf_that_fills_its_opening_is_left_out_too(tmp_path: Path) -> None:
    ifc = Ifc()
    wall = ifc.element("IfcWall", "w", (0.0, 0.0, 0.0, 4.0, 0.2, 2.5))
    leaf = ifc.element("IfcDoor", "leaf", (0.0, 0.08, 0.0, 0.9, 0.12, 2.0), at=(1.0, 0.0, 0.0))
    ifc.opening(wall, "for it", (1.0, -0.1, 0.0, 1.9, 0.3, 2.0), leaf)
    double = ifc.element(
        "IfcDoor", "double", (0.0, 0.08, 0.0, 0.8, 0.12, 2.0), (0.8, 0.08, 0.0, 1.6, 0.12, 2.0),
        (0.0, -0.02, 2.0, 1.6, 0.22, 2.04), at=(2.2, 0.0, 0.0),
    )  # fmt: skip
    ifc.opening(wall, "for them", (2.2, -0.1, 0.0, 3.8, 0.3, 2.04), double)
    model = read_model(ifc.write(tmp_path / "a.ifc"))
    left = Counter(model.names[k] for k in model.object_of_face)
    assert left["IfcDoor leaf"] == 0
    assert left["IfcDoor double"] == 12  # its head
    assert said(model, "2 doors without leaves")


def test_a_slit_narrower_than_its_wall_is_thick_is_looked_through(tmp_path: Path) -> None:
    ifc = Ifc()
    ifc.element("IfcSlab", "floor", (0.0, 0.0, -0.2, 4.0, 4.0, 0.0))
    ifc.element("IfcSpace", "room", (0.0, 0.6, 0.0, 4.0, 4.0, 2.5))
    # a wall that is drawn by its parts elsewhere: the window's own axes must tell
    wall = ifc.element("IfcWall", "no shape")
    slit = ifc.element("IfcWindow", "slit", (0.0, 0.2, 0.0, 0.2, 0.4, 1.0), at=(1.0, 0.0, 1.0))
    ifc.opening(wall, "for it", (1.0, 0.0, 1.0, 1.2, 0.6, 2.0), slit)
    found = by_name(read_model(ifc.write(tmp_path / "a.ifc")), "slit")
    np.testing.assert_allclose(found.corners[:, 1], 0.3, atol=1e-6)
    assert set(found.rooms) == {"room", None}


def test_glass_is_left_out_and_styles_are_colors(office: ImportedModel) -> None:
    found = {m.name: m.base_color for m in office.mesh.materials}
    assert set(found) == {"plaster", "wood"}
    expected = srgb_to_linear(np.array([0.8, 0.4, 0.2]))
    np.testing.assert_allclose(found["wood"], expected, atol=1e-6)
    assert said(office, "12 faces of 'glass' let light through: left out")


def test_an_ifc_without_spaces_states_no_rooms(tmp_path: Path) -> None:
    model = read_model(flat(1.0, "IFC2X3").write(tmp_path / "a.ifc"))
    assert model.building is None
    assert said(model, "rooms: the IFC has no spaces")
    np.testing.assert_allclose(model.mesh.bounds, [[-0.2, -0.2, -0.3], [8.4, 6.2, 2.8]], atol=1e-9)


def test_a_building_far_from_its_origin_keeps_its_shape(tmp_path: Path) -> None:
    ifc = flat(shift=1e8)
    add_rooms(ifc)
    model = read_model(ifc.write(tmp_path / "a.ifc"))
    assert said(model, "m subtracted")
    np.testing.assert_allclose(
        model.mesh.bounds + model.origin,
        np.array([[1e8 - 0.2, 1e8 - 0.2, -0.3], [1e8 + 8.4, 1e8 + 6.2, 2.8]]), atol=1e-6,
    )  # fmt: skip
    door = by_name(model, "D")
    np.testing.assert_allclose((door.corners + model.origin)[0, 0], 1e8 + 4.1, atol=1e-6)
    assert set(door.rooms) == {"Office (1)", "Office (2)"}


def test_space_boundaries_fill_in_where_no_outline_reaches(tmp_path: Path) -> None:
    ifc = flat()
    add_rooms(ifc)
    window = ifc.file.by_type("IfcWindow")[0]
    # a space that stops 1 m short of the southern wall: geometry alone does not find it
    for space in [s for s in ifc.file.by_type("IfcSpace") if s.Name == "1"]:
        ifc.file.remove(space)
    short = ifc.element("IfcSpace", "1", (0.0, 1.0, 0.0, 4.0, 4.0, 2.5))
    boundary = ifc.rooted("IfcRelSpaceBoundary", "")
    boundary.RelatingSpace, boundary.RelatedBuildingElement = short, window
    boundary.PhysicalOrVirtualBoundary, boundary.InternalOrExternalBoundary = "PHYSICAL", "EXTERNAL"
    model = read_model(ifc.write(tmp_path / "a.ifc"))
    assert set(by_name(model, "W").rooms) == {"1", None}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hello", r"is not an IFC \(it does not begin with ISO-10303-21;\)"),
        ("ISO-10303-21;\nHEADER;\n", r"is truncated \(it has no END-ISO-10303-21;\)"),
        ("ISO-10303-21;\nnonsense\nEND-ISO-10303-21;\n", r"is a broken IFC"),
    ],
)
def test_what_is_no_ifc_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.ifc").write_text(text)
    with pytest.raises(FileFormatError, match=message):
        read_model(tmp_path / "a.ifc")


def test_an_ifc_without_geometry_has_nothing_to_show(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="has no triangles to show"):
        read_model(Ifc().write(tmp_path / "a.ifc"))


def test_an_ifc_knows_its_units_itself(tmp_path: Path) -> None:
    path = flat().write(tmp_path / "a.ifc")
    with pytest.raises(InputError, match="an IFC states its own units and axes"):
        read_model(path, units="mm")


def test_a_missing_ifcopenshell_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = flat().write(tmp_path / "a.ifc")
    real = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.startswith("ifcopenshell"):
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingDependencyError, match=r"pip install 'belvedere\[ifc\]'"):
        read_model(path)


def test_a_section_finds_outlines_and_holes() -> None:
    def walls(ring: np.ndarray) -> list[np.ndarray]:
        found = []
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            low_a, low_b, high_a, high_b = ([*p, z] for z in (0.0, 2.0) for p in (a, b))
            found += [np.array([low_a, low_b, high_b]), np.array([high_b, low_a, high_a])]
        return found

    outer = np.array([[0, 0], [3, 0], [6, 0], [6, 4], [0, 4]], float)
    hole = np.array([[2, 1], [2, 3], [4, 3], [4, 1]], float)
    rings = section(np.array(walls(outer) + walls(hole)), 1.0)
    assert sorted(len(r) for r in rings) == [4, 4]  # the corner at (3, 0) is none
    probes = np.array([[1, 1], [3, 2], [5, 3.9], [7, 1]], float)
    assert inside(tuple(rings), probes).tolist() == [True, False, True, False]
    assert section(np.array(walls(outer)[:-1]), 1.0) == []  # a wall is missing


@pytest.fixture(scope="module")
def duplex(shared_data: Path) -> ImportedModel:
    return read_model(shared_data / "arch-duplex" / "Ifc2x3_Duplex_Architecture.ifc")


@pytest.fixture(scope="module")
def derived(shared_data: Path) -> dict[str, Any]:
    return json.loads((shared_data / "arch-duplex" / "derived" / "duplex_cells.json").read_text())


def test_all_rooms_of_the_duplex_have_their_outlines(
    duplex: ImportedModel, derived: dict[str, Any]
) -> None:
    rooms = building(duplex).rooms
    assert len(rooms) == len(derived["cells"]) == 21
    for room, cell in zip(rooms, derived["cells"], strict=True):
        assert room.name in (cell["long_name"], f"{cell['long_name']} ({cell['name']})")
        assert room.floor == pytest.approx(cell["z_floor"], abs=1e-3)
        assert room.ceiling == pytest.approx(cell["z_ceiling"], abs=1e-3)
        expected = tuple(np.array(ring) for ring in cell["footprint"])
        assert area(room.rings) == pytest.approx(area(expected), abs=0.02)
    assert Counter(r.storey for r in rooms) == {"Level 1": 10, "Level 2": 10, "Roof": 1}


def test_all_doors_and_windows_of_the_duplex_join_the_right_rooms(
    duplex: ImportedModel, derived: dict[str, Any]
) -> None:
    name_of = {
        c["id"]: r.name for c, r in zip(derived["cells"], building(duplex).rooms, strict=True)
    }
    openings = building(duplex).openings
    doors = [o for o in openings if o.kind == "door"]
    assert len(doors) == 14
    assert sum(None in o.rooms for o in doors) == 4
    assert sum(o.kind == "window" and " - " not in o.name for o in openings) == 24
    checked = 0
    for portal in derived["portals"]:
        if portal["type"] == "IfcOpeningElement":  # holes in kitchen furniture
            assert all(o.name != portal["name"] for o in openings)
            continue
        found = by_name(duplex, portal["name"])
        if "Skylight" in portal["name"]:  # taken for upright in the derived file
            assert "Roof" in found.rooms
            continue
        checked += 1
        assert set(found.rooms) == {None if c is None else name_of[c] for c in portal["cells"]}
        ours = found.corners[np.lexsort(np.rint(found.corners * 100).T)]
        theirs = np.array(portal["polygon"])
        theirs = theirs[np.lexsort(np.rint(theirs * 100).T)]
        np.testing.assert_allclose(ours, theirs, atol=2e-3)
    assert checked == 36


def test_open_kitchens_and_stairs_of_the_duplex_are_joined(duplex: ImportedModel) -> None:
    joins = [o for o in building(duplex).openings if " - " in o.name]
    pairs = {frozenset(o.rooms) for o in joins}
    for flat_, stair in (("A", "Stair"), ("B", "Room")):
        for a, b in ((f"Living Room ({flat_}102)", f"Kitchen ({flat_}103)"),
                     (f"Foyer ({flat_}101)", stair), (f"Hallway ({flat_}201)", stair),
                     (f"Living Room ({flat_}102)", f"Foyer ({flat_}101)")):  # fmt: skip
            assert frozenset((a, b)) in pairs
    # nothing joins the two flats
    assert not any(
        "(A" in str(sorted(map(str, p))) and "(B" in str(sorted(map(str, p))) for p in pairs
    )


def test_the_duplex_and_its_obj_are_the_same_house(
    duplex: ImportedModel, shared_data: Path
) -> None:
    obj = read_model(shared_data / "arch-duplex" / "derived" / "duplex.obj")
    np.testing.assert_allclose(obj.mesh.bounds, duplex.mesh.bounds, atol=1e-3)
    assert (obj.source.up, obj.source.metres_per_unit) == ("z", 1.0)
    assert 25_500 < len(duplex.mesh.faces) < len(obj.mesh.faces) <= 26_348
    assert len(obj.names) > 200
