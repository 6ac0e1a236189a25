"""What several known answers need."""

import numpy as np
import pytest

import chaosdrill as cd


@pytest.fixture(scope="session")
def strobed():
    """An autonomous system looked at once every ``period`` time units, so that its cycles have multipliers."""

    def copy(system, period):
        return cd.HybridSystem(
            name=system.name,
            states=system.states,
            parameters=system.parameters,
            modes=system.modes,
            transitions=system.transitions,
            period=period,
            initial=system.initial,
        )

    return copy


@pytest.fixture(scope="session")
def multipliers():
    """Multipliers of a section, largest modulus first, the one with positive imaginary part before its conjugate."""

    def sort(section):
        values = section["multiplier_real"].values + 1j * section["multiplier_imag"].values
        return np.array(sorted(values, key=lambda z: (-round(abs(z), 9), -z.imag)))

    return sort


@pytest.fixture(scope="session")
def agrees():
    """Whether exponents lie within three standard errors of known ones, whose own errors count too."""

    def check(spectrum, known, own_errors):
        found = spectrum["lyapunov_exponent"].values
        error = np.hypot(spectrum["lyapunov_error"].values, own_errors)
        np.testing.assert_array_less(np.abs(found - known), 3 * error + 1e-12)
        return True

    return check
