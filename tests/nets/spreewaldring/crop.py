"""Reduce an OpenStreetMap extract to roads, buildings and meadows, without authors and dates."""

import sys
import xml.etree.ElementTree as ET

KEPT = ("access", "building", "highway", "landuse", "lanes", "maxspeed", "oneway", "service", "surface")


def tags(way: ET.Element) -> dict[str, str]:
    return {tag.attrib["k"]: tag.attrib["v"] for tag in way.iter("tag")}


def wanted(way: ET.Element) -> bool:
    return bool({"highway", "building"} & tags(way).keys()) or tags(way).get("landuse") == "grass"


source, target = sys.argv[1:]
extract = ET.parse(source).getroot()
ways = [way for way in extract.iter("way") if wanted(way)]
used = {node.get("ref") for way in ways for node in way.iter("nd")}
cropped = ET.Element("osm", version="0.6", copyright="OpenStreetMap contributors", license="ODbL 1.0")
cropped.extend(extract.iter("bounds"))
for node in extract.iter("node"):
    if node.get("id") in used:
        ET.SubElement(cropped, "node", {key: node.attrib[key] for key in ("id", "lat", "lon")})
for way in ways:
    kept = ET.SubElement(cropped, "way", id=way.attrib["id"])
    kept.extend(way.iter("nd"))
    kept.extend(tag for tag in way.iter("tag") if tag.get("k") in KEPT)
ET.indent(cropped, " ")
ET.ElementTree(cropped).write(target, encoding="UTF-8", xml_declaration=True)
