"""Elementary functions: their accuracy against 80-bit arithmetic, special values, and the same bits everywhere."""

import ast
import hashlib
import math
from pathlib import Path

import numpy as np
import pytest
import scipy.special

from luxloop import elementary, elementwise

ROOT = Path(__file__).parents[1]
RNG = np.random.default_rng(7)
ARGUMENTS = {
    "sin": RNG.uniform(-60.0, 60.0, 20_000),
    "cos": RNG.uniform(-60.0, 60.0, 20_000),
    "tan": RNG.uniform(-1.5, 1.5, 20_000),
    "exp": RNG.uniform(-80.0, 80.0, 20_000),
    "log": np.concatenate([10.0 ** RNG.uniform(-20.0, 20.0, 10_000), 1.0 + RNG.normal(0.0, 1e-3, 10_000)]),
    "log1p": np.concatenate([RNG.normal(0.0, 1e-4, 10_000), RNG.uniform(-0.99, 9.0, 10_000)]),
    "log10": 10.0 ** RNG.uniform(-20.0, 20.0, 20_000),
}
ULP_MAX = {"tan": 3.0, "log1p": 3.0}
SCALARS = {"asin": RNG.uniform(-1.0, 1.0, 3_000), "acos": RNG.uniform(-1.0, 1.0, 3_000)}
LIBRARY = {"asin": np.arcsin, "acos": np.arccos}
needs_80_bits = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="no longer floating-point numbers here")


def ulps(value, exact):
    """Return the largest error in units in the last place."""
    return float(np.max(np.abs(np.asarray(value) - exact) / np.spacing(np.abs(exact.astype(float)))))


@needs_80_bits
@pytest.mark.parametrize("name", ARGUMENTS)
def test_functions_of_arrays_have_an_error_below_two_units_in_the_last_place(name):
    x = ARGUMENTS[name]
    exact = getattr(np, name)(x.astype(np.longdouble))
    assert ulps(getattr(elementwise, name)(x), exact) < ULP_MAX.get(name, 2.0)


@needs_80_bits
@pytest.mark.parametrize("name", SCALARS)
def test_functions_of_numbers_have_an_error_below_two_units_in_the_last_place(name):
    x = SCALARS[name]
    value = [getattr(elementary, name)(each) for each in x.tolist()]
    assert ulps(value, LIBRARY[name](x.astype(np.longdouble))) < 2.0


@needs_80_bits
def test_the_angle_of_points_in_all_quadrants():
    y, x = RNG.normal(0.0, 5.0, (2, 20_000))
    assert ulps(elementwise.atan2(y, x), np.arctan2(y.astype(np.longdouble), x.astype(np.longdouble))) < 2.0


def test_the_reduction_of_angles_near_multiples_of_a_quarter_turn():
    """A reduction by a single double of pi has no correct digit left there."""
    turns = np.arange(1, 3000) * (0.5 * math.pi)
    assert np.allclose(elementwise.sin(turns), np.sin(turns), rtol=0.0, atol=1.2e-16)
    assert np.allclose(elementwise.cos(turns), np.cos(turns), rtol=0.0, atol=1.2e-16)
    zeros = elementwise.sin(turns[1::2])
    assert np.allclose(zeros, np.sin(turns[1::2]), rtol=1e-12, atol=0.0)


@pytest.mark.parametrize("y", [0.0, -0.0, 1.0, -2.0, math.inf, -math.inf, math.nan])
@pytest.mark.parametrize("x", [0.0, -0.0, 3.0, -0.5, math.inf, -math.inf, math.nan])
def test_angles_of_special_points_have_the_signs_of_ieee_754(y, x):
    expected, angle = math.atan2(y, x), elementary.atan2(y, x)
    assert angle == pytest.approx(expected, rel=4e-16, abs=0.0, nan_ok=True)
    assert math.copysign(1.0, angle) == math.copysign(1.0, expected) or math.isnan(angle)


def test_special_values():
    assert elementwise.exp([0.0, -math.inf, math.inf, 1000.0, -1000.0]).tolist() == [1.0, 0.0, math.inf, math.inf, 0.0]
    assert elementwise.log([1.0, 0.0, math.inf]).tolist() == [0.0, -math.inf, math.inf]
    assert np.isnan(
        [elementary.log(-1.0), elementary.exp(math.nan), elementary.sin(math.inf), elementary.acos(1.1)]
    ).all()
    assert elementary.log1p(1e-300) == 1e-300
    assert elementary.exp(709.7) == pytest.approx(math.exp(709.7), rel=1e-15)
    assert elementary.exp(-740.0) == pytest.approx(math.exp(-740.0), abs=5e-324)


