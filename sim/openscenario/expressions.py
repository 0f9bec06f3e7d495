"""Parameters and expressions of OpenSCENARIO: `$name` and `${arithmetic}` in attributes."""

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping

from luxloop.sim.source import TrafficInputError
from luxloop.sim.xml_tree import XmlElement

LONGEST = 500
"""Maximum length of an expression."""
_NAME = re.compile(r"\$([A-Za-z_]\w*)")
_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Mod: math.fmod,
}
_FUNCTIONS: dict[str, Callable[..., float]] = {
    "abs": abs,
    "ceil": math.ceil,
    "floor": math.floor,
    "max": max,
    "min": min,
    "pow": math.pow,
    "round": round,
    "sign": lambda value: float((value > 0) - (value < 0)),
    "sqrt": math.sqrt,
}


def resolve(element: XmlElement, values: Mapping[str, str], fixed: Mapping[str, str] | None = None) -> None:
    """Replace parameters in the attributes of an element and of all below it.

    An attribute that names no known parameter, or whose expression is invalid, stays as it is: reading it as a number
    reports it, and attributes that are never read may contain anything.

    Parameters
    ----------
    element
        Root of the tree, which is changed.
    values
        Values by name that are declared around the element.
    fixed
        Values that replace those of the declarations directly in the element.

    Raises
    ------
    TrafficInputError
        `fixed` names a parameter that is not declared there.
    """
    scope, fixed = dict(values), fixed or {}
    declarations = [one for group in element.all("ParameterDeclarations") for one in group.children]
    names = [one.text("name").removeprefix("$") for one in declarations]
    if unknown := sorted(set(fixed) - set(names)):
        raise element.error(f"declares no parameter {unknown[0]}, only {', '.join(names) or 'none'}")
    for name, declaration in zip(names, declarations, strict=True):
        scope[name] = fixed.get(name, resolved(declaration.text("value"), scope))
    for name, text in element.attributes.items():
        if name != "parameterRef":
            element.attributes[name] = resolved(text, scope)
    for child in element.children:
        if child.tag != "ParameterDeclarations":
            resolve(child, scope)


def resolved(text: str, values: Mapping[str, str]) -> str:
    """Return the value of an attribute, or the text itself if it cannot be resolved."""
    if match := _NAME.fullmatch(text):
        return values.get(match[1], text)
    if not (text.startswith("${") and text.endswith("}")):
        return text
    try:
        return repr(_value(_NAME.sub(lambda name: f"({values[name[1]]})", text[2:-1])))
    except (KeyError, TrafficInputError):
        return text


def _value(expression: str) -> float:
    """Evaluate an expression of numbers.

    Raises
    ------
    TrafficInputError
        It is not arithmetic, or has no value.
    """
    try:
        if len(expression) > LONGEST:
            raise ValueError("too long")
        return float(_number(ast.parse(expression.strip(), mode="eval").body))
    except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError, MemoryError) as error:
        raise TrafficInputError(f"{expression}: {error}") from error


def _number(node: ast.expr) -> float:
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        case ast.UnaryOp(op=ast.USub()):
            return -_number(node.operand)
        case ast.UnaryOp(op=ast.UAdd()):
            return _number(node.operand)
        case ast.BinOp() if type(node.op) in _OPERATORS:
            return _OPERATORS[type(node.op)](_number(node.left), _number(node.right))
        case ast.Call(func=ast.Name(id=name), keywords=[]) if name in _FUNCTIONS:
            return float(_FUNCTIONS[name](*map(_number, node.args)))
        case _:
            raise ValueError("not arithmetic")
