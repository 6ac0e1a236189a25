"""The dimensionless drill does not depend on the units that its quantities are written in."""

from hypothesis import given
from hypothesis import strategies as st

from chaosdrill.systems.drill.si import QUANTITIES, metres_per_hour, si_to_dimensionless
from chaosdrill.units import FORCE, LENGTH

positive = st.floats(1e-3, 1e3)
factors = st.floats(1e-2, 1e2)


@given(
    st.fixed_dictionaries({name: positive for name in QUANTITIES if name not in ("n", "omega")}),
    st.floats(0.8, 2.5),
    st.tuples(factors, factors, factors),
)
def test_change_of_units(quantities, exponent, units):
    quantities |= {"n": exponent}
    stiffness = tuple(f - exponent * m for f, m in zip(FORCE, LENGTH, strict=True))
    rescaled = {}
    for name, value in quantities.items():
        dimension = stiffness if name == "k_c" else QUANTITIES[name].dimension
        mass, length, time = (unit**power for unit, power in zip(units, dimension[:3], strict=True))
        rescaled[name] = value * mass * length * time
    before, scales = si_to_dimensionless(quantities)
    after, others = si_to_dimensionless(rescaled)
    assert before.keys() == after.keys() >= {"a", "b", "xi", "eps", "eta", "mu", "g", "r", "lam", "n", "k", "phi"}
    for name, value in before.items():
        assert abs(after[name] / value - 1) < 1e-9, name
    ratio = metres_per_hour(others) / metres_per_hour(scales)
    assert abs(ratio * units[2] / units[1] - 1) < 1e-9