def test_factorials_error_function_and_powers():
    numbers = np.arange(300)
    value = [elementary.log_factorial(n) for n in numbers.tolist()]
    assert value == pytest.approx(scipy.special.gammaln(numbers + 1.0), rel=1e-14)
    x = np.linspace(-6.0, 20.0, 700)
    assert [elementary.erfc(each) for each in x.tolist()] == pytest.approx(scipy.special.erfc(x), rel=1e-12, abs=1e-15)
    assert elementary.power(12.5, 0.67) == pytest.approx(12.5**0.67, rel=1e-14)
    assert elementary.expm1(1e-9) == math.expm1(1e-9)
    assert elementary.rotation(0.5 * math.pi) == pytest.approx(1j)


@pytest.mark.parametrize(
    ("one", "other"),
    [((4, 3), (3, 2)), ((3,), (3, 2)), ((4, 3), (3,)), ((3,), (3,)), ((5, 2, 3), (5, 3, 4)), ((2, 0), (0, 3))],
)  # fmt: skip
def test_products_are_those_of_numpy(one, other):
    left, right = RNG.normal(size=one), RNG.normal(size=other)
    assert np.allclose(elementwise.product(left, right), left @ right, rtol=1e-14, atol=1e-15)


def test_inverses_of_positive_definite_matrices():
    root = RNG.normal(size=(50, 3, 3))
    matrix = root @ root.transpose(0, 2, 1) + 0.1 * np.eye(3)
    assert np.allclose(elementwise.inverse(matrix) @ matrix, np.eye(3), atol=1e-10)


def test_the_bits_are_those_of_every_other_machine():
    """A digest that was made with AVX-512; a processor without it, or with another C library, gives the same."""
    digest = hashlib.sha256()
    grid = np.arange(-4000, 4001) / 128.0
    for name in ARGUMENTS:
        x = np.abs(grid) + 1e-3 if name.startswith("log") else grid
        digest.update(getattr(elementwise, name)(x).tobytes())
    digest.update(elementwise.atan2(grid, grid[::-1] + 0.1).tobytes())
    digest.update(np.array([elementary.erfc(x) for x in grid[::9].tolist()]).tobytes())
    digest.update(elementwise.product(grid[:60].reshape(20, 3), grid[-60:].reshape(3, 20)).tobytes())
    assert digest.hexdigest()[:16] == "a1cb5269d7bd08e9"


FUNCTIONS = {
    "sin",
    "cos",
    "tan",
    "atan",
    "atan2",
    "asin",
    "acos",
    "exp",
    "expm1",
    "log",
    "log1p",
    "log10",
    "hypot",
    "erfc",
    "lgamma",
    "pow",
}
OF_ARRAYS = FUNCTIONS | {"arctan", "arctan2", "arcsin", "arccos", "power", "einsum", "dot", "matmul"}
OF_LIBRARIES = {"linalg.inv", "linalg.solve", "linalg.eigh", "linalg.eig", "linalg.svd", "linalg.det"}
OWN_ARITHMETIC = {
    "tracker/tracking/model_selection.py": "filterpy multiplies by itself",
    "sim/openscenario/expressions.py": "expressions in files",
}


@pytest.mark.parametrize("package", ["sim", "sensor_model", "tracker"])
def test_no_result_depends_on_functions_that_differ_between_processors(package):
    found = []
    for path in sorted((ROOT / package).rglob("*.py")):
        name = str(path.relative_to(ROOT))
        if name not in OWN_ARITHMETIC:
            found += [f"{name}:{line} {what}" for line, what in differing(ast.parse(path.read_text(encoding="utf-8")))]
    assert found == []


def differing(tree):
    """Yield line and name of calls and products in functions; constants of modules are the same everywhere."""
    for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
        for node in ast.walk(function):
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
                yield node.lineno, "@"
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                called = ast.unparse(node.func)
                module, _, name = called.partition(".")
                if (module == "math" and name in FUNCTIONS) or (module == "np" and name in OF_ARRAYS | OF_LIBRARIES):
                    yield node.lineno, called
