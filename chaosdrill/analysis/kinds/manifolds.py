"""Invariant manifolds of saddles: the curves that separate basins, and those on which attractors lie."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from chaosdrill.analysis.base import ORBITS, Dataset, HybridSystem, Job, Orbit, analysis
from chaosdrill.analysis.starting_states import Region, Start
from chaosdrill.dataset.curves import CurveBreak, CurveEnd
from chaosdrill.dataset.schema import ITERATE, MULTIPLIER, STATES, axis, forcing, need, outcome, table
from chaosdrill.settings import Choice, Faults, Number, Whole, setting

_PARTS = "In parts of the sides of the region."

VARIABLES = table(
    *STATES,
    MULTIPLIER,
    ITERATE,
    axis("curve_number", "curve_number", "i4", "number of the curve", "Place in the table of curves, from 1.", True),
    need("curve_state", "point state", "f8", "state on the curve", "From the orbit on, curve after curve."),
    need("curve", "point", "i4", "number of the curve", "That the point belongs to, from 1."),
    need("part", "point", "i4", "part of the curve", "Neighbours of one part are joined; a jump begins another."),
    need("arclength", "point", "f8", "arclength", f"From the orbit, without jumps. {_PARTS}"),
    need("generation", "point", "i4", "iterates of the first segment", "After which the curve comes to the point."),
    need("curve_error", "point", "f8", "error across the curve", f"Of the first segment and all steps. {_PARTS}"),
    need("curve_stable", "curve_number", "i1", "stable manifold", "Or the unstable one.", flags="truth"),
    need("curve_point", "curve_number", "i4", "point of the orbit", "On the section, from which it comes, from 1."),
    need("curve_side", "curve_number", "i1", "branch", "1 and -1: in the direction of the eigenvector, or against it."),
    need("curve_multiplier", "curve_number", "f8", "multiplier", "Of the orbit; below 0 branches change places."),
    need("curve_length", "curve_number", "f8", "length of the curve", f"Without jumps. {_PARTS}"),
    need("curve_end", "curve_number", "i1", "how the curve ends", "As a code.", flags=CurveEnd),
    need("break_curve", "break", "i4", "curve of the break", "Number of the curve, from 1."),
    need("break_point", "break", "i4", "point before the break", "Index of the point, from 0."),
    need("break_arclength", "break", "f8", "arclength at the break", _PARTS),
    need("break_kind", "break", "i1", "kind of the break", "What happens there.", flags=CurveBreak),
    need("break_jump", "break", "i1", "jump", "Whether the curve is cut, or has a corner.", flags="truth"),
    need("break_size", "break", "f8", "size of the break", f"Distance of both sides. {_PARTS} NaN for an end."),
    need("break_generation", "break", "i4", "first iterate with the break", "Later ones are its images."),
    need("break_state", "break state", "f8", "state before the break", "Whose motion grazes, or changes its events."),
    need("crossing_state", "crossing state", "f8", "state at a crossing", "Of an unstable and a stable curve."),
    need("crossing_error", "crossing", "f8", "error of the crossing", f"From chords and curves. {_PARTS}"),
    need("crossing_angle", "crossing", "f8", "angle of the crossing", f"0: a tangency. {_PARTS}", "rad"),
    need("crossing_unstable", "crossing", "i4", "unstable curve at the crossing", "Number of the curve, from 1."),
    need("crossing_stable", "crossing", "i4", "stable curve at the crossing", "Number of the curve, from 1."),
    need("orbit_section", "iterate state", "f8", "saddle on the section", "Its points, before its events."),
    need("multiplier_real", "multiplier", "f8", "multiplier, real part", "Of the saddle."),
    need("multiplier_imag", "multiplier", "f8", "multiplier, imaginary part", "Of the saddle."),
    need("region", "end state", "f8", "region", "Lower and upper ends of the region."),
    outcome(""),
    *forcing(),
    sampled=(),
    magnitude=("curve_error", "crossing_error"),
)


class NearOrbit(Start):
    """States near an orbit, or the orbit itself as `periodic_orbit` gives it."""

    type_name = "mapping or Dataset"

    def plain(self, value: Any) -> Any:
        if not isinstance(value, Mapping):
            return value
        return {str(key): one if key == "mode" else Number().plain(one) for key, one in value.items()}


@dataclass(frozen=True, kw_only=True)
class Manifolds(Orbit):
    """Settings of `manifolds`."""

    reserves: ClassVar[bool] = False
    meanings: ClassVar[Mapping[str, str]] = {
        "period": "Period of the saddle, as in `periodic_orbit`: one of a longer period has curves at each of its "
        "points.",
        "at": "Of a system without forcing: its section, as in `poincare_section`. Stable manifolds need a "
        "surface, where nothing changes.",
    }

    orbit: Any = setting(
        NearOrbit(),
        None,
        positional=True,
        doc='States near the saddle, ``{"x": 0.63, "y": 0.19}``, from which Newton\'s method starts in place of '
        "the system's initial state; or a result of `periodic_orbit`, which tells the period as well.",
    )
    start: str = setting(
        Choice(("guess", "attractor")),
        "guess",
        doc="Where Newton's method starts: at the states near the saddle, or at the state of a run after "
        "``transient``.",
    )
    of: str = setting(Choice(("both", "unstable", "stable")), "both", doc="Which manifolds are grown.")
    region: dict[str, Any] | None = setting(
        Region(),
        None,
        doc="What is shown, and the measure of lengths: those below are in parts of its sides. Curves are "
        "followed half a side beyond it. Default: twice the largest values on the motion from the initial "
        "state, on both sides of zero.",
    )
    length: float = setting(Number(above=0, most=1e6), 10.0, doc="Length of each branch.")
    spacing: float = setting(Number(above=0, most=0.5), 0.01, doc="Largest distance of neighbouring points.")
    accuracy: float = setting(
        Number(least=1e-12, most=1e-3), 1e-8, doc="Largest error of the first segment, and of the place of a break."
    )
    max_points: int = setting(Whole(100, 10_000_000), 20_000, doc="Points of each branch.")

    @classmethod
    def read(cls, given: Mapping[str, Any], system: Any) -> Self:
        """The settings; an orbit as a dataset tells its period and its section, too."""
        if "orbit_state" in getattr(given.get("orbit"), "variables", ()):
            given = {**given, **_of_dataset(given, given["orbit"])}
        return super().read(given, system)

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """As for every orbit; and a flow without a section, on which its orbits would be points."""
        yield from super().misfits(table, system)
        if not system.forced and table.get("at") is None:
            from chaosdrill.analysis.arguments import example_of_section

            words = f"{system.name} has no forcing period, and so no strobe; name a section, as in "
            yield (), words + example_of_section(system)


def _of_dataset(given: Mapping[str, Any], orbit: Any) -> dict[str, Any]:
    """What a dataset of `periodic_orbit` tells: a state, the mode, the period, and the section."""
    from chaosdrill.dataset import Outcome
    from chaosdrill.errors import SettingsError

    if "orbit" in orbit.dims:
        raise SettingsError(f"orbit holds {orbit.sizes['orbit']} orbits; choose one, as in found.isel(orbit=0)")
    if int(orbit["outcome"]) != Outcome.PERIODIC:
        raise SettingsError(f"orbit is not an orbit: its outcome is {Outcome(int(orbit['outcome'])).meaning!r}")
    names = [str(name) for name in orbit["state"].values]
    near: dict[str, Any] = dict(zip(names, orbit["orbit_state"].values.tolist(), strict=True))
    modes = str(orbit["mode"].attrs.get("flag_meanings", "")).split()
    if len(modes) > 1:
        near["mode"] = modes[int(orbit["mode"])]
    found: dict[str, Any] = {"orbit": near}
    if given.get("period") in (None, 1):
        found["period"] = max(1, int(orbit["period"]))
    return found


@analysis(
    "manifolds",
    Manifolds,
    "stable and unstable curves of a saddle, with their breaks and crossings",
    VARIABLES,
    cites=(*ORBITS, "hobson1993", "krauskopf1998"),
)
def manifolds(system: HybridSystem, given: Manifolds, job: Job) -> Dataset:
    """The stable and the unstable manifold of a saddle, where they are curves, on a section.

    The section is the strobe of a forcing, every iterate of a map, or an event or surface of a system without forcing.
    The unstable manifold is made of the points that come from the saddle, the stable one of those that go to it: the
    first leads to attractors and lies in chaotic ones, the second bounds basins. Each has two branches.

    A branch is the sequence of images of a first segment, from a point beside the saddle, along its eigenvector, to the
    image of that point (Hobson 1993). The segment is so short that by a test of second order the manifold is straight
    over it to the ``accuracy``. Points are inserted into it, never into its images, until in every image neighbours
    are closer than ``spacing``, their chords turn by at most 0.3, and angle times length is at most a tenth of the
    spacing (Krauskopf and Osinga 1998). Errors across the curve shrink from image to image; ``curve_error`` carries
    them along. With a negative multiplier the two branches change places in every image.

    The stable manifold is followed by preimages: Newton's method on the map from the neighbour's preimage, with the
    derivatives of the run. Over a reset, where neighbours have preimages far apart, it begins at those of a grid of
    starts whose images are nearest. Where the map has no preimage near by, or loses rank, the branch ends.

    Where two neighbours meet other events the segment is halved between them down to the ``accuracy``: there is a
    break. At grazing the curve has a corner, as the square root in the map makes it; at other changes of events, such
    as one that passes the strobe, it is cut if it jumps. Every image of a break is a break.

    Returns
    -------
    xarray.Dataset
        ``curve_state`` (point, state), one curve after the other from the saddle on, with ``curve`` (its number),
        ``part``, ``arclength``, ``generation`` and ``curve_error`` (point); ``curve_stable``, ``curve_point``,
        ``curve_side``, ``curve_multiplier``, ``curve_length`` and ``curve_end`` (curve_number). Breaks:
        ``break_curve``, ``break_point``, ``break_arclength``, ``break_kind``, ``break_jump``, ``break_size``,
        ``break_generation`` and ``break_state`` (break). Homoclinic points, of systems with two states:
        ``crossing_state``, ``crossing_error``, ``crossing_angle``, ``crossing_unstable`` and ``crossing_stable``
        (crossing). Of the saddle: ``orbit_section`` (iterate, state), ``multiplier_real`` and ``multiplier_imag``
        (multiplier). ``region`` (end, state); ``outcome``: ``periodic``, ``no_saddle`` without a curve, or why there is
        no orbit; why a curve is missing stands in the attribute ``message``. Lengths, errors and angles are in parts of
        the region's sides.

    References
    ----------
    D. Hobson, "An efficient method for computing invariant manifolds of planar maps", J. Comput. Phys. 104 (1993)
    14-22, doi:10.1006/jcph.1993.1002. B. Krauskopf, H. Osinga, "Growing 1D and quasi-2D unstable manifolds of maps",
    J. Comput. Phys. 146 (1998) 404-419, doi:10.1006/jcph.1998.6059.
    """
    from chaosdrill.analysis.curves.invariant_curves import manifolds_dataset

    return manifolds_dataset(system, given, job)
