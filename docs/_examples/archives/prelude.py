"""What the page takes for granted: an archive of a scene, parts of a sweep, and two runs."""

import numpy as np

import chaosdrill as cd

system = cd.build("impact-oscillator")


def sweep(start, stop):
    """A diagram over some frequencies."""
    return cd.bifurcation_diagram(
        system, {"omega": np.linspace(start, stop, 5)}, transient=50, periods=32, max_period=8
    )


def motion(**parameters):
    """A run over the same times, whatever the parameters."""
    return cd.trajectory(system.with_parameters(**parameters), periods=100)


cd.run("chaos.toml", "chaos.nc")
one, another, other_diagram = sweep(2.4, 2.5), sweep(2.6, 2.7), sweep(2.5, 2.6)
one, another = (part.rename(omega="eta") for part in (one, another))
run_of_one, run_of_another = motion(e=0.7), motion(e=0.8)
