"""Entities of an OpenSCENARIO file, described in it or in its catalogs."""

from pathlib import Path

from luxloop.sim.openscenario.expressions import resolve
from luxloop.sim.openscenario.storyboard import Entity
from luxloop.sim.world import Kind
from luxloop.sim.xml_tree import XmlElement, read_xml

KINDS = {
    "car": Kind.CAR,
    "van": Kind.VAN,
    "truck": Kind.TRUCK,
    "bus": Kind.BUS,
    "motorbike": Kind.MOTORCYCLE,
    "bicycle": Kind.BICYCLE,
    "pedestrian": Kind.PEDESTRIAN,
}
"""Kinds by vehicle or pedestrian category."""
CATALOGS = {"VehicleCatalog": "Vehicle", "PedestrianCatalog": "Pedestrian"}


def read_entities(tree: XmlElement, folder: Path) -> dict[str, Entity]:
    """Read the entities of a file in a folder, by name.

    Raises
    ------
    TrafficInputError
        An entity has a controller, a trailer or an unknown category, or is not in its catalog.
    """
    entities: dict[str, Entity] = {}
    for element in tree.need("Entities").children:
        if element.tag != "ScenarioObject":
            raise element.error("is not supported; list its entities one by one")
        entity = _entity(element, tree, folder)
        if entity.name in entities:
            raise element.error("has the name of another entity; give it its own")
        entities[entity.name] = entity
    return entities


def _entity(element: XmlElement, tree: XmlElement, folder: Path) -> Entity:
    described = [child for child in element.children if child.tag != "ObjectController"]
    if len(described) != 1:
        raise element.error("should have one Vehicle, Pedestrian or CatalogReference")
    for controller in element.all("ObjectController"):
        _refuse_controller(controller)
    body = described[0]
    if body.tag == "CatalogReference":
        body = _from_catalog(body, tree, folder)
    if body.tag not in CATALOGS.values():
        raise body.error("is no supported entity; use Vehicle or Pedestrian")
    for trailer in body.all("Trailer"):
        if any(child.attributes.get("entityRef") != "" for child in trailer.children):
            raise trailer.error("is not supported; choose a vehicle without a trailer")
    category = "vehicleCategory" if body.tag == "Vehicle" else "pedestrianCategory"
    meaning = body.choice(category, {name: name for name in KINDS})
    box, name = body.need("BoundingBox"), element.text("name")
    centre, size = box.need("Center"), box.need("Dimensions")
    length, width, height = (size.number(side) for side in ("length", "width", "height"))
    if min(length, width, height) <= 0:
        raise size.error("should have a positive length, width and height")
    return Entity(name, KINDS[meaning], (length, width, height), (centre.number("x"), centre.number("y")))


def _refuse_controller(element: XmlElement) -> None:
    """Raise for a controller; an empty element assigns none."""
    for child in element.children:
        name = child.attributes.get("entryName", child.attributes.get("name", ""))
        raise element.error(
            f'assigns the controller "{name}", which is not supported; remove it, so that the storyboard alone moves '
            "the entity"
        )


def _from_catalog(reference: XmlElement, tree: XmlElement, folder: Path) -> XmlElement:
    """Return the entry that a reference names, with its parameters resolved."""
    catalog, entry = reference.text("catalogName"), reference.text("entryName")
    assigned = {
        one.text("parameterRef").removeprefix("$"): one.text("value")
        for group in reference.all("ParameterAssignments")
        for one in group.children
    }
    folders = [
        folder / place.need("Directory").text("path")
        for place in tree.need("CatalogLocations").children
        if place.tag in CATALOGS
    ]
    for path in sorted(path for place in folders if place.is_dir() for path in place.glob("*.xosc")):
        for one in read_xml(path, "OpenSCENARIO").all("Catalog"):
            for found in one.children if one.attributes.get("name") == catalog else []:
                if found.attributes.get("name") == entry:
                    resolve(found, {}, assigned)
                    return found
    searched = ", ".join(str(place) for place in folders) or "no folder"
    raise reference.error(f'finds no entry "{entry}" of catalog "{catalog}" in {searched}; correct CatalogLocations')


def require_entity(element: XmlElement, entities: dict[str, Entity]) -> str:
    """Return the entity that the attribute `entityRef` names.

    Raises
    ------
    TrafficInputError
        There is no such entity.
    """
    name = element.text("entityRef")
    if name not in entities:
        raise element.error(f'entityRef = "{name}" is no entity; use one of {", ".join(entities)}')
    return name
