"""XML files as trees whose elements know file and line, for error messages.

Document type declarations are refused, so that entities neither expand without limit nor read other files.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from luxloop.sim.source import TrafficInputError

DEEPEST = 200
"""Maximum depth of a tree; OpenSCENARIO and OpenDRIVE need about 20."""


@dataclass(slots=True, eq=False)
class XmlElement:
    """An element of an XML file. Namespaces and text are not kept."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    parent: "XmlElement | None" = None
    children: list["XmlElement"] = field(default_factory=list)

    def all(self, tag: str) -> list["XmlElement"]:
        """Return the children with a tag."""
        return [child for child in self.children if child.tag == tag]

    def find(self, *path: str) -> "XmlElement | None":
        """Return the first descendant along a path of tags, or None."""
        element = self
        for tag in path:
            found = element.all(tag)
            if not found:
                return None
            element = found[0]
        return element

    def need(self, *path: str) -> "XmlElement":
        """Return the first descendant along a path of tags, or raise."""
        if (found := self.find(*path)) is None:
            raise self.error(f"has no <{'/'.join(path)}>; add it")
        return found

    def only(self) -> "XmlElement":
        """Return the only child, or raise."""
        if len(self.children) != 1:
            raise self.error(f"should have exactly one child, not {len(self.children)}")
        return self.children[0]

    def walk(self) -> Iterator["XmlElement"]:
        """Yield the element and all its descendants."""
        yield self
        for child in self.children:
            yield from child.walk()

    def text(self, name: str, default: str | None = None) -> str:
        """Return an attribute, or raise if it is missing and has no default."""
        value = self.attributes.get(name, default)
        if value is None:
            raise self.error(f'has no attribute "{name}"; add it')
        return value

    def number(self, name: str, default: float | None = None) -> float:
        """Return an attribute as a finite number."""
        value = self.text(name, None if default is None else str(default))
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not abs(number) <= 1e9:
            raise self.error(f'{name} = "{value[:60]}" should be a number within 1e9')
        return number

    def whole(self, name: str) -> int:
        """Return an attribute as an integer."""
        number = self.number(name)
        if number != round(number):
            raise self.error(f'{name} = "{self.text(name)}" should be an integer')
        return round(number)

    def choice(self, name: str, values: Mapping[str, str], default: str | None = None) -> str:
        """Return the meaning of an attribute, one of the keys of `values`."""
        value = self.text(name, default)
        if value not in values:
            raise self.error(f'{name} = "{value[:60]}" is not supported; use {" or ".join(values)}')
        return values[value]

    def error(self, reason: str) -> TrafficInputError:
        """Return an error that names file, line, element and the nearest named element around it."""
        around = self
        while not around.attributes.get("name") and around.parent is not None:
            around = around.parent
        name = around.attributes.get("name", "")
        place = f'<{self.tag}> "{name}"' if around is self and name else f"<{self.tag}>"
        if around is not self and name:
            place += f' of {around.tag} "{name}"'
        return TrafficInputError(f"{self.file}, line {self.line}: {place} {reason}")


def read_xml(path: Path, root: str) -> XmlElement:
    """Read an XML file.

    Parameters
    ----------
    path
        The file.
    root
        Tag of its root.

    Raises
    ------
    TrafficInputError
        The file is missing or not XML, declares a document type, is nested too deeply or has another root.
    """
    builder = _Builder(path.name)
    try:
        builder.parser.Parse(path.read_bytes(), True)
    except FileNotFoundError as error:
        raise TrafficInputError(f"{path.name}: no such file in {path.parent}") from error
    # LookupError and ValueError: unknown and multi-byte encodings, null bytes in paths
    except (OSError, expat.ExpatError, LookupError, ValueError) as error:
        raise TrafficInputError(f"{path.name}: not a complete XML file: {error}") from error
    tree = builder.top.children[0]
    if tree.tag != root:
        raise TrafficInputError(f"{path.name}: its root is <{tree.tag}>; it should be <{root}>")
    return tree


class _Builder:
    """Builder of the tree of one file."""

    def __init__(self, file: str):
        self.top = XmlElement("", {}, file, 0)
        self._open = [self.top]
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._doctype

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        parent = self._open[-1]
        element = XmlElement(tag, attributes, self.top.file, self.parser.CurrentLineNumber, parent)
        if len(self._open) > DEEPEST:
            raise element.error(f"is nested more than {DEEPEST} levels deep")
        parent.children.append(element)
        self._open.append(element)

    def _end(self, _: str) -> None:
        self._open.pop()

    def _doctype(self, *_: object) -> None:
        raise TrafficInputError(
            f"{self.top.file}: has a document type declaration (DOCTYPE), which is refused; remove it"
        )
