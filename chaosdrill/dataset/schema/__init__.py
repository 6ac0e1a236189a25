"""One table of every variable that an analysis may put out.

Attributes, checks, documentation and tests all follow from ``SCHEMA``: kind of analysis -> name -> ``Variable``.

Some things depend on the system and the request at hand and stand in the table as placeholders: ``SWEEP`` (each swept
parameter, or each state that spans a grid of initial states, as a dimension and as its coordinate), ``QUADRATURE``
(each integral that the system carries along), and ``ORBIT`` (the leading dimension ``orbit`` of a search, and nothing
where one orbit was asked for). States are the dimension ``state`` with the coordinate ``state_name``, since a variable
``state`` with more dimensions exists too.
"""

from chaosdrill.dataset.schema.orbits import CONTINUATION, PERIODIC_ORBIT
from chaosdrill.dataset.schema.points import BASINS, BIFURCATION_DIAGRAM, PARAMETER_CHART
from chaosdrill.dataset.schema.precision import WORK_PRECISION
from chaosdrill.dataset.schema.runs import LYAPUNOV_SPECTRUM, POINCARE_SECTION, TRAJECTORY
from chaosdrill.dataset.schema.variable import ORBIT, PLACEHOLDERS, QUADRATURE, SWEEP, Variable

__all__ = ["ORBIT", "PLACEHOLDERS", "QUADRATURE", "RESERVED", "SCHEMA", "SWEEP", "Variable"]

_TABLES = {
    "trajectory": TRAJECTORY,
    "poincare-section": POINCARE_SECTION,
    "lyapunov-spectrum": LYAPUNOV_SPECTRUM,
    "bifurcation-diagram": BIFURCATION_DIAGRAM,
    "parameter-chart": PARAMETER_CHART,
    "basins": BASINS,
    "periodic-orbit": PERIODIC_ORBIT,
    "continuation": CONTINUATION,
    "work-precision": WORK_PRECISION,
}

SCHEMA: dict[str, dict[str, Variable]] = {kind: {v.name: v for v in table} for kind, table in _TABLES.items()}

RESERVED = (
    frozenset(
        name for table in SCHEMA.values() for variable in table.values() for name in (variable.name, *variable.dims)
    )
    - PLACEHOLDERS
)
"""Names of the variables and dimensions of results, which no quadrature and no swept parameter can have."""
